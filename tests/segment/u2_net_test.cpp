#include <tapestry/segment/u2_net.hpp>

#include <tapestry/image/resize.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/segment/u2_net_description.hpp>

#include "../support/active_tape.hpp"
#include "../support/finite_difference.hpp"
#include "../support/onnx_builder.hpp"
#include "../support/random_array.hpp"
#include "../support/refusal.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// Of masks, in [0, 1].
constexpr double tolerance = 100 * static_cast<double>(std::numeric_limits<float>::epsilon());

/// A model whose d0 is the logistic function of a weighted sum of a pixel's scaled channels, and whose second
/// output is something else.
onnx::ModelParts pixel_model(const onnx::Extent& side) {
  onnx::ModelParts parts;
  parts.inputs = {onnx::value("x", onnx::float32, {onnx::Extent("N"), onnx::Extent(3), side, side})};
  parts.outputs = {onnx::value("d0", onnx::float32, {}), onnx::value("d1", onnx::float32, {})};
  parts.initialisers = {onnx::float_tensor("w", {1, 3, 1, 1}, {0.5F, -1.0F, 0.25F}),
                        onnx::float_tensor("b", {1}, {0.125F})};
  parts.nodes = {onnx::node("Conv", {"x", "w", "b"}, {"sums"}), onnx::node("Sigmoid", {"sums"}, {"d0"}),
                 onnx::node("Tanh", {"sums"}, {"d1"})};
  return parts;
}

nn::NetworkDescription parsed(const onnx::ModelParts& parts) {
  return io::parse_onnx(onnx::model(parts), "u2.onnx");
}

/// Result of the published program for a picture as large as the network's input, for pixel_model().
Array<double, 2> by_hand(const Array<float, 3>& picture) {
  const double mean[] = {0.485, 0.456, 0.406}, deviation[] = {0.229, 0.224, 0.225},
               weight[] = {0.5, -1, 0.25};
  double largest = 0;
  for (const float value : picture.storage()) largest = std::max(largest, static_cast<double>(value));
  Array<double, 2> mask({picture.shape(0), picture.shape(1)});
  double least = 1, most = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    double sum = 0.125;
    for (std::size_t c = 0; c < 3; ++c)
      sum += weight[c] * (static_cast<double>(picture.data()[3 * i + c]) / largest - mean[c]) / deviation[c];
    mask.data()[i] = 1 / (1 + std::exp(-sum));
    least = std::min(least, mask.data()[i]);
    most = std::max(most, mask.data()[i]);
  }
  for (double& value : mask.storage()) value = (value - least) / (most - least);
  return mask;
}

/// Two stages and a dilated one, of random weights.
nn::NetworkDescription small_network() {
  return segment::u2_net_description({16, {{3, 2, 3}, {2, 2, 4}}, 2, 4}, 7);
}

/// Mask of small_network() for a picture, step by step in double.
Array<double, 2> mask_in_double(const Array<double, 3>& picture) {
  static const nn::Network<double> network(nn::pruned(small_network(), {"d0"}), {}, true);
  Array<double, 3> reduced = picture;
  while (reduced.shape(0) >= 32 || reduced.shape(1) >= 32)
    reduced = image::resize_bilinear(reduced,
                                     reduced.shape(0) >= 32 ? (reduced.shape(0) + 1) / 2 : reduced.shape(0),
                                     reduced.shape(1) >= 32 ? (reduced.shape(1) + 1) / 2 : reduced.shape(1));
  reduced = image::resize_bilinear(reduced, 16, 16);
  const double mean[] = {0.485, 0.456, 0.406}, deviation[] = {0.229, 0.224, 0.225};
  const double largest = *std::max_element(reduced.begin(), reduced.end());
  nn::Buffer<double> input(reduced.size());
  for (std::size_t i = 0; i < reduced.size(); ++i)
    input.data()[i] = (reduced.data()[i] / largest - mean[i % 3]) / deviation[i % 3];
  nn::NetworkPass<double> pass;
  network.forward({input.data()}, pass, nn::Mode::inference);
  const double* const map = pass.output(0);
  const auto [least, most] = std::minmax_element(map, map + 256);
  Array<double, 3> stretched(Extents<3>{16, 16, 1});
  for (std::size_t i = 0; i < 256; ++i) stretched.data()[i] = (map[i] - *least) / (*most - *least);
  const auto resized = image::resize_bilinear(stretched, picture.shape(0), picture.shape(1));
  Array<double, 2> mask({picture.shape(0), picture.shape(1)});
  std::copy_n(resized.data(), resized.size(), mask.data());
  return mask;
}
}  // namespace

TEST_CASE("a picture goes in and a mask comes out as published", "[segment][u2_net]") {
  const segment::U2Net network(parsed(pixel_model(8)));
  REQUIRE(network.side() == 8);
  const auto picture = random_array<float>({8, 8, 3}, 1, 0.1, 0.8);
  const auto mask = network(picture);
  const auto truth = by_hand(picture);
  REQUIRE(mask.shape() == truth.shape());
  for (std::size_t i = 0; i < mask.size(); ++i)
    CHECK(static_cast<double>(mask.data()[i]) == Approx(truth.data()[i]).margin(tolerance));
  // Exposure is divided out.
  Array<float, 3> brighter = picture;
  for (float& value : brighter.storage()) value *= 1.25F;
  const auto same = network(brighter);
  for (std::size_t i = 0; i < mask.size(); ++i)
    CHECK(static_cast<double>(same.data()[i]) == Approx(truth.data()[i]).margin(tolerance));
}

TEST_CASE("larger pictures are averaged before they go in, and masks come back at their size",
          "[segment][u2_net]") {
  const segment::U2Net network(parsed(pixel_model(8)));
  const auto small = random_array<float>({8, 8, 3}, 2, 0.1, 0.8);
  const auto noise = random_array<float>({8, 8, 3}, 3, -0.1, 0.1);
  Array<float, 3> picture({32, 16, 3});  // of equal means, 4 × 2 pixels each
  for (std::size_t row = 0; row < 32; ++row)
    for (std::size_t column = 0; column < 16; ++column)
      for (std::size_t c = 0; c < 3; ++c)
        picture(row, column, c) = small(row / 4, column / 2, c) +
                                  ((row + column) % 2 == 0 ? 1.0F : -1.0F) * noise(row / 4, column / 2, c);
  const auto mask = network(picture);
  REQUIRE(mask.shape() == Extents<2>{32, 16});
  const auto truth = by_hand(small);
  for (std::size_t row = 0; row < 7; ++row)
    for (std::size_t column = 0; column < 7; ++column) {
      // Rows and columns between the centres of four pixels of the small mask.
      const auto ahead = static_cast<double>(mask(4 * row + 3, 2 * column + 1));
      const auto mixed = [&](std::size_t i) { return 0.75 * truth(i, column) + 0.25 * truth(i, column + 1); };
      CHECK(ahead == Approx(0.625 * mixed(row) + 0.375 * mixed(row + 1)).margin(tolerance));
    }
}

TEST_CASE("black pictures and constant masks are no division by zero", "[segment][u2_net]") {
  const segment::U2Net network(parsed(pixel_model(4)));
  segment::U2NetPass pass;
  for (const float level : {0.0F, 0.5F}) {
    Array<float, 3> picture({5, 6, 3});
    picture.fill(level);
    network.forward(picture, pass, nn::Mode::input_gradient);
    for (const float value : pass.mask.storage()) CHECK(value == 0.0F);
    auto adjoint = tapestry::zeros<float, 3>({5, 6, 3});
    network.pull_back(pass, random_array<float>({5, 6}, 4), adjoint);
    for (const float value : adjoint.storage()) CHECK(value == 0.0F);
  }
}

TEST_CASE("the gradient of a mask agrees with central differences in double", "[segment][u2_net][gradient]") {
  const segment::U2Net network(small_network());
  for (const auto& [height, width] : {std::pair{16, 16}, {21, 19}, {40, 13}, {70, 37}}) {
    INFO(height << "x" << width);
    const auto rows = static_cast<std::size_t>(height), columns = static_cast<std::size_t>(width);
    const auto picture = random_array<float>({rows, columns, 3}, 5, 0.1, 0.9);
    const auto weights = random_array<float>({rows, columns}, 6, -1, 1);
    const auto value = [&, exact = tapestry::cast<double>(weights)](const Array<double, 3>& at) {
      return test::dot(mask_in_double(at), exact);
    };

    ActiveTape<float> tape;
    const auto input = tape.input(picture);
    const auto mask = segment::mask(network, input);
    const auto pullback = [&](float sum_adjoint, Array<float, 2>* mask_adjoint) {
      for (std::size_t i = 0; i < weights.size(); ++i)
        mask_adjoint->data()[i] += sum_adjoint * weights.data()[i];
    };
    tape.reverse(tapestry::record_scalar(test::dot(mask.value(), weights), pullback, mask));
    const auto exact = tapestry::cast<double>(picture), gradient = tapestry::cast<double>(input.adjoint());
    // Roundings of float in some 30 operations of either direction, each at most 100 ε of the whole.
    const double rounding = 30 * tolerance * std::sqrt(test::dot(gradient, gradient));
    const auto check = [&](const Array<double, 3>& direction) {
      const double slope = test::dot(gradient, direction);
      CHECK(std::abs(slope) > 1e-6);
      CHECK(std::abs(slope - test::central_difference(value, exact, direction)) <= rounding);
    };
    for (std::uint64_t seed = 0; seed < 3; ++seed)
      check(test::random_direction<double>({rows, columns, 3}, 8 + seed));
    // The brightest value: divides all others.
    auto axis = tapestry::zeros<double, 3>({rows, columns, 3});
    if (rows != 16) continue;
    axis.data()[segment::detail::brightest(picture)] = 1;
    check(axis);
  }
}

TEST_CASE("a passive picture records nothing", "[segment][u2_net]") {
  const segment::U2Net network(small_network());
  const ArrayVariable<float, 3> picture = random_array<float>({20, 20, 3}, 9);
  CHECK_FALSE(segment::mask(network, picture).is_active());
}

TEST_CASE("masks are the same bits for any number of threads", "[segment][u2_net][threads]") {
  const segment::U2Net network(small_network());
  const auto picture = random_array<float>({90, 50, 3}, 10);
  const auto weights = random_array<float>({90, 50}, 11);
  same_by_threads({1, 3}, [&] {
    segment::U2NetPass pass;
    network.forward(picture, pass, nn::Mode::input_gradient);
    auto adjoint = tapestry::zeros<float, 3>(picture.shape());
    network.pull_back(pass, weights, adjoint);
    return std::pair(pass.mask, adjoint);
  });
}

TEST_CASE("a model that leaves its size open takes that of the paper, or the one asked for",
          "[segment][u2_net]") {
  const auto open = parsed(pixel_model(onnx::Extent()));
  CHECK(segment::U2Net(open).side() == 320);
  CHECK(segment::U2Net(open, 24).side() == 24);
}

TEST_CASE("what is no network of masks is refused by name", "[segment][u2_net][bad_input]") {
  const auto refused = [](const std::string& text, const onnx::ModelParts& parts, std::size_t side = 0) {
    check_refused(ErrorKind::mismatch, text, [&] { (void)segment::U2Net(parsed(parts), side); });
  };
  auto parts = pixel_model(8);
  parts.initialisers[0] = onnx::float_tensor("w", {2, 3, 1, 1}, {1, 2, 3, 4, 5, 6});
  parts.initialisers[1] = onnx::float_tensor("b", {2}, {0, 0});
  refused("u2.onnx: the first output 'd0' is no mask; expected [1, 1, 8, 8], found [1, 2, 8, 8]", parts);

  parts = pixel_model(8);
  parts.nodes[0] = onnx::node("Conv", {"x", "w", "b"}, {"sums"}, {onnx::ints_attribute("strides", {2, 2})});
  refused("expected [1, 1, 8, 8], found [1, 1, 4, 4]", parts);

  parts = pixel_model(8);
  parts.nodes.push_back(onnx::node("Flatten", {"d1"}, {"flat"}));
  parts.outputs = {onnx::value("flat", onnx::float32, {})};
  refused("the first output 'flat' is no mask", parts);

  using onnx::Extent;
  for (const auto& [extents, found] :
       std::vector<std::pair<std::vector<Extent>, std::string>>{{{1, 1, 8, 8}, "'x' [1, 1, 8, 8]"},
                                                                {{2, 3, 8, 8}, "'x' [2, 3, 8, 8]"},
                                                                {{1, 3, 8, 9}, "'x' [1, 3, 8, 9]"},
                                                                {{3, 8, 8}, "'x' of 3 axes"}}) {
    parts = pixel_model(8);
    parts.inputs = {onnx::value("x", onnx::float32, extents)};
    refused("u2.onnx: no network of pictures; expected one input [1, 3, S, S], found " + found, parts);
  }
  parts = pixel_model(8);
  parts.inputs.push_back(onnx::value("y", onnx::float32, {Extent(1)}));
  refused("found 2 inputs", parts);

  nn::NetworkDescription none = small_network();
  none.outputs.clear();
  check_refused(ErrorKind::mismatch, "no network that makes masks", [&] { (void)segment::U2Net(none); });
}

TEST_CASE("pictures and adjoints of other kinds are refused", "[segment][u2_net][bad_input]") {
  const segment::U2Net network(small_network());
  segment::U2NetPass pass;
  auto adjoint = tapestry::zeros<float, 3>({8, 8, 3});
  CHECK_THROWS_AS(network.pull_back(pass, random_array<float>({8, 8}, 1), adjoint), ShapeError);
  CHECK_THROWS_WITH(network.forward(random_array<float>({8, 8, 4}, 1), pass),
                    "U2Net::forward: picture is [8, 8, 4], expected [8, 8, 3]");
  CHECK_THROWS_AS(network.forward(Array<float, 3>({0, 8, 3}), pass), DomainError);
  auto picture = random_array<float>({8, 8, 3}, 1);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    picture(3, 3, 1) = bad;
    CHECK_THROWS_WITH(network.forward(picture, pass),
                      "U2Net::forward: the picture has values that are not finite");
  }
  picture(3, 3, 1) = 0;
  network.forward(picture, pass);
  CHECK_THROWS_AS(network.pull_back(pass, random_array<float>({8, 8}, 1), adjoint), DomainError);
  network.forward(picture, pass, nn::Mode::input_gradient);
  CHECK_THROWS_WITH(network.pull_back(pass, random_array<float>({8, 9}, 1), adjoint),
                    "U2Net::pull_back: mask_adjoint is [8, 9], expected [8, 8]");
  auto wrong = tapestry::zeros<float, 3>({8, 9, 3});
  CHECK_THROWS_AS(network.pull_back(pass, random_array<float>({8, 8}, 1), wrong), ShapeError);
}

TEST_CASE("the small network's description holds what figure 5 shows", "[segment][u2_net]") {
  const auto network = small_network();
  CHECK(network.outputs == std::vector<std::string>{"d0", "d1", "d2", "d3"});
  CHECK(segment::u2_net_logits(network).size() == 4);
  const nn::Network<float> runs(network);
  for (std::size_t i = 0; i < 4; ++i) CHECK(runs.output_shape(i) == nn::Shape{1, 1, 16, 16});
  const auto again = small_network(),
             other = segment::u2_net_description({16, {{3, 2, 3}, {2, 2, 4}}, 2, 4}, 8);
  const auto weights_of = [](const nn::NetworkDescription& from) {
    return std::get<std::vector<float>>(from.constants.at("encoder1.in.weight").values);
  };
  CHECK(weights_of(again) == weights_of(network));
  CHECK(weights_of(other) != weights_of(network));

  using Shape = segment::U2NetShape;
  for (const Shape& bad :
       {Shape{16, {}, 2, 4}, Shape{16, {{1, 2, 3}}, 2, 4}, Shape{16, {{3, 0, 3}}, 2, 4},
        Shape{16, {{3, 2, 3}}, 0, 4}, Shape{15, {{3, 2, 3}}, 2, 4}, Shape{0, {{3, 2, 3}}, 2, 4}})
    CHECK_THROWS_AS(segment::u2_net_description(bad, 1), DomainError);
  CHECK_THROWS_WITH(segment::u2_net_description({20, {{3, 2, 3}, {4, 2, 3}}, 2, 4}, 1),
                    "u2_net_description: a side of 20 pixels is no multiple of the largest stride, 8");
}
