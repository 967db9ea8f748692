#include <tapestry/nn/detail/network/operators/gather.hpp>

#include "../../../support/operator_case.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
constexpr std::int64_t zero = 0, one = 1;
const std::string add = "add", multiply = "mul", largest = "max", smallest = "min";

nn::Constant indices(nn::Shape shape, std::vector<double> values) {
  return {std::move(shape), nn::ElementType::integer, std::move(values)};
}
}  // namespace

TEST_CASE("adjoints of operators that gather agree with central differences", "[nn][network][gradient]") {
  const auto twice = indices({2, 2}, {0, -1, 2, 0});  // element 0 and the last one are named twice
  for (const std::int64_t axis : {0, 1, 2, 3, -2})
    check_operator({"Gather", {{3, 4, 3, 3}}, {{"axis", axis}}, {{1, twice}}});
  check_operator({"Gather", {{3, 4}}, {{"axis", one}}, {{1, indices({}, {2})}}});
  check_operator({"GatherElements", {{3, 4}}, {{"axis", one}}, {{1, indices({3, 2}, {0, 3, 1, 1, -4, 2})}}});
  check_operator({"GatherElements", {{3, 4}}, {}, {{1, indices({1, 2}, {2, -3})}}});
  check_operator({"GatherND", {{3, 4, 2}}, {}, {{1, indices({3, 2}, {0, 1, 2, -1, 0, 1})}}});
  check_operator({"GatherND", {{2, 4, 2}}, {{"batch_dims", one}}, {{1, indices({2, 1}, {3, 0})}}});
}

TEST_CASE("adjoints of operators that scatter agree with central differences", "[nn][network][gradient]") {
  const auto rows = indices({3, 1}, {2, 0, -2});  // the last one is row 2 again
  for (const std::string& rule : {std::string("none"), add, multiply, largest, smallest}) {
    check_operator({"ScatterND", {{4, 2}, {3, 2}}, {{"reduction", rule}}, {{1, rows}}, 18});
    check_operator({"ScatterElements",
                    {{3, 4}, {3, 2}},
                    {{"reduction", rule}, {"axis", one}},
                    {{1, indices({3, 2}, {0, 0, 1, 3, -1, -1})}},
                    18});
  }
  check_operator({"ScatterND", {{2, 3, 2}, {2, 2}}, {}, {{1, indices({2, 2}, {1, 2, 0, 0})}}, 13});
  check_operator({"ScatterND", {{4}}, {}, {{1, indices({1, 1}, {1})}, {2, numbers({1}, {7})}}, 13});
}

TEST_CASE("adjoints of operators along an axis agree with central differences", "[nn][network][gradient]") {
  for (const std::int64_t axis : {0, 1, 3, -2}) {
    check_operator({"TopK", {{3, 4, 3, 3}}, {{"axis", axis}}, {{1, integers({2})}}, 11, -1, 1, {}, 2});
    check_operator({"CumSum", {{2, 3, 2, 2}}, {}, {{1, integers({static_cast<double>(axis)})}}});
    check_operator({"CumSum",
                    {{2, 3, 2, 2}},
                    {{"exclusive", one}, {"reverse", one}},
                    {{1, integers({static_cast<double>(axis)})}}});
  }
  check_operator({"TopK", {{7}}, {{"k", std::int64_t(3)}}, {}, 9, -1, 1, {}, 1});
  for (const std::int64_t upper : {0, 1})
    for (const double diagonal : {-1, 0, 2, 9})
      check_operator({"Trilu", {{2, 3, 4}}, {{"upper", upper}}, {{1, integers({diagonal})}}});
  check_operator({"Cast", {{2, 3}}, {{"to", std::int64_t(11)}}});
}

TEST_CASE("blocks are gathered and scattered as numpy does", "[nn][network]") {
  const std::vector<double> x = {1, 2, 3, 4, 5, 6};
  CHECK(results_of({"Gather", {{3, 2}}, {}, {{1, indices({2}, {2, -3})}}}, {x}) ==
        std::vector<double>{5, 6, 1, 2});
  CHECK(results_of({"Gather", {{3, 2}, {2}}}, {x, {2, -3}}, nn::ElementType::integer) ==
        std::vector<double>{5, 6, 1, 2});  // computed ones
  CHECK(results_of({"GatherElements", {{2, 2}}, {{"axis", one}}, {{1, indices({2, 2}, {0, 0, 1, 0})}}},
                   {{1, 2, 3, 4}}) == std::vector<double>{1, 1, 4, 3});
  CHECK(results_of({"GatherND", {{2, 2}}, {}, {{1, indices({2, 2}, {0, 0, 1, 1})}}}, {{0, 1, 2, 3}}) ==
        std::vector<double>{0, 3});
  CHECK(results_of({"ScatterND", {{8}, {4}}, {}, {{1, indices({4, 1}, {4, 3, 1, 7})}}},
                   {{1, 2, 3, 4, 5, 6, 7, 8}, {9, 10, 11, 12}}) ==
        std::vector<double>{1, 11, 3, 10, 9, 6, 7, 12});
  CHECK(results_of({"ScatterElements", {{1, 5}, {1, 2}}, {{"axis", one}}, {{1, indices({1, 2}, {1, -2})}}},
                   {{1, 2, 3, 4, 5}, {1.5, 2.5}}) == std::vector<double>{1, 1.5, 3, 2.5, 5});
}

TEST_CASE("orders, sums and triangles are those of ONNX", "[nn][network]") {
  const std::vector<double> x = {3, 1, 3, 2};
  const auto top = [&](std::int64_t is_largest) {
    return results_of({"TopK", {{4}}, {{"largest", is_largest}}, {{1, integers({3})}}, 11, -1, 1, {}, 2},
                      {x});
  };
  CHECK(top(1) == std::vector<double>{3, 3, 2, 0, 2, 3});
  CHECK(top(0) == std::vector<double>{1, 2, 3, 1, 3, 0});
  const auto arg = [&](const char* name, std::int64_t takes_last) {
    return results_of({name, {{4}}, {{"select_last_index", takes_last}}, {}, 13}, {x}).at(0);
  };
  CHECK(arg("ArgMax", 0) == 0);
  CHECK(arg("ArgMax", 1) == 2);
  CHECK(arg("ArgMin", 0) == 1);
  const auto columns = results_of({"ArgMax", {{2, 2, 2}}, {{"axis", one}, {"keepdims", zero}}, {}, 13},
                                  {{1, 9, 2, 8, 7, 5, 6, 5}});
  CHECK(columns == std::vector<double>{1, 0, 0, 0});
  CHECK(std::isnan(results_of({"TopK", {{3}}, {}, {{1, integers({1})}}}, {{1, std::nan(""), 2}}).at(0)));
  CHECK(results_of({"Hardmax", {{2, 3}}}, {{1, 4, 4, 2, 1, 0}}) == std::vector<double>{0, 1, 0, 1, 0, 0});
  CHECK(results_of({"Hardmax", {{2, 2}}, {{"axis", zero}}}, {{1, 4, std::nan(""), 4}}) ==
        std::vector<double>{0, 1, 1, 0});
  CHECK(results_of({"Hardmax", {{1, 2, 2}}, {}, {}, 11}, {{1, 4, 5, 4}}) ==
        std::vector<double>{0, 0, 1, 0});  // normalises over all axes from the second on
  CHECK(results_of({"EyeLike", {{2, 3}}, {{"k", one}}}, {std::vector<double>(6, 7)}) ==
        std::vector<double>{0, 1, 0, 0, 0, 1});
  CHECK(results_of({"EyeLike", {{3, 2}}, {{"k", std::int64_t(-1)}}}, {std::vector<double>(6, 7)}) ==
        std::vector<double>{0, 0, 1, 0, 0, 1});
  const auto sums = [&](std::int64_t exclusive, std::int64_t reverse) {
    return results_of(
        {"CumSum", {{4}}, {{"exclusive", exclusive}, {"reverse", reverse}}, {{1, integers({0})}}}, {x});
  };
  CHECK(sums(0, 0) == std::vector<double>{3, 4, 7, 9});
  CHECK(sums(1, 0) == std::vector<double>{0, 3, 4, 7});
  CHECK(sums(0, 1) == std::vector<double>{9, 6, 5, 2});
  CHECK(sums(1, 1) == std::vector<double>{6, 5, 2, 0});
  CHECK(results_of({"Trilu", {{2, 2}}}, {x}) == std::vector<double>{3, 1, 0, 2});
  CHECK(results_of({"Trilu", {{2, 2}}, {{"upper", zero}}, {{1, integers({-1})}}}, {x}) ==
        std::vector<double>{0, 0, 3, 0});
}

TEST_CASE("types are changed as ONNX says", "[nn][network]") {
  const auto cast = [](std::int64_t to) {
    return results_of({"Cast", {{4}}, {{"to", to}}}, {{-1.5, 0, 0.5, 2.75}});
  };
  CHECK(cast(7) == std::vector<double>{-1, 0, 0, 2});
  CHECK(cast(9) == std::vector<double>{1, 0, 1, 1});
  CHECK(cast(1) == std::vector<double>{-1.5, 0, 0.5, 2.75});
  CHECK(results_of({"CastLike", {{2}}, {}, {{1, integers({1})}}}, {{-1.5, 2.5}}) ==
        std::vector<double>{-1, 2});
}

TEST_CASE("tensors are made of extents, ranges and indices", "[nn][network]") {
  CHECK(results_of({"ConstantOfShape", {}, {{"value", numbers({1}, {7})}}, {{0, integers({2, 2})}}}, {}) ==
        std::vector<double>{7, 7, 7, 7});
  CHECK(results_of({"ConstantOfShape", {}, {}, {{0, integers({})}}}, {}) == std::vector<double>{0});
  const auto range = [](double start, double limit, double delta) {
    return results_of(
        {"Range", {}, {}, {{0, integers({start})}, {1, integers({limit})}, {2, integers({delta})}}}, {});
  };
  CHECK(range(1, 6, 2) == std::vector<double>{1, 3, 5});
  CHECK(range(3, 0, -1) == std::vector<double>{3, 2, 1});
  CHECK(range(3, 0, 1).empty());
  const OperatorCase one_hot{
      "OneHot", {{3}}, {{"axis", zero}}, {{1, integers({2})}, {2, numbers({2}, {5, 9})}}};
  CHECK(results_of(one_hot, {{0, -1, 4}}) == std::vector<double>{9, 5, 5, 5, 9, 5});
  const auto mask = results_of({"Dropout", {{2}}, {}, {}, 13, -1, 1, {}, 2}, {{3, 4}});
  CHECK(mask == std::vector<double>{3, 4, 1, 1});
}

TEST_CASE("non-maximum suppression chooses the best boxes that do not overlap", "[nn][network]") {
  const std::vector<double> boxes = {0, 0, 1, 1, 1, 1.1, 0, 0.1, 0, -0.1, 1, 0.9, 0, 10, 1, 11};
  OperatorCase given{"NonMaxSuppression",
                     {},
                     {},
                     {{0, numbers({1, 4, 4}, boxes)},
                      {1, numbers({1, 1, 4}, {0.9, 0.75, 0.6, 0.95})},
                      {2, integers({3})},
                      {3, numbers({1}, {0.5})},
                      {4, numbers({1}, {0})}},
                     11};
  CHECK(results_of(given, {}) == std::vector<double>{0, 0, 3, 0, 0, 0});
  given.constants[3] = numbers({1}, {0.9});
  CHECK(results_of(given, {}) == std::vector<double>{0, 0, 3, 0, 0, 0, 0, 0, 1});
  given.constants[2] = integers({2});
  CHECK(results_of(given, {}) == std::vector<double>{0, 0, 3, 0, 0, 0});
  given.constants[2] = integers({std::ldexp(1.0, 62)});  // torch's value for no limit
  CHECK(results_of(given, {}) == std::vector<double>{0, 0, 3, 0, 0, 0, 0, 0, 1, 0, 0, 2});
  given.constants[4] = numbers({1}, {0.92});
  CHECK(results_of(given, {}) == std::vector<double>{0, 0, 3});
  for (const std::size_t bound : {2U, 3U, 4U}) {
    auto unbounded = given;
    unbounded.constants[bound] = numbers({1}, {std::nan("")});
    CHECK(complaint_of(unbounded) == "input " + std::to_string(bound) + " is NaN");
  }
}

TEST_CASE("boxes of which a picture leaves an unknown number are refused with node and file",
          "[nn][network]") {
  OperatorCase given{
      "NonMaxSuppression", {{1, 4, 4}, {1, 1, 4}}, {}, {{2, integers({3})}, {3, numbers({1}, {0.5})}}, 11};
  nn::NetworkDescription network = description_of(given);
  network.nodes.back().name = "nms";
  // As in an export: the chosen boxes' numbers read the boxes.
  network.constants["two"] = integers({2});
  network.nodes.push_back({"", "Gather", {"y0", "two"}, {"places"}, {{"axis", one}}});
  network.nodes.push_back({"", "Gather", {"x0", "places"}, {"chosen"}, {{"axis", one}}});
  network.outputs = {"chosen"};
  CHECK_THROWS_WITH(
      nn::Network<float>(network),
      "net.onnx: 1 node cannot be run: NonMaxSuppression \"nms\" (opset 11): the number of boxes "
      "left depends on the picture, which is not supported; choose outputs before this node");
  given.constants[0] = numbers({1, 4, 4}, std::vector<double>(16, 1));  // nor of scores alone
  given.shapes = {{1, 1, 4}};
  CHECK(complaint_of(given).starts_with("the number of boxes left depends on the picture"));
}

TEST_CASE("a grid reads between pixels and beyond them", "[nn][network]") {
  const std::vector<double> x = {1, 2, 3, 4};
  const auto at = [&](double column, double row, const std::string& mode, const std::string& padding,
                      std::int64_t aligned) {
    return results_of({"GridSample",
                       {{1, 1, 2, 2}, {1, 1, 1, 2}},
                       {{"mode", mode}, {"padding_mode", padding}, {"align_corners", aligned}}},
                      {x, {column, row}})
        .at(0);
  };
  for (const std::int64_t aligned : {0, 1}) CHECK(at(0, 0, "bilinear", "zeros", aligned) == 2.5);
  CHECK(at(-1, 1, "bilinear", "zeros", 1) == 3);
  CHECK(at(-1, -1, "bilinear", "zeros", 0) == 0.25);  // half a pixel out along both axes
  CHECK(at(-1, -1, "linear", "border", 0) == 1);
  CHECK(at(-1, -1, "bilinear", "reflection", 0) == 1);
  CHECK(at(3.5, 0, "bilinear", "zeros", 0) == 0);
  CHECK(at(3.5, -0.5, "bilinear", "border", 0) == 2);
  CHECK(at(2.5, -0.5, "bilinear", "reflection", 0) == 1);  // columns 1, 1, 0, 0 lie behind the second one
  CHECK(at(2, -1, "bilinear", "reflection", 1) == 1.5);
  CHECK(at(0.4, 0.6, "nearest", "zeros", 0) == 4);
  CHECK(at(0.5, -0.5, "bicubic", "zeros", 0) == 2);  // a pixel's centre
  CHECK(at(0, 0, "cubic", "border", 0) == Approx(2.5).epsilon(1e-14));
  CHECK(std::isnan(at(std::nan(""), 0, "bilinear", "border", 0)));
  const double far = std::numeric_limits<double>::max();
  CHECK(at(far, -far, "bilinear", "zeros", 0) == 0);
  CHECK(at(far, -far, "bicubic", "border", 1) == 2);
  CHECK(complaint_of({"GridSample", {{1, 1, 2, 2}, {1, 1, 2}}}) ==
        "pictures and grid are [1, 1, 2, 2] and [1, 1, 2], expected [N, C, H, W] and [N, rows, columns, 2]");
  CHECK(complaint_of({"GridSample", {{1, 1, 2, 2}, {1, 1, 1, 2}}, {{"mode", std::string("area")}}}) ==
        "attribute 'mode' is 'area'");
}

TEST_CASE("adjoints of reading by a grid agree with central differences", "[nn][network][gradient]") {
  for (const std::string& mode : {std::string("bilinear"), std::string("nearest"), std::string("bicubic")})
    for (const std::string& padding :
         {std::string("zeros"), std::string("border"), std::string("reflection")})
      for (const std::int64_t aligned : {0, 1}) {
        std::vector<double> kinks;  // where a coordinate is a pixel's centre, half way between two or an edge
        for (int k = -16; k <= 16; ++k) {
          kinks.push_back(k / 8.0);
          kinks.push_back(k / 6.0);
        }
        const std::map<std::string, nn::Attribute> attributes{
            {"mode", mode}, {"padding_mode", padding}, {"align_corners", aligned}};
        check_operator({"GridSample", {{2, 3, 4, 4}, {2, 3, 2, 2}}, attributes, {}, 16, -1.4, 1.4, kinks});
      }
  check_operator({"GridSample", {{1, 2, 1, 1}, {1, 1, 2, 2}}, {{"align_corners", one}}, {}, 16, -0.7, 0.7});
}

TEST_CASE("indices out of range are an error when a network runs", "[nn][network]") {
  const OperatorCase gather{"Gather", {{3}, {1}}};
  const auto type = nn::ElementType::integer;
  CHECK_THROWS_WITH(results_of(gather, {{1, 2, 3}, {3}}, type), contains("of 3"));
  CHECK_THROWS_AS(results_of(gather, {{1, 2, 3}, {-4}}, type), FileError);
  CHECK_THROWS_AS(results_of(gather, {{1, 2, 3}, {std::nan("")}}, type), FileError);
  CHECK_THROWS_AS(results_of({"ScatterND", {{3}, {1, 1}, {1}}}, {{1, 2, 3}, {1e30}, {1}}, type), FileError);
}

TEST_CASE("an index from the end of more elements than a float counts is that element, and NaN is none",
          "[nn][network]") {
  constexpr std::size_t extent = (std::size_t(1) << 24U) + 4;
  const nn::IndexPlan plan = nn::IndexPlan::of_axis({extent}, 0, 4);
  const std::vector<float> indices = {-1, -float(extent), 0, 16777218};
  std::vector<nn::ElementIndex<float>> places(4);
  plan.write_places(indices.data(), places.data());
  CHECK(places == std::vector<nn::ElementIndex<float>>{extent - 1, 0, 0, 16777218});
  for (const float index : {float(extent), -float(extent) - 2, 1e30F, -1e30F,
                            std::numeric_limits<float>::infinity(), std::nanf("")}) {
    CHECK(nn::place_of_index(index, extent) == extent);
    CHECK_THROWS_AS(plan.write_places(std::vector<float>(4, index).data(), places.data()), DomainError);
  }
  CHECK(nn::place_of_index(-1.0, std::size_t(0)) == 0);  // of nothing
}

TEST_CASE("indices and settings that make no sense are refused", "[nn][network]") {
  const auto type = nn::ElementType::integer;
  CHECK(complaint_of({"Gather", {{}, {1}}}, type) == "a scalar has no axes");
  CHECK(complaint_of({"Gather", {{2}, {1}}, {{"axis", one}}}, type) == "axis 1 of 1 axes");
  CHECK(complaint_of({"GatherElements", {{2, 2}, {2}}}, type) == "indices are [2] for [2, 2]");
  CHECK(complaint_of({"GatherElements", {{2, 2}, {2, 3}}}, type) == "indices are [2, 3] for [2, 2]");
  CHECK(complaint_of({"GatherND", {{2, 2}, {2, 3}}}, type) == "indices are [2, 3] for [2, 2]");
  CHECK(complaint_of({"GatherND", {{2, 2}, {3, 1}}, {{"batch_dims", one}}}, type) ==
        "indices are [3, 1] for [2, 2]");
  CHECK(complaint_of({"ScatterND", {{2, 2}, {1, 1}, {1, 1}}}, type) == "updates are [1, 1], expected [1, 2]");
  CHECK(complaint_of({"ScatterND", {{2}, {1, 1}, {1}}, {{"reduction", std::string("sub")}}}, type) ==
        "reduction is 'sub', expected 'none', 'add', 'mul', 'max' or 'min'");
  CHECK(complaint_of({"Gather", {{2}, {1}}}) == "input 1 holds floating-point numbers, expected integers");
  CHECK(complaint_of({"TopK", {{2}}, {}, {{1, integers({3})}}}) == "k is 3 of 2 elements");
  CHECK(complaint_of({"TopK", {{2}, {1}}}) == "input 1 is computed; only a constant one is supported");
  CHECK(complaint_of({"ArgMax", {{2, 0}}, {{"axis", one}}}) == "axis 1 has no elements");
  CHECK(complaint_of({"Trilu", {{2}}}) == "[2] is no matrix");
  CHECK(complaint_of({"Cast", {{2}}, {{"to", std::int64_t(8)}}}) == "element type 8 is not supported");
  CHECK(complaint_of({"Range", {}, {}, {{0, integers({0})}, {1, integers({1})}, {2, integers({0})}}}) ==
        "a range of inf elements, expected at most 2147483647");
  CHECK(complaint_of({"NonMaxSuppression", {{1, 4, 4}, {1, 1, 3}}}) ==
        "boxes and scores are [1, 4, 4] and [1, 1, 3], expected [N, B, 4] and [N, K, B]");
  CHECK(complaint_of({"Dropout", {{2}}, {}, {{1, numbers({}, {0.5})}, {2, numbers({}, {1})}}, 13}) ==
        "training_mode is true; only false is supported");
}
