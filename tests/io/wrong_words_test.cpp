// Every word of --detector over every detector there is, without names of classes: the right one is taken,
// and each other one is refused with the one that fits.
#include <tapestry/io/read_detector.hpp>

#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/catch.hpp"
#include "../support/paths.hpp"
#include "../support/small_exports.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using test::contains;

namespace {
/// Result of one word for a file: "" if it is read, "names" if only the number of classes is
/// missing, else the refusal.
std::string refusal(const std::string& path, const std::string& word) {
  try {
    static_cast<void>(io::read_detector<float>({.weights = path, .description = word}));
  } catch (const FileError& error) {
    CHECK(error.kind() == ErrorKind::mismatch);
    CHECK(error.details().path == path);
    return error.what();
  } catch (const Error& error) {
    CHECK_THAT(std::string(error.what()), contains("do not tell the number of classes"));
    return "names";
  }
  return "";
}

/// \param right  the only word that may be taken; empty for none
void require_only(const std::string& path, const std::string& right, bool needs_names = false) {
  for (const std::string_view word : detect::export_names) {
    CAPTURE(path, word);
    const std::string found = refusal(path, std::string(word));
    if (word == right) {
      CHECK(found == (needs_names ? "names" : ""));
      continue;
    }
    CHECK_THAT(found, contains("read by the word " + std::string(word) + ": not a"));
    CHECK_THAT(found,
               contains(right.empty() ? "its layers fit no family" : "its layers fit --detector " + right));
  }
}
}  // namespace

TEST_CASE("a wrong word is refused for every real detector",
          "[io][read_detector][words][bad_input]") {  // X31
  struct Model {
    const char *file, *right;
    bool needs_names = false;
  };
  const Model model = GENERATE(
      Model{"detectors/yolox_nano.onnx", "yolox"}, Model{"detectors/nanodet_m.onnx", "nanodet"},
      Model{"detectors/yolov5n_fp16.onnx", "yolov5"}, Model{"exports/yolov8_like/leg17.onnx", "yolov8"},
      Model{"exports/yolov8_like/ortopt.onnx", "yolov8"}, Model{"exports/yolov8_like/qdq.onnx", "yolov8"},
      Model{"exports/yolov10_like/leg17.onnx", "end_to_end", true},
      Model{"exports/yolo_with_nms/leg17.onnx", ""}, Model{"exports/faster_rcnn/leg17.onnx", "torchvision"},
      Model{"exports/mask_rcnn/leg13.onnx", "torchvision"}, Model{"exports/ssd/leg17.onnx", "torchvision"},
      Model{"exports/retinanet/leg17.onnx", "torchvision", true});
  const std::string path = test::in_shared(std::string("data/") + model.file);
  if (test::is_absent(path)) return;
  require_only(path, model.right, model.needs_names);
}

TEST_CASE("a wrong word is refused for small detectors of each family", "[io][read_detector][words]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("net.onnx");
  const auto require = [&](const nn::NetworkDescription& network, const char* right) {
    io::write_onnx(path, network);
    require_only(path, right);
  };
  const auto anchors = detect::known_description("yolov5").anchors;
  for (const std::size_t classes : {1U, 4U, 5U, 32U}) require(test::yolox_like(64, classes), "yolox");
  require(test::nanodet_like(64), "nanodet");
  require(test::nanodet_like(128, 4), "picodet");
  require(test::yolov5_like(64, anchors), "yolov5");
  require(test::yolov8_like(64), "yolov8");
  require(test::detr_like(64, false), "detr");
  require(test::detr_like(64, true), "rt_detr");
}

TEST_CASE("a description whose head is another one is refused by the same rule",
          "[io][read_detector][words]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("net.onnx");
  io::write_onnx(path, test::yolox_like(64));
  for (const std::string head : {"nanodet", "yolov8"})
    CHECK_THAT(
        refusal(path, folder.write("net.json", R"({"head": ")" + head + R"(", "strides": [8, 16, 32]})")),
        contains("not a detector of the kind " + head + ": filters of its last convolutions") &&
            contains("its layers fit --detector yolox"));
  const auto network = test::boxes_and_scores(64, 13);
  auto curved = network;
  curved.nodes.push_back({"", "Sigmoid", {network.outputs[1]}, {"probabilities"}, {}});
  curved.outputs[1] = "probabilities";
  io::write_onnx(path, curved);
  CHECK_THAT(
      refusal(path, folder.write("net.json", R"({"head": "boxes_and_scores", "outputs": {"score": "logit", )"
                                             R"("scores": "probabilities", "boxes": ")" +
                                                 network.outputs[0] + "\"}}")),
      contains("scores 'probabilities'") && contains("expected logits, found probabilities of"));
}

TEST_CASE("heads with another number of classes than the metadata name are refused",
          "[io][read_detector][words]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("net.onnx");
  auto network = test::yolox_like(64);
  network.metadata["names"] = "['a', 'b', 'c', 'd', 'e', 'f']";
  io::write_onnx(path, network);
  CHECK_THAT(refusal(path, ""), contains("not a detector of the classes that the model's metadata name") &&
                                    contains("expected 6, found 5"));
  CHECK(io::read_detector<float>({.weights = path, .names = folder.write("names", "a\nb\nc\nd\ne\n")})
            .names()
            .size() == 5);
}

TEST_CASE("a misspelt family is told from a file", "[io][read_detector][words]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("net.onnx");
  io::write_onnx(path, test::yolox_like(64));
  CHECK_THROWS_WITH(io::read_detector<float>({.weights = path, .description = "picodett"}),
                    contains("'picodett' is neither a file nor a family of exports; did you mean picodet?"));
}
