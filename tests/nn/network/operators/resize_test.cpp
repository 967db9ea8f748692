#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using nn::ElementType;

/// Resize of a picture of one channel.
OperatorNetwork picture(std::vector<double> x, std::size_t height, std::size_t width, TestOperand scales,
                        TestOperand sizes, const std::map<std::string, nn::Attribute>& attributes) {
  const TestOperand of_picture{TestOperand::Kind::given, {1, 1, height, width}, std::move(x)};
  return operator_network("Resize", {of_picture, {}, std::move(scales), std::move(sizes)}, attributes);
}
TestOperand scales(std::vector<double> values) { return numbers(std::move(values), ElementType::floating); }
const std::vector<double> four = {1, 2, 3, 4}, eight = {1, 2, 3, 4, 5, 6, 7, 8},
                          sixteen = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
const auto name = [](const char* text) { return nn::Attribute(std::string(text)); };

void check(const OperatorNetwork& test, const nn::Shape& shape, const std::vector<double>& expected) {
  CHECK(test.network<double>().output_shape(0) == shape);
  CHECK(largest_difference(result_of<double>(test), expected) <= 2e-6);
  CHECK(largest_difference(result_of<float>(test), expected) <= 1e-5);
}
}  // namespace

// Values worked out from the formulas of onnx.ai, Operators.md, Resize.
TEST_CASE("Resize reads the nearest value", "[nn][network][resize]") {
  const std::vector<double> doubled = {1, 1, 2, 2, 1, 1, 2, 2, 3, 3, 4, 4, 3, 3, 4, 4};
  for (const char* coordinates : {"half_pixel", "asymmetric", "pytorch_half_pixel", "half_pixel_symmetric"})
    for (const char* nearest : {"round_prefer_floor", "floor"}) {
      const bool shifts = std::string(coordinates) != "asymmetric" && std::string(nearest) == "floor";
      const bool rounds = std::string(coordinates) == "asymmetric" && std::string(nearest) != "floor";
      if (shifts || rounds) continue;  // these read other values
      CAPTURE(coordinates, nearest);
      check(picture(four, 2, 2, scales({1, 1, 2, 2}), {},
                    {{"coordinate_transformation_mode", name(coordinates)}, {"nearest_mode", name(nearest)}}),
            {1, 1, 4, 4}, doubled);
    }
  // x = −0.25, 0.25, 0.75, 1.25: floors 0 (cut), 0, 0, 1
  check(picture({1, 2}, 1, 2, scales({1, 1, 1, 2}), {}, {{"nearest_mode", name("floor")}}), {1, 1, 1, 4},
        {1, 1, 1, 2});
  check(picture({1, 2}, 1, 2, scales({1, 1, 1, 2}), {}, {{"nearest_mode", name("ceil")}}), {1, 1, 1, 4},
        {1, 2, 2, 2});
  // x = 0, 0.5, 1, 1.5
  const auto asymmetric = [&](const char* nearest) {
    return picture({1, 2}, 1, 2, scales({1, 1, 1, 2}), {},
                   {{"coordinate_transformation_mode", name("asymmetric")}, {"nearest_mode", name(nearest)}});
  };
  check(asymmetric("round_prefer_floor"), {1, 1, 1, 4}, {1, 1, 2, 2});
  check(asymmetric("round_prefer_ceil"), {1, 1, 1, 4}, {1, 2, 2, 2});
  check(picture(eight, 2, 4, scales({1, 1, 0.6, 0.6}), {}, {}), {1, 1, 1, 2}, {1, 3});
  check(picture(four, 2, 2, {}, numbers({1, 1, 3, 4}), {}), {1, 1, 3, 4},
        {1, 1, 2, 2, 1, 1, 2, 2, 3, 3, 4, 4});
}

TEST_CASE("the nearest value is exact where two are equally near", "[nn][network][resize][repeated]") {
  // Coordinates as fractions n / d of whole numbers: ties are seen as they are.
  struct Fraction {
    std::int64_t n, d;
    [[nodiscard]] std::int64_t floor() const { return n >= 0 ? n / d : -((-n + d - 1) / d); }
    [[nodiscard]] std::int64_t ceil() const { return -Fraction{-n, d}.floor(); }
    [[nodiscard]] Fraction plus_half(int sign) const { return {2 * n + sign * d, 2 * d}; }
  };
  const auto expected_at = [](const std::string& coordinates, const std::string& nearest, std::int64_t in,
                              std::int64_t out, std::int64_t i) {
    const Fraction x = coordinates == "asymmetric"             ? Fraction{i * in, out}
                       : coordinates == "tf_half_pixel_for_nn" ? Fraction{(2 * i + 1) * in, 2 * out}
                       : coordinates == "pytorch_half_pixel" && out == 1
                           ? Fraction{0, 1}
                           : Fraction{(2 * i + 1) * in - out, 2 * out};
    const std::int64_t place = nearest == "floor"                ? x.floor()
                               : nearest == "ceil"               ? x.ceil()
                               : nearest == "round_prefer_floor" ? x.plus_half(-1).ceil()
                                                                 : x.plus_half(1).floor();
    return static_cast<double>(std::clamp<std::int64_t>(place, 0, in - 1));
  };
  std::size_t wrong = 0, count = 0;
  for (const std::string coordinates :
       {"half_pixel", "asymmetric", "pytorch_half_pixel", "half_pixel_symmetric", "tf_half_pixel_for_nn"})
    for (const std::string nearest : {"round_prefer_floor", "round_prefer_ceil", "floor", "ceil"})
      for (std::int64_t in = 1; in <= 12; ++in)
        for (std::int64_t out = 1; out <= 24; ++out) {
          std::vector<double> x, expected;
          for (std::int64_t i = 0; i < in; ++i) x.push_back(static_cast<double>(i));
          for (std::int64_t i = 0; i < out; ++i)
            expected.push_back(expected_at(coordinates, nearest, in, out, i));
          const auto ratio = static_cast<double>(static_cast<float>(out) / static_cast<float>(in));
          const bool fits = std::floor(ratio * static_cast<double>(in)) == static_cast<double>(out);
          for (const bool is_scale : {false, true}) {
            if (is_scale && !fits) continue;  // other extents come out
            const auto found = result_of<float>(picture(
                x, 1, static_cast<std::size_t>(in), is_scale ? scales({1, 1, 1, ratio}) : TestOperand{},
                is_scale ? TestOperand{} : numbers({1, 1, 1, static_cast<double>(out)}),
                {{"coordinate_transformation_mode", nn::Attribute(coordinates)},
                 {"nearest_mode", nn::Attribute(nearest)}}));
            ++count;
            if (std::vector<double>(found.begin(), found.end()) != expected) ++wrong;
          }
        }
  CHECK(wrong == 0);
  CHECK(count > 9000);
}

TEST_CASE("Resize interpolates linearly", "[nn][network][resize]") {
  const auto mode = name("linear");
  check(picture(four, 2, 2, scales({1, 1, 2, 2}), {}, {{"mode", mode}}), {1, 1, 4, 4},
        {1, 1.25, 1.75, 2, 1.5, 1.75, 2.25, 2.5, 2.5, 2.75, 3.25, 3.5, 3, 3.25, 3.75, 4});
  const double t = 1.0 / 3;
  check(picture(four, 2, 2, scales({1, 1, 2, 2}), {},
                {{"mode", mode}, {"coordinate_transformation_mode", name("align_corners")}}),
        {1, 1, 4, 4},
        {1, 1 + t, 2 - t, 2, 2 - t, 2, 2 + t, 3 - t, 2 + t, 3 - t, 3, 3 + t, 3, 3 + t, 4 - t, 4});
  // x = 1/3, 2 for columns and 1/3 for the row
  check(picture(eight, 2, 4, scales({1, 1, 0.6, 0.6}), {}, {{"mode", mode}}), {1, 1, 1, 2},
        {8.0 / 3, 13.0 / 3});
  check(picture({1, 2, 3}, 1, 3, {}, numbers({1, 1, 1, 1}),
                {{"mode", mode}, {"coordinate_transformation_mode", name("pytorch_half_pixel")}}),
        {1, 1, 1, 1}, {1});
  // scale 0.625 of 4, 2 out: x = 4/2·(1 − 2/2.5) + (i + 0.5)/0.625 − 0.5 = 0.7, 2.3
  check(picture({1, 2, 3, 4}, 1, 4, scales({1, 1, 1, 0.625}), {},
                {{"mode", mode}, {"coordinate_transformation_mode", name("half_pixel_symmetric")}}),
        {1, 1, 1, 2}, {1.7, 3.3});
}

TEST_CASE("Resize interpolates by cubics", "[nn][network][resize]") {
  // At t = 0.25 and 0.75 Keys' kernel has the weights −0.10546875, 0.87890625, 0.26171875, −0.03515625
  const std::vector<double> ramp = {1, 2, 3, 4};
  const auto at = [&](std::vector<double> weights, std::vector<double> values) {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += weights[i] * values[i];
    return sum;
  };
  const std::vector<double> quarter = {-0.10546875, 0.87890625, 0.26171875, -0.03515625};
  const std::vector<double> three = {-0.03515625, 0.26171875, 0.87890625, -0.10546875};
  // x = −0.25, 0.25, 0.75, 1.25, 1.75, …
  check(picture(ramp, 1, 4, scales({1, 1, 1, 2}), {}, {{"mode", name("cubic")}}), {1, 1, 1, 8},
        {at(three, {1, 1, 1, 2}), at(quarter, {1, 1, 2, 3}), at(three, {1, 1, 2, 3}),
         at(quarter, {1, 2, 3, 4}), at(three, {1, 2, 3, 4}), at(quarter, {2, 3, 4, 4}),
         at(three, {2, 3, 4, 4}), at(quarter, {3, 4, 4, 4})});
  const double inside = three[2] + three[3];
  const auto outside = result_of<double>(picture(
      ramp, 1, 4, scales({1, 1, 1, 2}), {}, {{"mode", name("cubic")}, {"exclude_outside", std::int64_t(1)}}));
  CHECK(outside[0] == Approx((three[2] * 1 + three[3] * 2) / inside));
  const auto other = result_of<double>(
      picture(ramp, 1, 4, scales({1, 1, 1, 2}), {}, {{"mode", name("cubic")}, {"cubic_coeff_a", -0.5}}));
  // a = −0.5 reproduces straight lines
  CHECK(other[3] == Approx(2.25));
  CHECK(other[4] == Approx(2.75));
}

TEST_CASE("Resize crops what tf_crop_and_resize names", "[nn][network][resize]") {
  OperatorNetwork test =
      picture(sixteen, 4, 4, {}, numbers({1, 1, 3, 3}),
              {{"mode", name("linear")}, {"coordinate_transformation_mode", name("tf_crop_and_resize")}});
  test.operands[1] = scales({0, 0, 0.4, 0.6, 1, 1, 0.6, 0.8});
  // rows 1.2, 1.5, 1.8 and columns 1.8, 2.1, 2.4
  check(test, {1, 1, 3, 3}, {7.6, 7.9, 8.2, 8.8, 9.1, 9.4, 10, 10.3, 10.6});
  test.operands[1] = scales({0, 0, 0.4, 0.6, 1, 1, 1.2, 1.7});
  test.node.attributes["extrapolation_value"] = 10.0;
  // rows 1.2, 2.4, 3.6 and columns 1.8, 3.45, 5.1: only the first of each is inside, and row 2.4
  check(test, {1, 1, 3, 3}, {7.6, 10, 10, 12.4, 10, 10, 10, 10, 10});
  check_adjoints(test);
}

TEST_CASE("Resize keeps the aspect ratio where it is asked to, and takes axes", "[nn][network][resize]") {
  OperatorNetwork test =
      picture(eight, 2, 4, {}, numbers({6, 6}),
              {{"axes", std::vector<std::int64_t>{2, -1}}, {"keep_aspect_ratio_policy", name("not_larger")}});
  test.opset = 18;
  CHECK(test.network<double>().output_shape(0) == nn::Shape{1, 1, 3, 6});
  test.node.attributes["keep_aspect_ratio_policy"] = name("not_smaller");
  CHECK(test.network<double>().output_shape(0) == nn::Shape{1, 1, 6, 12});
}

TEST_CASE("Upsample and the first Resize read asymmetrically", "[nn][network][resize]") {
  OperatorNetwork test = picture(four, 2, 2, {}, {}, {});
  const std::vector<double> expected = {1, 1, 2, 2, 1, 1, 2, 2, 3, 3, 4, 4, 3, 3, 4, 4};
  test.operands = {test.operands[0], scales({1, 1, 2, 2})};
  test.opset = 10;
  check(test, {1, 1, 4, 4}, expected);
  test.node.operation = "Upsample";
  test.opset = 9;
  check(test, {1, 1, 4, 4}, expected);
  test.operands.resize(1);
  test.node.attributes["scales"] = std::vector<double>{1, 1, 2, 2};
  test.opset = 7;
  check(test, {1, 1, 4, 4}, expected);
  test.node.attributes["mode"] = name("linear");
  check(test, {1, 1, 4, 4}, {1, 1.5, 2, 2, 2, 2.5, 3, 3, 3, 3.5, 4, 4, 3, 3.5, 4, 4});
}

TEST_CASE("Resize's adjoint agrees with central differences", "[nn][network][resize][gradient]") {
  for (const char* mode : {"nearest", "linear", "cubic"})
    for (const nn::Shape& shape : {nn::Shape{2, 19, 5, 6}, nn::Shape{2, 3, 7}, nn::Shape{4, 5}}) {
      for (const std::vector<double>& factors :
           {std::vector<double>{1, 1, 2, 2}, {1, 1, 3, 2}, {1, 1, 0.6, 1.7}, {2, 1.5, 1, 0.5}}) {
        CAPTURE(mode, shape, factors);
        const auto first = factors.end() - static_cast<std::ptrdiff_t>(shape.size());
        check_adjoints(operator_network("Resize", {given(shape, 3), {}, scales({first, factors.end()})},
                                        {{"mode", name(mode)}}));
      }
    }
}

TEST_CASE("Resize refuses what makes no sense", "[nn][network][resize]") {
  const auto refusal = [](const std::map<std::string, nn::Attribute>& attributes) {
    return refusal_of(picture(four, 2, 2, scales({1, 1, 2, 2}), {}, attributes));
  };
  CHECK_THAT(refusal({{"mode", name("quintic")}}), contains("attribute 'mode' is 'quintic'"));
  CHECK_THAT(refusal({{"nearest_mode", name("odd")}}), contains("attribute 'nearest_mode' is 'odd'"));
  CHECK_THAT(refusal({{"coordinate_transformation_mode", name("odd")}}),
             contains("attribute 'coordinate_transformation_mode' is 'odd'"));
  CHECK_THAT(refusal({{"coordinate_transformation_mode", name("tf_crop_and_resize")}}),
             contains("roi has 0 values, expected 8"));
  CHECK_THAT(refusal_of(picture(four, 2, 2, {}, {}, {})), contains("expected either scales or sizes"));
  CHECK_THAT(refusal_of(picture(four, 2, 2, scales({1, 1, 2, 2}), numbers({1, 1, 4, 4}), {})),
             contains("expected either scales or sizes"));
  CHECK_THAT(refusal_of(picture(four, 2, 2, scales({2, 2}), {}, {})),
             contains("scales has 2 values, expected 4"));
  CHECK_THAT(refusal_of(picture(four, 2, 2, scales({1, 1, 0.1, 1}), {}, {})),
             contains("an extent would be 0.000000 after resizing"));
  CHECK_THAT(refusal_of(picture(four, 2, 2, scales({1, 1, -1, 1}), {}, {})), contains("a scale is -1"));
  CHECK_THAT(
      refusal_of(picture(four, 2, 2, {}, numbers({1, 1, 3, 3}), {{"keep_aspect_ratio_policy", name("odd")}})),
      contains("'keep_aspect_ratio_policy' is 'odd'"));
  OperatorNetwork test = picture(four, 2, 2, given({4}, 1), {}, {});
  CHECK_THAT(refusal_of(test), contains("input 2 is computed; only a constant one is supported"));
}
