#include "../../../support/operator_case.hpp"

using namespace tapestry;
using namespace tapestry::test;
using Integers = std::vector<std::int64_t>;

namespace {
constexpr std::int64_t one = 1, two = 2;
const std::string edge = "edge", reflect = "reflect", wrap = "wrap";

nn::Shape shape_of(const OperatorCase& given) {
  return nn::Network<double>(description_of(given)).output_shape(0);
}

/// 0, 1, 2, …
std::vector<double> counted(std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<double>(i);
  return values;
}

OperatorCase slice(nn::Shape shape, std::vector<double> starts, std::vector<double> ends,
                   std::vector<double> axes, std::vector<double> steps) {
  return {"Slice",
          {std::move(shape)},
          {},
          {{1, integers(std::move(starts))},
           {2, integers(std::move(ends))},
           {3, integers(std::move(axes))},
           {4, integers(std::move(steps))}},
          13};
}

OperatorCase pad(nn::Shape shape, std::vector<double> pads, const std::string& mode, double fill = 0) {
  return {"Pad",
          {std::move(shape)},
          {{"mode", mode}},
          {{1, integers(std::move(pads))}, {2, numbers({}, {fill})}},
          19};
}
}  // namespace

TEST_CASE("adjoints of operators that renumber agree with central differences", "[nn][network][gradient]") {
  check_operator({"Reshape", {{2, 3, 2, 2}}, {}, {{1, integers({0, -1, 3})}}});
  check_operator({"Flatten", {{2, 3, 2, 2}}, {{"axis", two}}});
  check_operator({"Squeeze", {{2, 3, 1, 1}}, {}, {{1, integers({-1, 2})}}});
  check_operator({"Squeeze", {{2, 3, 1, 1}}, {{"axes", Integers{2}}}, {}, 11});
  check_operator({"Unsqueeze", {{2, 3, 2, 2}}, {}, {{1, integers({0, -1})}}});
  check_operator({"Unsqueeze", {{2, 3}}, {{"axes", Integers{1, 3}}}, {}, 11});
  check_operator({"Identity", {{2, 3, 2, 2}}});
  check_operator({"Dropout", {{2, 3, 2, 2}}, {}, {}, 13});
}

TEST_CASE("adjoints of operators on boxes agree with central differences", "[nn][network][gradient]") {
  for (const Integers& order : {Integers{0, 2, 3, 1}, Integers{3, 1, 0, 2}, Integers{0, 1, 3, 2}})
    check_operator({"Transpose", {{2, 3, 4, 5}}, {{"perm", order}}});
  check_operator({"Transpose", {{2, 3, 4}}});
  check_operator({"Transpose", {{20, 40}}});
  check_operator(slice({2, 4, 5, 3}, {1, -1}, {3, -100}, {1, 2}, {1, -2}));
  check_operator(slice({2, 4, 5, 3}, {0}, {9e18}, {3}, {2}));
  check_operator(slice({2, 4}, {1}, {1}, {1}, {1}));
  check_operator({"Slice",
                  {{2, 4, 5, 3}},
                  {{"starts", Integers{1}}, {"ends", Integers{3}}, {"axes", Integers{1}}},
                  {},
                  9});
  for (const std::int64_t axis : {0, 1, 2, -1})
    check_operator({"Concat", {{2, 3, 2, 2}, {2, 3, 2, 2}, {2, 3, 2, 2}}, {{"axis", axis}}});
  check_operator({"Concat", {{2, 3, 2, 2}, {2, 1, 2, 2}}, {{"axis", one}}});
  check_operator({"Concat", {{2, 3, 2, 2}}, {{"axis", one}}, {{1, numbers({2, 1, 2, 2}, counted(8))}}});
  check_operator({"Concat", {{3}, {2}}, {{"axis", std::int64_t(-1)}}});
  check_operator({"Split", {{2, 6, 2, 2}}, {{"axis", one}}, {}, 13, -1, 1, {}, 3, 3});
  check_operator({"Split", {{2, 6, 2, 2}}, {{"axis", one}}, {}, 13, -1, 1, {}, 3, 2});
  check_operator({"Split", {{2, 5, 2, 2}}, {{"axis", one}}, {{1, integers({1, 4})}}, 13, -1, 1, {}, 2, 2});
  check_operator({"Split", {{2, 5}}, {{"axis", one}, {"split", Integers{1, 4}}}, {}, 11, -1, 1, {}, 2, 2});
  check_operator({"Split", {{2, 5}}, {{"axis", one}, {"num_outputs", two}}, {}, 18, -1, 1, {}, 2, 2});
  check_operator({"Expand", {{2, 1, 3, 1}}, {}, {{1, integers({4, 1, 2})}}});
  check_operator({"Expand", {{2, 1, 3, 1}}, {}, {{1, integers({2, 1, 4, 1, 2})}}});
  check_operator({"Expand", {{3, 1}}, {}, {{1, integers({2, 1, 4})}}});
  check_operator({"Tile", {{2, 3, 2, 2}}, {}, {{1, integers({1, 2, 3, 1})}}});
  check_operator({"Tile", {{3}}, {}, {{1, integers({2})}}});
}

TEST_CASE("adjoints of padding and blocks agree with central differences", "[nn][network][gradient]") {
  for (const std::string& mode : {std::string("constant"), edge, reflect, wrap}) {
    check_operator(pad({2, 3, 4, 5}, {0, 1, 2, 3, 0, 0, 1, 2}, mode, 0.5));
    check_operator(pad({2, 3, 4, 5}, {0, 0, -1, 2, 0, -1, 1, -2}, mode));
    check_operator(pad({3}, {5, 7}, mode));
  }
  check_operator(
      {"Pad", {{2, 3, 2, 2}}, {{"pads", Integers{0, 0, 1, 1, 0, 0, 1, 0}}, {"value", 2.0}}, {}, 10});
  check_operator({"DepthToSpace", {{2, 8, 2, 3}}, {{"blocksize", two}}});
  check_operator({"DepthToSpace", {{2, 8, 2, 3}}, {{"blocksize", two}, {"mode", std::string("CRD")}}});
  check_operator({"SpaceToDepth", {{2, 3, 4, 6}}, {{"blocksize", two}}});
}

TEST_CASE("a value that is joined to itself gets the sum of both adjoints", "[nn][network][gradient]") {
  auto description = description_of({"Concat", {{2, 3}}, {{"axis", one}}}, true);
  nn::Node& node = description.nodes.back();
  node.inputs.push_back(node.inputs[0]);
  OperatorRun run(description);
  run.draw({"", {}}, 5);
  CHECK(test::adjoint_error(run, 1) <= 1);
}

TEST_CASE("extents are worked out as ONNX says", "[nn][network]") {
  const auto reshaped = [](nn::Shape from, std::vector<double> to, std::int64_t allowzero = 0) {
    return shape_of(
        {"Reshape", {std::move(from)}, {{"allowzero", allowzero}}, {{1, integers(std::move(to))}}});
  };
  CHECK(reshaped({2, 3, 4}, {4, -1}) == nn::Shape{4, 6});
  CHECK(reshaped({2, 3, 4}, {0, 0, 2, 2}) == nn::Shape{2, 3, 2, 2});
  CHECK(reshaped({0, 3, 4}, {3, 4, 0}, 1) == nn::Shape{3, 4, 0});
  CHECK(reshaped({1}, {}) == nn::Shape{});
  CHECK(shape_of({"Flatten", {{2, 3, 4}}, {{"axis", std::int64_t(0)}}}) == nn::Shape{1, 24});
  CHECK(shape_of({"Flatten", {{2, 3, 4}}, {{"axis", std::int64_t(-1)}}}) == nn::Shape{6, 4});
  CHECK(shape_of({"Flatten", {{2, 3, 4}}, {{"axis", std::int64_t(3)}}}) == nn::Shape{24, 1});
  CHECK(shape_of({"Squeeze", {{1, 3, 1}}}) == nn::Shape{3});
  CHECK(shape_of({"Split", {{7}}, {}, {}, 18, -1, 1, {}, 3}) == nn::Shape{3});
}

TEST_CASE("boxes are taken, turned round and repeated as numpy does", "[nn][network]") {
  CHECK(results_of({"Transpose", {{2, 3}}}, {counted(6)}) == std::vector<double>{0, 3, 1, 4, 2, 5});
  CHECK(results_of(slice({6}, {4}, {-9e18}, {0}, {-2}), {counted(6)}) == std::vector<double>{4, 2, 0});
  CHECK(results_of(slice({6}, {9e18}, {1}, {-1}, {-1}), {counted(6)}) == std::vector<double>{5, 4, 3, 2});
  CHECK(results_of(slice({6}, {-3}, {9e18}, {0}, {1}), {counted(6)}) == std::vector<double>{3, 4, 5});
  CHECK(results_of(slice({6}, {4}, {2}, {0}, {1}), {counted(6)}).empty());
  CHECK(results_of({"Expand", {{2, 1}}, {}, {{1, integers({2, 3})}}}, {counted(2)}) ==
        std::vector<double>{0, 0, 0, 1, 1, 1});
  CHECK(results_of({"Tile", {{2}}, {}, {{1, integers({2})}}}, {counted(2)}) ==
        std::vector<double>{0, 1, 0, 1});
  CHECK(results_of({"Concat", {{2, 1}, {2, 2}}, {{"axis", std::int64_t(-1)}}}, {{8, 9}, counted(4)}) ==
        std::vector<double>{8, 0, 1, 9, 2, 3});
  CHECK(results_of({"Split", {{5}}, {}, {}, 18, -1, 1, {}, 2}, {counted(5)}) == counted(5));
}

TEST_CASE("padding repeats, mirrors, wraps or cuts", "[nn][network]") {
  CHECK(results_of(pad({3}, {1, 2}, "constant", 7), {counted(3)}) == std::vector<double>{7, 0, 1, 2, 7, 7});
  CHECK(results_of(pad({3}, {1, 2}, edge), {counted(3)}) == std::vector<double>{0, 0, 1, 2, 2, 2});
  CHECK(results_of(pad({3}, {2, 2}, reflect), {counted(3)}) == std::vector<double>{2, 1, 0, 1, 2, 1, 0});
  CHECK(results_of(pad({3}, {5, 0}, reflect), {counted(3)}) == std::vector<double>{1, 0, 1, 2, 1, 0, 1, 2});
  CHECK(results_of(pad({3}, {2, 2}, wrap), {counted(3)}) == std::vector<double>{1, 2, 0, 1, 2, 0, 1});
  CHECK(results_of(pad({3}, {-1, 1}, edge), {counted(3)}) == std::vector<double>{1, 2, 2});
}

TEST_CASE("large transpositions put every element in its place", "[nn][network]") {
  const nn::Network<float> network(
      description_of({"Transpose", {{3, 85, 700}}, {{"perm", Integers{0, 2, 1}}}}));
  nn::Buffer<float> x(3 * 85 * 700);
  for (std::size_t i = 0; i < x.size(); ++i) x.data()[i] = static_cast<float>(i);
  nn::NetworkPass<float> pass;
  network.forward({x.data()}, pass);
  bool is_right = true;
  for (std::size_t n = 0; n < 3; ++n)
    for (std::size_t r = 0; r < 85; ++r)
      for (std::size_t c = 0; c < 700; ++c)
        is_right = is_right && pass.output(0)[(n * 700 + c) * 85 + r] == x.data()[(n * 85 + r) * 700 + c];
  CHECK(is_right);
}

TEST_CASE("extents and axes that make no sense are refused", "[nn][network]") {
  CHECK(complaint_of({"Reshape", {{2, 3}}, {}, {{1, integers({4})}}}) == "[2, 3] cannot become [4]");
  CHECK(complaint_of({"Reshape", {{2, 3}}, {}, {{1, integers({4, -1})}}}) == "[2, 3] cannot become [4, -1]");
  CHECK(complaint_of({"Reshape", {{2}}, {}, {{1, integers({1, 0})}}}) == "extent 0 at axis 1 of [2]");
  CHECK(complaint_of({"Reshape", {{2}}, {}, {{1, integers({-2})}}}) == "extent -2, expected 0 to 2147483647");
  CHECK(complaint_of({"Reshape", {{2}, {1}}}) == "input 1 is computed; only a constant one is supported");
  CHECK(complaint_of({"Flatten", {{2}}, {{"axis", two}}}) == "axis 2 of 1 axes");
  CHECK(complaint_of({"Squeeze", {{2, 1}}, {}, {{1, integers({0})}}}) ==
        "axis 0 of [2, 1] cannot be left out");
  CHECK(complaint_of({"Unsqueeze", {{2}}, {}, {{1, integers({0, -3})}}}) == "axis -3 is named twice");
  CHECK(complaint_of({"Transpose", {{2, 3}}, {{"perm", Integers{0, 0}}}}) ==
        "perm is not a permutation of the axes of [2, 3]");
  CHECK(complaint_of({"Transpose", {{2, 3}}, {{"perm", Integers{0}}}}) == "perm has 1 axes, expected 2");
  CHECK(complaint_of(slice({3}, {0}, {1}, {0}, {0})) == "a step is 0");
  CHECK(complaint_of(slice({3}, {0}, {1}, {1}, {1})) == "axis 1 of 1 axes");
  CHECK(complaint_of(slice({3}, {0}, {1, 2}, {0}, {1})) ==
        "starts, ends, axes and steps are not of one size");
  CHECK(complaint_of({"Concat", {{2, 3}, {3, 3}}, {{"axis", one}}}) ==
        "operand 1 is [3, 3], which cannot be joined to [2, 3]");
  CHECK(complaint_of({"Concat", {{2, 3}, {3}}, {{"axis", one}}}) ==
        "operand 1 is [3], which cannot be joined to [2, 3]");
  CHECK(complaint_of({"Split", {{5}}, {}, {}, 13, -1, 1, {}, 2}) == "5 cannot be split into 2 equal parts");
  CHECK(complaint_of({"Split", {{5}}, {}, {{1, integers({2, 2})}}, 13, -1, 1, {}, 2}) ==
        "the parts have 4 of 5");
  CHECK(complaint_of({"Expand", {{2}}, {}, {{1, integers({3})}}}) ==
        "operands of [2] and [3] do not go together");
  CHECK(complaint_of({"Tile", {{2}}, {}, {{1, integers({1, 1})}}}) == "repeats has 2 elements, expected 1");
  CHECK(complaint_of(pad({2}, {1}, edge)) == "pads has 1 elements, expected 2");
  CHECK(complaint_of(pad({2}, {-2, -1}, edge)) == "extent -1, expected 0 to 2147483647");
  CHECK(complaint_of(pad({2}, {1, 1}, "mirror")) ==
        "mode is 'mirror', expected 'constant', 'reflect', 'edge' or 'wrap'");
  CHECK(complaint_of(pad({0}, {1, 1}, edge)) == "axis 0 of [0] has nothing to pad with");
  CHECK(complaint_of({"DepthToSpace", {{1, 6, 2, 2}}, {{"blocksize", two}}}) ==
        "blocks of 2 do not fit 6 channels of 2 x 2");
  CHECK(complaint_of({"SpaceToDepth", {{1, 6, 3, 2}}, {{"blocksize", two}}}) ==
        "blocks of 2 do not fit 6 channels of 3 x 2");
  CHECK(complaint_of({"SpaceToDepth", {{6, 3, 2}}, {{"blocksize", two}}}) == "[6, 3, 2] has not four axes");
}
