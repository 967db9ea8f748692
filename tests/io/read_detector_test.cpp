#include <tapestry/io/read_detector.hpp>

#include <tapestry/image/batch.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/paths.hpp"
#include "../support/raw_numbers.hpp"
#include "../support/refusal.hpp"
#include "../support/small_exports.hpp"
#include "../support/temporary_folder.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;
using test::check_refused;

namespace {
/// A Darknet network, as two files and as one, and an ONNX model.
struct Files {
  test::TemporaryFolder folder{};
  detect::DarknetModel<float> model = test::tiny_model<float>();
  std::string config = folder.write("tiny.cfg", test::tiny_network_text());
  std::string names = folder.write("tiny.names", "car\nvan\n");
  std::string weights = folder.path("tiny.weights"), converted = folder.path("tiny.onnx");
  std::string onnx = folder.path("net.onnx");

  Files() {
    io::write_weight_file(weights, model);
    static_cast<void>(io::write_detector_file(converted, model, test::tiny_network_text()));
    io::write_onnx(onnx, test::yolox_like(64));
  }
};

void check_refusal(const io::DetectorFiles& files, ErrorKind kind, const std::string& text) {
  check_refused(kind, text, [&] { static_cast<void>(io::read_detector<float>(files)); });
}
}  // namespace

TEST_CASE("one call opens a detector, whatever kind of file holds it", "[io][read_detector]") {
  const Files files;
  const auto pictures = test::random_array<float>({1, 48, 48, 3}, 1);
  const auto expected = detect::forward(files.model.detector(), pictures);
  std::vector<std::string> warnings{"gone"};
  for (const io::DetectorFiles& source : {io::DetectorFiles{.weights = files.weights, .config = files.config},
                                          io::DetectorFiles{.weights = files.converted}}) {
    const auto detector = io::read_detector<float>(source, &warnings);
    CHECK(detect::forward(detector, pictures) == expected);
    CHECK(warnings.empty());
    CHECK(detector.fit() == image::fit_by_name("letterbox"));
  }
  const auto detector = io::read_detector<double>({.weights = files.onnx, .fit = "stretch"});
  CHECK(detector.heads().size() == 3);
  CHECK(detector.fit().kind == image::FitKind::stretch);
  const detect::Detector<double> same(test::yolox_like(64), detect::known_description("yolox"));
  const auto photographs = test::random_array<double>({2, 64, 64, 3}, 2);
  CHECK(detect::forward(detector, photographs) == detect::forward(same, photographs));
}

TEST_CASE("a detector puts photographs in and finds boxes in their pixels", "[io][read_detector]") {
  const Files files;
  const auto detector = io::read_detector<float>({.weights = files.weights, .config = files.config});
  const auto photograph = test::random_array<float>({30, 60, 3}, 3);
  const auto input = detector.input(photograph);
  REQUIRE(input.shape() == Extents<4>{1, 48, 48, 3});
  CHECK(input(0, 2, 5, 1) == 0.5F);  // above the photograph, 24 rows of it from row 12 on
  const auto found = detector.detections(detect::forward(detector, input), 0, 0.05, 0.45);
  REQUIRE(!found.empty());
  const auto there = detector.in_photograph(found, 30, 60);
  CHECK(there.front().box.cx == Approx(found.front().box.cx * 60 / 48));
  CHECK(there.front().box.cy == Approx((found.front().box.cy - 12) * 30 / 24));
  CHECK(there.front().box.h == Approx(found.front().box.h * 30 / 24));
  for (std::size_t i = 1; i < found.size(); ++i) CHECK(found[i].confidence <= found[i - 1].confidence);
}

TEST_CASE("a class is known by its name or by its number", "[io][read_detector]") {
  const Files files;
  auto detector =
      io::read_detector<float>({.weights = files.weights, .config = files.config, .names = files.names});
  CHECK(detector.class_index("van") == 1);
  CHECK(detector.class_index("0") == 0);
  check_refused(ErrorKind::mismatch, "no class is named '2'; there are car, van",
                [&] { static_cast<void>(detector.class_index("2")); });
  check_refused(ErrorKind::mismatch, "no class is named 'Car'; there are car, van",
                [&] { static_cast<void>(detector.class_index("Car")); });
  detector.set_names({});
  CHECK(detector.class_index("1") == 1);
  check_refused(ErrorKind::mismatch, "class 2: the detector has 2 classes",
                [&] { static_cast<void>(detector.class_index("2")); });
  for (const char* word : {"van", "", "1x", "-1"})
    check_refused(ErrorKind::usage, "needs the names of the classes; without them it must be a number",
                  [&] { static_cast<void>(detector.class_index(word)); });
}

TEST_CASE("a description within an ONNX model is taken, and no other one beside it", "[io][read_detector]") {
  const Files files;
  auto network = test::yolov5_like(64, detect::known_description("yolov5").anchors);
  network.metadata[io::description_key] = R"({"head": "yolov5"})";
  const std::string model = files.folder.path("own.onnx");
  io::write_onnx(model, network);
  CHECK(io::read_detector<float>({.weights = model}).description() ==
        io::parse_detector_description(R"({"head": "yolov5"})", "text"));
  files.folder.write("own.json", R"({"head": "yolov5", "strides": [8, 16, 32],
      "anchors": [[10, 13, 16, 30, 33, 23], [30, 61, 62, 45, 59, 119], [116, 90, 156, 198, 373, 326]]})");
  CHECK(io::read_detector<float>({.weights = model}).heads().size() == 3);  // says the same
  const std::string other = files.folder.write("own.json", R"({"head": "yolov5", "strides": [8, 16, 32],
      "anchors": [[10, 13, 16, 30, 33, 24], [30, 61, 62, 45, 59, 119], [116, 90, 156, 198, 373, 326]]})");
  const std::string refused = other + ": contradicts the description within " + model;
  check_refusal({.weights = model}, ErrorKind::mismatch, refused);
  check_refusal({.weights = model, .description = other}, ErrorKind::mismatch, refused);
  network.metadata[io::description_key] = "{}";
  io::write_onnx(model, network);
  std::filesystem::remove(other);
  check_refusal({.weights = model}, ErrorKind::malformed, "own.onnx:tapestry.detector: no 'head'");
}

TEST_CASE("an end-to-end export of today's torch has torch's boxes", "[io][read_detector]") {
  const std::string folder = test::in_shared("data/exports/yolov10_like/");
  if (test::is_absent(folder)) return;
  const auto planes = test::raw_numbers<float>(folder + "in.bin");
  const auto expected = test::raw_numbers<double>(folder + "out.0.bin");  // [10, 6] in float64
  const std::string output = io::read_onnx(folder + "leg17.onnx").outputs.front();
  const test::TemporaryFolder own;
  const auto detector = io::read_detector<double>(
      {.weights = folder + "leg17.onnx",
       .description = own.write("end.json", R"({"head": "end_to_end", "outputs": {"detections": ")" + output +
                                                R"(", "classes": 4}})")});
  Array<double, 4> picture(Extents<4>{1, 64, 64, 3});
  for (std::size_t i = 0; i < picture.size(); ++i) picture.data()[i] = planes.at(i % 3 * 64 * 64 + i / 3);
  const auto found = detect::decode(detector.heads(), detect::forward(detector, picture), 0, 0.25, 64, 64);
  REQUIRE(found.size() == 10);
  for (std::size_t i = 0; i < 10; ++i) {
    const double* const row = expected.data() + 6 * i;
    const auto& box = found[i].box;
    CHECK(box.cx == Approx((row[0] + row[2]) / 2).margin(1e-4));
    CHECK(box.cy == Approx((row[1] + row[3]) / 2).margin(1e-4));
    CHECK(box.w == Approx(row[2] - row[0]).margin(1e-4));
    CHECK(box.h == Approx(row[3] - row[1]).margin(1e-4));
    CHECK(found[i].confidence == Approx(row[4]).margin(1e-6));
    CHECK(found[i].class_index == static_cast<std::size_t>(row[5]));
  }
}

TEST_CASE("an export that ends with non-maximum suppression is refused by node and file",
          "[io][read_detector]") {
  const std::string path = test::in_shared("data/exports/yolo_with_nms/leg17.onnx");
  if (test::is_absent(path)) return;
  try {
    const nn::Network<float> network(io::read_onnx(path));
    FAIL("was made");
  } catch (const FileError& error) {
    CHECK(error.details().path == path);
    CHECK_THAT(std::string(error.what()), contains("NonMaxSuppression \"") &&
                                              contains("the number of boxes left depends on the picture"));
  }
}

TEST_CASE("a description beside an ONNX model is taken", "[io][read_detector]") {
  const Files files;
  const auto anchors = detect::known_description("yolov5").anchors;
  const std::string model = files.folder.path("other.onnx");
  io::write_onnx(model, test::yolov5_like(64, anchors));
  check_refusal({.weights = model}, ErrorKind::usage, "a description must define them");
  const std::string description = files.folder.write("other.json", R"({"head": "yolov5"})");
  CHECK(io::description_beside(model) == description);
  CHECK(io::description_beside(files.weights).empty());
  CHECK(io::read_detector<float>({.weights = model}).heads()[0].decode == detect::DecodeFamily::ultralytics);
  const std::string elsewhere =
      files.folder.write("elsewhere.json", R"({"head": "yolox", "strides": [8, 16]})");
  check_refusal({.weights = model, .description = elsewhere}, ErrorKind::mismatch, "");
}

TEST_CASE("an ONNX model's stated extents are held against its own size alone", "[io][read_detector]") {
  const Files files;
  auto network = test::yolox_like(64);
  const std::string output = network.outputs.front();
  const auto warnings_of = [&](const nn::Shape& stated, std::size_t size) {
    io::write_onnx(files.onnx, network, {{output, stated}});
    std::vector<std::string> warnings;
    static_cast<void>(io::read_detector<float>({.weights = files.onnx, .size = size}, &warnings));
    return warnings;
  };
  const std::size_t candidates = 64 + 16 + 4, channels = 5 + test::exported_classes;
  CHECK(warnings_of({1, candidates, channels}, 0).empty());
  CHECK(warnings_of({1, candidates, channels}, 96).empty());
  const std::vector<std::string> expected{files.onnx + ": states [1, 99, 10] for '" + output +
                                          "', which is [1, 84, 10]; this is ignored"};
  CHECK(warnings_of({1, 99, channels}, 0) == expected);
  CHECK(warnings_of({1, 99, channels}, 96) == expected);
}

TEST_CASE("an ONNX model's metadata name the classes, unless a file does", "[io][read_detector]") {
  const Files files;
  auto network = test::yolox_like(64);
  std::vector<std::string> warnings;
  const auto read = [&](const std::string& key, const std::string& value, const std::string& names = "") {
    network.metadata = {{key, value}};
    io::write_onnx(files.onnx, network);
    warnings.clear();
    return io::read_detector<float>({.weights = files.onnx, .names = names}, &warnings);
  };
  using Texts = std::vector<std::string>;
  const std::string all = "{0: 'person', 1: 'bicycle', 2: 'car', 3: 'bus', 4: \"lady's bag\"}";
  CHECK(read("names", all).names() == Texts{"person", "bicycle", "car", "bus", "lady's bag"});
  CHECK(warnings == Texts{files.onnx + ": class names are from the model's metadata"});

  const auto some = read("names", "{4: 'bus', 1: 'car'}");
  CHECK(some.names() == Texts{"0", "car", "2", "3", "bus"});
  CHECK(some.class_index("bus") == 4);
  CHECK(some.class_index("2") == 2);
  CHECK(some.class_index("1") == 1);
  CHECK(warnings == Texts{files.onnx + ": class names are from the model's metadata; 3 of 5 classes have "
                                       "numbers there"});

  CHECK(read("names", all, files.folder.write("five.names", "a\nb\nc\nd\ne\n")).names() ==
        Texts{"a", "b", "c", "d", "e"});
  CHECK(warnings.empty());

  const auto numbered = read("names", "person,bicycle");  // X27
  CHECK(numbered.names().empty());
  CHECK(numbered.class_index("4") == 4);
  CHECK(warnings == Texts{files.onnx + ": class names in the model's metadata are left out: expected { or [ "
                                       "at byte 0"});
}

TEST_CASE("an ONNX model for another task is read with a warning", "[io][read_detector][bad_input]") {  // X28
  const Files files;
  auto network = test::yolox_like(64);
  for (const std::string task : {"detect", "segment"}) {
    network.metadata = {{"task", task}, {"stride", "32"}, {"imgsz", "[64, 64]"}};
    io::write_onnx(files.onnx, network);
    std::vector<std::string> warnings, expected;
    static_cast<void>(io::read_detector<float>({.weights = files.onnx}, &warnings));
    if (task != "detect")
      expected = {files.onnx +
                  ": the model's metadata name the task 'segment'; its outputs are read as those "
                  "of a detector"};
    CHECK(warnings == expected);
  }
}

TEST_CASE("layers to observe are named as the file names them", "[io][read_detector]") {
  const Files files;
  const std::string value = test::yolox_like(64).nodes[4].outputs.front();
  CHECK(io::read_detector<float>({.weights = files.onnx, .layers = {value}}).layer_shape(0).size() == 4);
  const auto detector =
      io::read_detector<float>({.weights = files.weights, .config = files.config, .layers = {"", "3"}});
  CHECK(detector.layer_shape(0) == nn::Shape{1, 16, 3, 3});
  CHECK(detector.layer_shape(1) == nn::Shape{1, 8, 12, 12});
  check_refusal({.weights = files.weights, .config = files.config, .layers = {"x"}}, ErrorKind::usage,
                "layers of Darknet networks are numbers");
}

TEST_CASE("files that do not go together are refused", "[io][read_detector][bad_input]") {
  const Files files;
  check_refusal({.weights = files.onnx, .config = files.config}, ErrorKind::usage,
                "an ONNX model takes no cfg and no decode family");
  check_refusal({.weights = files.weights, .config = files.config, .description = "x.json"}, ErrorKind::usage,
                "is described by its cfg, not by x.json");
  const std::string beside = files.folder.write("tiny.json", R"({"head": "yolov5"})");
  check_refusal({.weights = files.converted}, ErrorKind::usage, "is described by its cfg, not by " + beside);
  check_refusal({.weights = files.weights}, ErrorKind::usage, "need their cfg file");
  check_refusal({.weights = files.onnx, .names = files.names}, ErrorKind::mismatch,
                "number of class names does not fit the detector");
  CHECK_THROWS_WITH(io::read_detector<float>({.weights = files.onnx, .precision = "half"}),
                    contains("expected float or bfloat16"));
  CHECK_THROWS_WITH(io::read_detector<float>({.weights = files.onnx, .fit = "wide"}), contains("wide"));
}

TEST_CASE("a picture file becomes a detector's input", "[io][read_detector]") {
  const Files files;
  const auto detector = io::read_detector<float>({.weights = files.onnx});
  Array<std::uint8_t, 3> picture(Extents<3>{20, 30, 3});
  for (std::size_t i = 0; i < picture.size(); ++i) picture.data()[i] = static_cast<std::uint8_t>(i % 251);
  const auto expected = detector.input(image::from_bytes<float>(picture));
  const std::string image = files.folder.path("picture.png"), frame = files.folder.path("frame.npz");
  io::write_image(image, picture);
  CHECK((io::read_input(detector, image) == expected));
  io::Frame seen;
  seen.image = picture;
  seen.pose.emplace().camera_translation = {3, 4, 5};
  io::write_frame(frame, seen);
  CHECK((io::read_input(detector, frame) == expected));
  CHECK_THROWS_AS(io::read_input(detector, files.folder.path("absent.png")), FileError);
}
