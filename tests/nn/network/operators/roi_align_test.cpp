#include "../../../support/operator_case.hpp"
#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using Numbers = std::vector<double>;
constexpr std::size_t channels = 2, height = 6, width = 7, size = 3;

/// A picture that is linear in its place: bilinear samples of it are exact.
TestOperand ramp() {
  TestOperand x = given({1, channels, height, width}, 1);
  for (std::size_t i = 0; i < x.values.size(); ++i) {
    const auto row = static_cast<double>(i / width % height), column = static_cast<double>(i % width);
    x.values[i] = (i < height * width ? 0.25 : -0.5) * row + 0.125 * column + 1;
  }
  return x;
}

OperatorNetwork network_of(const TestOperand& x, const Numbers& boxes, const Numbers& images,
                           std::map<std::string, nn::Attribute> attributes) {
  attributes["output_height"] = attributes["output_width"] = static_cast<std::int64_t>(size);
  const TestOperand of_boxes{TestOperand::Kind::given, {boxes.size() / 4, 4}, boxes};
  return operator_network("RoiAlign", {x, of_boxes, numbers(images)}, std::move(attributes), 16);
}
}  // namespace

TEST_CASE("boxes within a linear picture take its values at their cells' middles", "[nn][network][roi]") {
  const TestOperand x = ramp();
  const Numbers boxes{1, 1.5, 5.5, 4.5, 2, 2, 2.5, 5};
  for (const std::int64_t samples : {0, 1, 3}) {
    const auto test = network_of(x, boxes, {0, 0}, {{"sampling_ratio", samples}});
    Numbers expected;
    for (std::size_t box = 0; box < 2; ++box)
      for (std::size_t c = 0; c < channels; ++c)
        for (std::size_t i = 0; i < size * size; ++i) {
          const double* const b = &boxes[4 * box];
          const double across = b[0] - 0.5 + (b[2] - b[0]) * (static_cast<double>(i % size) + 0.5) / size;
          const double down = b[1] - 0.5 + (b[3] - b[1]) * (static_cast<double>(i / size) + 0.5) / size;
          expected.push_back((c == 0 ? 0.25 : -0.5) * down + 0.125 * across + 1);
        }
    CHECK(largest_difference(result_of<double>(test), expected) <= 1e-14);
    CHECK(largest_difference(result_of<float>(test), expected) <= 2e-6);
    check_adjoints(test);
  }
}

TEST_CASE("boxes scale, are a pixel large at least in the old form, and may take the largest",
          "[nn][network][roi]") {
  const TestOperand x = ramp();
  const auto old =
      network_of(x, {4, 4, 4.5, 4.5}, {0},
                 {{"coordinate_transformation_mode", std::string("output_half_pixel")},
                  {"spatial_scale", 0.5},
                  {"sampling_ratio", std::int64_t(1)}});  // from (2, 2), one pixel instead of a quarter
  Numbers expected;
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t i = 0; i < size * size; ++i)
      expected.push_back((c == 0 ? 0.25 : -0.5) * (2 + (static_cast<double>(i / size) + 0.5) / size) +
                         0.125 * (2 + (static_cast<double>(i % size) + 0.5) / size) + 1);
  CHECK(largest_difference(result_of<double>(old), expected) <= 1e-14);
  check_adjoints(old);
  TestOperand drawn = given({1, channels, height, width}, 9, 0.5, 2);
  check_adjoints(network_of(drawn, {0.7, 0.6, 5.9, 4.7}, {0}, {{"mode", std::string("avg")}}));
  for (const std::int64_t samples : {0, 1, 3})  // by features and by boxes
    for (const Numbers& boxes :
         {Numbers{0.7, 0.6, 5.9, 4.7}, Numbers{-0.8, 1.2, 6.3, 6.8, 2.1, 2.2, 3.4, 3.3}}) {
      CAPTURE(samples, boxes);
      check_adjoints(network_of(drawn, boxes, Numbers(boxes.size() / 4),
                                {{"mode", std::string("max")}, {"sampling_ratio", samples}}));
    }
}

TEST_CASE("the largest weighted pixel of a box moves with the box", "[nn][network][roi]") {
  // One pixel of 8 among zeros at (3, 2). The only sample lies at (2.6, 2.3): its share is .6 · .7, of slope
  // .7 by the row and -.6 by the column; each end of the box moves it by a half.
  TestOperand x{TestOperand::Kind::given, {1, 1, height, width}, Numbers(height * width)};
  x.values[3 * width + 2] = 8;
  OperatorNetwork test = network_of(x, {2, 2.5, 3.6, 3.7}, {0},
                                    {{"mode", std::string("max")}, {"sampling_ratio", std::int64_t(1)}});
  test.node.attributes["output_height"] = test.node.attributes["output_width"] = std::int64_t(1);
  CHECK(result_of<double>(test)[0] == Approx(8 * 0.6 * 0.7));
  const nn::Network<double> network = test.network<double>();
  nn::NetworkPass<double> pass;
  const auto inputs = test.inputs<double>();
  network.forward(addresses(inputs), pass, nn::Mode::input_gradient);
  nn::Buffer<double> one(1);
  one.data()[0] = 1;
  Numbers of_x(height * width), of_box(4);
  network.adjoint(pass, {one.data(), nullptr}, {of_x.data(), of_box.data()});
  CHECK(largest_difference(of_box, std::vector{-2.4, 2.8, -2.4, 2.8}) <= 1e-12);
  CHECK(of_x[3 * width + 2] == Approx(0.42));
}

TEST_CASE("boxes that reach far beyond the picture are averaged with what lies there, and soon",
          "[nn][network][roi]") {
  const TestOperand x{TestOperand::Kind::given, {1, 1, height, width}, Numbers(height * width, 1.0)};
  for (const double far : {1e5, 1e8, 1e12, 1e30}) {
    CAPTURE(far);
    OperatorNetwork test = network_of(x, {-far, -far, far, far}, {0}, {});
    const auto found =
        result_of<double>(test);  // the middle bin holds the picture, ones from -1 to its extents
    const double bin = 2 * far / size, share = bin < 0x1p31 ? 1 / (bin * bin) : 0;
    Numbers expected(size * size);
    CHECK(std::abs(found[4] - (height + 1) * (width + 1) * share) <= 4 * (height + width) * share);
    expected[4] = found[4];
    CHECK(found == expected);
    test.node.attributes["mode"] = std::string("max");
    CHECK(result_of<double>(test)[4] <= 1);
  }
}

TEST_CASE("X30: boxes that are not finite or in no picture are refused by file and node",
          "[nn][network][roi]") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto check = [](const Numbers& box, double image, const char* sentence) {
    CHECK_THROWS_WITH(result_of<float>(network_of(ramp(), box, {image}, {})),
                      contains("test.onnx: RoiAlign \"") && contains(sentence));
  };
  const Numbers sound{1, 1, 3, 3};
  check({nan, 1, 3, 3}, 0, "box 0 has a corner at nan");
  check({1, 1, 3, -std::numeric_limits<double>::infinity()}, 0, "box 0 has a corner at -inf");
  check(sound, 7, "box 0 lies in picture 7 of 1");
  check(sound, -1, "box 0 lies in picture -1 of 1");
  check(sound, 0x1p62, "box 0 lies in picture ");
}

TEST_CASE("boxes that are empty or beside the picture give zeros and no gradient", "[nn][network][roi]") {
  const double far = 1e9;
  for (const Numbers& box : {Numbers{far, far, far + 4, far + 4}, Numbers{3, 3, 1, 1}}) {
    CAPTURE(box);
    const auto test = network_of(ramp(), box, {0}, {{"sampling_ratio", std::int64_t(0)}});
    const Numbers zeros(channels * size * size);
    CHECK(result_of<double>(test) == zeros);
    const auto network = test.network<double>();
    Objective objective;
    for (const Numbers& gradient : gradients_of(test, network, objective))
      CHECK(std::ranges::all_of(gradient, [](double value) { return value == 0; }));
  }
}

TEST_CASE("RoiAlign refuses operands and modes that it does not know", "[nn][network][roi]") {
  const auto complaint = [](std::vector<nn::Shape> shapes, std::map<std::string, nn::Attribute> attributes) {
    OperatorCase given{"RoiAlign", std::move(shapes), std::move(attributes)};
    given.constants[2] = integers({0, 0});
    return complaint_of(given);
  };
  CHECK(complaint({{1, 2, 4, 4}, {2, 4}}, {}).empty());
  CHECK_THAT(complaint({{1, 2, 4, 4}, {3, 4}}, {}), contains("expected [N, C, H, W], [boxes, 4]"));
  CHECK_THAT(complaint({{1, 2, 4, 4}, {2, 4}}, {{"mode", std::string("sum")}}),
             contains("mode is 'sum', expected avg or max"));
  CHECK_THAT(complaint({{1, 2, 4, 4}, {2, 4}}, {{"output_height", std::int64_t(0)}}),
             contains("'output_height' is out of range: 0"));
}
