#include <tapestry/io/onnx/onnx_file.hpp>

#include <set>

#include "../../support/catch.hpp"
#include "../../support/paths.hpp"

namespace fs = std::filesystem;
using namespace tapestry;

namespace {
const std::string published = "/usr/share/libonnx-testdata/data";  // of Debian's package libonnx-testdata

std::vector<fs::path> models_below(const std::string& folder) {
  std::vector<fs::path> models;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().filename() == "model.onnx") models.push_back(entry.path());
  std::sort(models.begin(), models.end());
  return models;
}

nn::Constant tensor_of(const std::string& test, const std::string& file) {
  return io::read_onnx_tensor(published + "/node/" + test + "/test_data_set_0/" + file);
}

/// Both constants have the same extents and numbers, NaN where the other has NaN.
void check_same(const nn::Constant& a, const nn::Constant& b) {
  CHECK(a.shape == b.shape);
  REQUIRE(a.size() == b.size());
  std::size_t differences = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a.at(i) != b.at(i) && !(a.at(i) != a.at(i) && b.at(i) != b.at(i))) ++differences;
  CHECK(differences == 0);
}
}  // namespace

TEST_CASE("detectors that others trained are read", "[io][onnx]") {
  struct Row {
    std::string name;
    std::size_t nodes;
    std::vector<std::string> outputs;
    nn::Shape input;
  };
  const Row rows[] = {
      {"yolox_nano", 369, {"output"}, {1, 3, 416, 416}},
      {"nanodet_m", 225, {"792", "814", "836", "795", "817", "839"}, {1, 3, 416, 416}},
  };
  for (const Row& row : rows) {
    const std::string path = test::in_shared("data/detectors/" + row.name + ".onnx");
    if (test::is_absent(path)) continue;
    const nn::NetworkDescription network = io::read_onnx(path);
    CHECK(network.nodes.size() == row.nodes);
    CHECK(network.opset == 11);
    CHECK(network.outputs == row.outputs);
    REQUIRE(network.inputs.size() == 1);
    CHECK(network.inputs[0].shape ==
          std::vector<std::optional<std::size_t>>(row.input.begin(), row.input.end()));
  }
}

TEST_CASE("a detector in half precision whose Casts stand at the end is read in order", "[io][onnx]") {
  const std::string path = test::in_shared("data/detectors/yolov5n_fp16.onnx");
  if (test::is_absent(path)) return;
  const nn::NetworkDescription network = io::read_onnx(path);
  std::set<std::string> made{""};
  for (const auto& input : network.inputs) made.insert(input.name);
  for (const auto& constant : network.constants) made.insert(constant.first);
  for (const nn::Node& node : network.nodes) {
    for (const std::string& name : node.inputs) CHECK(made.contains(name));
    made.insert(node.outputs.begin(), node.outputs.end());
  }
}

TEST_CASE("every published model is read, or refused with its name", "[io][onnx]") {
  if (test::is_absent(published)) return;
  std::size_t read_count = 0;
  std::map<std::string, std::size_t> refusals;
  for (const fs::path& path : models_below(published)) {
    INFO(path);
    try {
      const nn::NetworkDescription network = io::read_onnx(path.string());
      CHECK(network.opset >= io::first_opset);
      ++read_count;
      CHECK(nn::untrue_shape(network).value_or("").empty());
    } catch (const FileError& error) {
      CHECK(error.details().path == path.string());
      const std::string what = error.details().what;
      ++refusals[what.substr(what.rfind(": ") + 2)];
    }
  }
  std::string counts = std::to_string(read_count) + " models read";
  for (const auto& [what, count] : refusals) counts += "; " + std::to_string(count) + " refused: " + what;
  WARN(counts);
  CHECK(read_count >= 800);
  for (const auto& [what, count] : refusals) {
    INFO(what);
    CHECK((what.find("not supported") != std::string::npos || what.find("imports no version") == 0));
  }
}

TEST_CASE("published constants are what their tests expect", "[io][onnx]") {
  if (test::is_absent(published)) return;
  const nn::NetworkDescription network = io::read_onnx(published + "/node/test_constant/model.onnx");
  CHECK(network.nodes.empty());
  check_same(network.constants.at(network.outputs.at(0)), tensor_of("test_constant", "output_0.pb"));
}

TEST_CASE("published tensors of different types hold the same numbers", "[io][onnx]") {
  if (test::is_absent(published)) return;
  // Widening changes no value. Bfloat16 is left out, for its vectors are of type UINT16.
  for (const char* test :
       {"test_cast_FLOAT16_to_FLOAT", "test_cast_FLOAT16_to_DOUBLE", "test_cast_FLOAT_to_DOUBLE"}) {
    INFO(test);
    const nn::Constant input = tensor_of(test, "input_0.pb");
    CHECK(input.size() == 12);
    check_same(input, tensor_of(test, "output_0.pb"));
  }
}

TEST_CASE("a published comparison has the type and values of its operands' order", "[io][onnx]") {
  if (test::is_absent(published)) return;
  const nn::Constant a = tensor_of("test_less", "input_0.pb"), b = tensor_of("test_less", "input_1.pb");
  const nn::Constant is_less = tensor_of("test_less", "output_0.pb");
  CHECK(is_less.type == nn::ElementType::boolean);
  REQUIRE(is_less.size() == a.size());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(is_less.at(i) == (a.at(i) < b.at(i) ? 1.0 : 0.0));
}

TEST_CASE("a published shape is that of its tensor", "[io][onnx]") {
  if (test::is_absent(published)) return;
  const nn::Constant tensor = tensor_of("test_shape", "input_0.pb");
  const nn::Constant shape = tensor_of("test_shape", "output_0.pb");
  CHECK(shape.type == nn::ElementType::integer);
  CHECK(std::get<std::vector<double>>(shape.values) ==
        std::vector<double>(tensor.shape.begin(), tensor.shape.end()));
}
