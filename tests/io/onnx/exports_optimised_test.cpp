// Runs networks as today's exporters write them, beside what the frameworks made of them in double: results,
// the adjoint of a weighted sum of them by the input, and by weights that keep their names.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/nn/network/network.hpp>
#include <vector>

#include "../../support/catch.hpp"
#include "../../support/paths.hpp"

namespace files = std::filesystem;
namespace io = tapestry::io;
namespace nn = tapestry::nn;

namespace {
using Numbers = std::vector<double>;

/// Files that are refused, each with a part of the reason.
const std::map<std::string, std::string> refused{
    {"faster_rcnn/leg17", "subgraphs"},
    {"mask_rcnn/leg13", "subgraphs"},
    {"nonzero/leg17", "NonZero"},
    {"resize_antialias/dyn18", "'antialias'"},
    {"retinanet/leg17", "subgraphs"},
    {"ssd/leg17", "subgraphs"},
    {"torch_cond/dyn21", "subgraphs"},
    {"yolo_with_nms/leg17", "depends on the picture"},
    {"yolov8_like/qdq", "DequantizeLinear"},
};

template <class Element>
Numbers numbers_of(const files::path& path) {
  const std::string bytes = io::read_text_file(path);
  Numbers all(bytes.size() / sizeof(Element));
  for (std::size_t i = 0; i < all.size(); ++i) {
    Element element{};
    std::memcpy(&element, bytes.data() + i * sizeof(Element), sizeof(Element));
    all[i] = static_cast<double>(element);
  }
  return all;
}

/// ‖found − expected‖ / ‖expected‖
template <class T>
double distance(const T* found, const Numbers& expected) {
  double squares = 0, size = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    squares += std::pow(static_cast<double>(found[i]) - expected[i], 2);
    size += expected[i] * expected[i];
  }
  return std::sqrt(squares / (size > 0 ? size : 1));
}

/// A run of one file, and the largest distances from the framework's numbers.
template <class T>
struct Run {
  nn::Network<T> network;
  files::path folder;
  nn::NetworkPass<T> pass{};
  std::vector<T> x{};

  Run(const nn::NetworkDescription& description, const files::path& file, bool simplifies)
      : network(description, {}, false, simplifies), folder(file.parent_path()) {
    for (const double value : numbers_of<float>(folder / "in.bin")) x.push_back(static_cast<T>(value));
  }

  double output_distance() {
    network.forward({x.data()}, pass, nn::Mode::training);
    double worst = 0;
    for (std::size_t k = 0; k < network.output_count(); ++k) {
      const Numbers expected = numbers_of<double>(folder / ("out." + std::to_string(k) + ".bin"));
      REQUIRE(nn::size_of(network.output_shape(k)) == expected.size());
      worst = std::max(worst, distance(pass.output(k), expected));
    }
    return worst;
  }

  /// Of the input; fills the weights' gradient.
  double gradient_distance(std::vector<T>& of_weights) {
    std::vector<std::vector<T>> weights;
    std::vector<const T*> adjoints;
    for (std::size_t k = 0; k < network.output_count(); ++k) {
      const Numbers values = numbers_of<double>(folder / ("w." + std::to_string(k) + ".bin"));
      weights.emplace_back();
      for (const double value : values) weights.back().push_back(static_cast<T>(value));
    }
    for (const auto& weight : weights) adjoints.push_back(weight.data());
    std::vector<T> gradient(x.size(), T(0));
    of_weights.assign(network.weights().size(), T(0));
    network.adjoint(pass, adjoints, {gradient.data()}, of_weights.data());
    return distance(gradient.data(), numbers_of<double>(folder / "grad.bin"));
  }
};

/// Weights whose names the file keeps: how many, and the largest distance of their gradients. Those that are
/// almost nothing, as a bias before a normalisation, say nothing.
template <class T>
std::pair<std::size_t, double> weight_distance(const Run<T>& run, const std::vector<T>& gradient) {
  const auto facts = nlohmann::json::parse(io::read_text_file(run.folder / "meta.json"));
  std::pair<std::size_t, double> result{};
  for (const auto& weight : facts.at("weights"))
    for (const nn::WeightBlock& block : run.network.weight_blocks()) {
      if (block.name != weight.at("name").template get<std::string>()) continue;
      if (weight.at("norm").template get<double>() < 1e-3) continue;
      const auto expected = numbers_of<double>(
          run.folder / ("wg." + std::to_string(weight.at("i").template get<std::size_t>()) + ".bin"));
      REQUIRE(expected.size() == nn::size_of(block.shape));
      ++result.first;
      result.second = std::max(result.second, distance(gradient.data() + block.offset, expected));
    }
  return result;
}

std::vector<files::path> all_files(const files::path& folder) {
  std::vector<files::path> found;
  for (const auto& entry : files::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".onnx") found.push_back(entry.path());
  std::ranges::sort(found);
  return found;
}

template <class T>
void check(const files::path& file, bool simplifies, double tolerance) {
  const auto description = io::read_onnx(file);
  Run<T> run(description, file, simplifies);
  CHECK(run.output_distance() <= tolerance);
  std::vector<T> of_weights;
  const double of_input = run.gradient_distance(of_weights);
  // Boxes move in ours; in the framework they have no adjoint. The operator's own test has differences.
  if (file.string().find("roi_align") != std::string::npos) return;
  CHECK(of_input <= tolerance);
  if (simplifies || file.stem().string().find("leg") == std::string::npos) return;
  const auto [count, distance] = weight_distance(run, of_weights);
  CHECK(distance <= tolerance);
}
}  // namespace

TEST_CASE("networks of today's exporters give the frameworks' results and gradients", "[io][onnx][exports]") {
  const files::path folder = tapestry::test::in_shared("data/exports");
  if (!files::exists(folder)) {
    WARN("skipped: no exports in TAPESTRY_SHARED");
    return;
  }
  std::size_t run = 0, left = 0;
  for (const files::path& file : all_files(folder)) {
    const std::string name = file.parent_path().filename().string() + "/" + file.stem().string();
    CAPTURE(name);
    if (const auto found = refused.find(name); found != refused.end()) {
      ++left;
      CHECK_THROWS_WITH(nn::Network<float>(io::read_onnx(file)), tapestry::test::contains(found->second));
      continue;
    }
    ++run;
    // Exporters fold constants in single precision: that is how far a file is from the framework's double.
    check<double>(file, true, 1e-6);
    check<double>(file, false, 1e-6);
    check<float>(file, true, 1e-5);
  }
  CHECK(left == refused.size());
  CHECK(run >= 16);
}
