// Runs networks as today's exporters write them, and compares with the frameworks' numbers in double:
// results, and the adjoints of their weighted sum by the input and by weights that keep their names.
#include <iostream>
#include <nlohmann/json.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/nn/network/staged_network.hpp>

#include "../../support/catch.hpp"
#include "../../support/paths.hpp"
#include "../../support/raw_numbers.hpp"

namespace files = std::filesystem;
using namespace tapestry;

namespace {
using Numbers = std::vector<double>;

/// Where boxes move over feature maps: their adjoint, which is ours, is left out by the frameworks. The slope
/// along it is compared with differences instead.
bool has_moving_boxes(const std::string& name) {
  return name.starts_with("roi_align") || name.starts_with("faster_rcnn") || name.starts_with("mask_rcnn");
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

/// A file, and the weighted sum of its results that the framework took the adjoint of.
struct Export {
  files::path folder;
  std::string name;
  nn::NetworkDescription description;
  Numbers x;

  explicit Export(const files::path& file)
      : folder(file.parent_path()),
        name(folder.filename().string() + "/" + file.stem().string()),
        description(io::read_onnx(file)),
        x(test::raw_numbers<float>(folder / "in.bin")) {}

  /// The framework has no quantised network: its results are ONNX Runtime's, and its gradient is its own.
  [[nodiscard]] bool is_quantised() const { return name.ends_with("/qdq"); }

  [[nodiscard]] Numbers expected(std::size_t result) const {
    if (is_quantised())
      return test::raw_numbers<float>(folder / ("qdq.ort." + std::to_string(result) + ".bin"));
    return test::raw_numbers<double>(folder / ("out." + std::to_string(result) + ".bin"));
  }
  /// Empty for results that are not floating-point numbers.
  template <class T>
  [[nodiscard]] std::vector<T> weights(std::size_t result) const {
    const files::path path = folder / ("w." + std::to_string(result) + ".bin");
    const Numbers values = files::exists(path) ? test::raw_numbers<double>(path) : Numbers();
    return {values.begin(), values.end()};
  }
};

/// A run in stages, and its distances from the framework's numbers.
template <class T>
struct StagedRun {
  const Export& file;
  nn::StagedNetwork<T> network{file.description};
  nn::StagedPass<T> pass{};

  double objective(const std::vector<T>& x) {
    network.forward({x.data()}, pass, nn::Mode::input_gradient);
    double sum = 0;
    for (std::size_t k = 0; k < pass.output_count(); ++k) {
      const auto weights = file.weights<T>(k);
      for (std::size_t i = 0; i < weights.size() && i < nn::size_of(pass.output_shape(k)); ++i)
        sum += static_cast<double>(weights[i]) * static_cast<double>(pass.output(k)[i]);
    }
    return sum;
  }
  std::vector<T> gradient() {
    std::vector<std::vector<T>> weights;
    std::vector<const T*> adjoints;
    for (std::size_t k = 0; k < pass.output_count(); ++k) {
      weights.push_back(file.weights<T>(k));
      adjoints.push_back(weights.back().empty() ? nullptr : weights.back().data());
    }
    std::vector<T> gradient(file.x.size(), T(0));
    network.adjoint(pass, adjoints, {gradient.data()});
    return gradient;
  }
};

template <class T>
void check_in_stages(const Export& file, double tolerance) {
  StagedRun<T> run{file};
  std::vector<T> x(file.x.begin(), file.x.end());
  x.resize(x.size() + 64);  // readable past their end
  static_cast<void>(run.objective(x));
  for (std::size_t k = 0; k < run.pass.output_count(); ++k) {
    const Numbers expected = file.expected(k);
    REQUIRE(nn::size_of(run.pass.output_shape(k)) == expected.size());
    // Two boxes whose scores are equal in single precision change places there, in ONNX Runtime as well.
    if (std::is_same_v<T, float> && file.name == "faster_rcnn/leg17" && k == 0) continue;
    // ONNX Runtime runs a quantised file by kernels of integers, which round elsewhere: some steps of 1/255.
    CHECK(distance(run.pass.output(k), expected) <= (file.is_quantised() ? 0.01 : tolerance));
  }
  const std::vector<T> gradient = run.gradient();
  if (!has_moving_boxes(file.name) && !file.is_quantised())
    CHECK(distance(gradient.data(), test::raw_numbers<double>(file.folder / "grad.bin")) <= tolerance);
  static_cast<void>(run.objective(x));
  CHECK(run.pass.made_count() == 0);  // the same extents and integers
  CHECK(run.gradient() == gradient);
}

/// The slope along the gradient, against a central difference.
void check_slope(const Export& file) {
  StagedRun<double> run{file};
  std::vector<double> x = file.x;
  x.resize(x.size() + 64);
  static_cast<void>(run.objective(x));
  const std::vector<double> gradient = run.gradient();
  double squares = 0;
  for (const double slope : gradient) squares += slope * slope;
  const double length = std::sqrt(squares), h = 1e-6;
  const auto at = [&](double step) {
    std::vector<double> moved = x;
    for (std::size_t i = 0; i < gradient.size(); ++i) moved[i] += step * gradient[i] / length;
    return run.objective(moved);
  };
  CHECK((at(h) - at(-h)) / (2 * h) == Approx(length).epsilon(1e-6));
}

/// A run of one network of fixed extents without simplification, with the gradient of its weights.
template <class T>
struct Run {
  nn::Network<T> network;
  files::path folder;
  std::vector<T> gradient{};

  explicit Run(const Export& file) : network(file.description, {}, false, false), folder(file.folder) {
    std::vector<T> x(file.x.begin(), file.x.end());
    x.resize(x.size() + 64);
    nn::NetworkPass<T> pass;
    network.forward({x.data()}, pass, nn::Mode::training);
    std::vector<std::vector<T>> weights;
    std::vector<const T*> adjoints;
    for (std::size_t k = 0; k < network.output_count(); ++k) weights.push_back(file.weights<T>(k));
    for (const auto& weight : weights) adjoints.push_back(weight.data());
    gradient.assign(network.weights().size(), T(0));
    network.adjoint(pass, adjoints, {nullptr}, gradient.data());
  }
};

/// Weights whose names the file keeps: their number, and the largest distance of their gradients. Gradients
/// near 0, as of a bias before a normalisation, prove nothing.
template <class T>
std::pair<std::size_t, double> weight_distance(const Run<T>& run) {
  const auto facts = nlohmann::json::parse(io::read_text_file(run.folder / "meta.json"));
  std::pair<std::size_t, double> result{};
  for (const auto& weight : facts.at("weights")) {
    if (weight.at("norm").template get<double>() < 1e-3) continue;
    Numbers sum;
    for (const nn::WeightBlock& block : run.network.weight_blocks()) {
      if (block.name != weight.at("name").template get<std::string>()) continue;
      sum.resize(nn::size_of(block.constant_shape));
      const auto places = nn::Network<T>::places_of(block);
      for (std::size_t i = 0; i < places.size(); ++i)
        sum[places[i]] += static_cast<double>(run.gradient[block.offset + i]);
    }
    if (sum.empty()) continue;
    const auto expected = test::raw_numbers<double>(
        run.folder / ("wg." + std::to_string(weight.at("i").template get<std::size_t>()) + ".bin"));
    REQUIRE(expected.size() == sum.size());
    ++result.first;
    result.second = std::max(result.second, distance(sum.data(), expected));
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
}  // namespace

TEST_CASE("networks of today's exporters give the frameworks' results and gradients", "[io][onnx][exports]") {
  const files::path folder = test::in_shared("data/exports");
  if (test::is_absent(folder)) return;
  for (const files::path& path : all_files(folder)) {
    const Export file(path);
    CAPTURE(file.name);
    // Exporters fold constants in single precision: so a file differs that much from the framework's double.
    check_in_stages<double>(file, 1e-6);
    check_in_stages<float>(file, 1e-5);
    if (!file.is_quantised()) check_slope(file);
  }
}

TEST_CASE("weights of today's exports have the frameworks' gradients", "[io][onnx][exports]") {
  const files::path folder = test::in_shared("data/exports");
  if (test::is_absent(folder)) return;
  for (const char* name :
       {"conv1d/leg17", "crnn_gru/leg17", "crnn_lstm/leg17", "einsum/leg17", "lstm_states/leg17",
        "unfold_fold/leg18", "yolov8_like/leg17", "yolov10_like/leg17"}) {
    CAPTURE(name);
    const auto [count, distance] =
        weight_distance(Run<double>(Export(folder / (std::string(name) + ".onnx"))));
    std::cout << name << ": " << count << " weights\n";
    CHECK(distance <= 1e-6);
  }
}
