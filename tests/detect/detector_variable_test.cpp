#include <tapestry/detect/detector_variable.hpp>

#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/small_exports.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// Changes every weight a little, as a step of learning does.
void stir(detect::Detector<float>& detector) {
  auto weights = detector.weights();
  Random random(5);
  for (float& weight : weights.storage()) weight += static_cast<float>(random.uniform(-0.1, 0.1));
  detector.set_weights(weights);
}

std::string written(const detect::Detector<float>& detector, const std::string& bytes) {
  return io::with_weights(bytes, "net.onnx", io::weight_values(detector.network()));
}

std::vector<Array<float, 4>> logits_of(const detect::Detector<float>& detector) {
  return detect::forward(detector, pictures<float>(1, 64));
}
}  // namespace

TEST_CASE("the gradient of a graph's weights on the tape agrees with central differences",
          "[detect][graph_detector][gradient]") {
  const bool simplifies = GENERATE(true, false);
  auto description = test::yolox_like(64);
  test::normalise_first(description);
  detect::Detector<double> detector(description, detect::known_description("yolox"), 0, {}, simplifies);
  const auto start = detector.weights();
  const auto images = pictures<double>(2, 64);
  std::vector<Array<double, 4>> asked;
  const auto plain = detect::forward(detector, images);
  for (const auto& head : plain)
    asked.push_back(test::random_array<double, 4>(
        {head.shape(0), head.shape(1), head.shape(2), head.shape(3)}, asked.size()));
  const auto value = [&](const Array<double, 1>& weights) {
    detector.set_weights(weights);
    return test::dot(detect::forward(detector, images), asked) / 100;
  };

  ActiveTape<double> tape;
  const auto weights = tape.input(start);
  const auto logits = detect::forward(detector, ArrayVariable<double, 4>(images), weights);
  for (std::size_t h = 0; h < asked.size(); ++h) CHECK((logits[h].value() == plain[h]));
  Variable<double> total = 0;
  for (std::size_t h = 0; h < asked.size(); ++h)
    total += sum(logits[h] * ArrayVariable<double, 4>(asked[h])) / 100.0;
  tape.reverse(total);
  const auto gradient = weights.adjoint();

  const auto direction = test::random_direction<double>({start.size()}, 3);
  const double slope = test::dot(gradient, direction);
  const double difference = test::central_difference(value, start, direction);
  CHECK(std::abs(slope - difference) <= 1e-6 * std::max(1.0, std::abs(slope)));
}

TEST_CASE("a graph on the tape takes no other number of weights", "[detect][graph_detector]") {
  detect::Detector<float> detector(test::yolox_like(64), detect::known_description("yolox"));
  const auto before = detector.weights();
  const ArrayVariable<float, 1> few(tapestry::zeros<float, 1>({3}));
  CHECK_THROWS_AS(detect::forward(detector, ArrayVariable<float, 4>(pictures<float>(1, 64)), few),
                  ShapeError);
  CHECK((detector.weights() == before));
}

TEST_CASE("weights that have learnt are read back from their file, bit for bit",
          "[detect][graph_detector][weight_replacement]") {
  const std::string bytes = io::onnx_bytes(test::yolox_like(64));
  const auto kind = detect::known_description("yolox");
  detect::Detector<float> learnt(io::parse_onnx(bytes, "net.onnx"), kind);
  const auto before = logits_of(learnt);
  stir(learnt);
  const auto after = logits_of(learnt);
  CHECK((after[0] != before[0]));
  const detect::Detector<float> read(io::parse_onnx(written(learnt, bytes), "net.onnx"), kind);
  CHECK(logits_of(read) == after);
}

TEST_CASE("of a graph that is not simplified weights keep their names, and batch normalisation learns",
          "[detect][graph_detector][weight_replacement]") {
  auto description = test::yolox_like(64);
  test::normalise_first(description);
  const std::string bytes = io::onnx_bytes(description);
  const auto kind = detect::known_description("yolox");
  const auto parsed = io::parse_onnx(bytes, "net.onnx");
  detect::Detector<float> learnt(parsed, kind, 0, {}, false);
  for (const auto& weight : learnt.network().weight_blocks()) CHECK(parsed.constants.contains(weight.name));
  stir(learnt);
  const auto after = logits_of(learnt);
  const detect::Detector<float> read(io::parse_onnx(written(learnt, bytes), "net.onnx"), kind);
  const auto again = logits_of(read);
  for (std::size_t h = 0; h < again.size(); ++h)
    for (std::size_t i = 0; i < again[h].size(); ++i)
      CHECK(std::abs(again[h].data()[i] - after[h].data()[i]) <= 1e-6F * (1 + std::abs(after[h].data()[i])));
}
