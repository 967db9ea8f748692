#include "../../../support/operator_case.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

TEST_CASE("X30: an attribute that is a flag is 0 or 1", "[nn][network][attributes]") {
  const auto list = [](double value) { return integers({value}); };
  const nn::Shape picture{1, 2, 4, 4};
  const std::map<std::string, nn::Attribute> window{{"kernel_shape", std::vector<std::int64_t>{2, 2}}};
  const std::vector<std::pair<OperatorCase, std::vector<const char*>>> all{
      {{"ReduceSum", {picture}}, {"keepdims", "noop_with_empty_axes"}},
      {{"ArgMax", {picture}}, {"keepdims", "select_last_index"}},
      {{"TopK", {picture}, {}, {{1, list(1)}}, 17, -1, 1, {}, 2}, {"largest", "sorted"}},
      {{"CumSum", {picture}, {}, {{1, list(1)}}}, {"exclusive", "reverse"}},
      {{"MaxPool", {picture}, window}, {"ceil_mode", "storage_order"}},
      {{"AveragePool", {picture}, window}, {"ceil_mode", "count_include_pad"}},
      {{"Gemm", {{3, 3}, {3, 3}}}, {"transA", "transB"}},
      {{"Mod", {{3}, {3}}, {{"fmod", std::int64_t(1)}}}, {"fmod"}},
      {{"Reshape", {picture}, {}, {{1, list(32)}}}, {"allowzero"}},
      {{"IsInf", {picture}}, {"detect_negative", "detect_positive"}},
      {{"Trilu", {picture}}, {"upper"}},
      {{"GridSample", {picture, {1, 3, 3, 2}}}, {"align_corners"}},
      {{"Resize", {picture}, {}, {{1, numbers({0}, {})}, {2, numbers({4}, {1, 1, 2, 2})}}, 18},
       {"antialias", "exclude_outside"}},
      {{"NonMaxSuppression", {}, {}, {{0, numbers({1, 1, 4}, {0, 0, 1, 1})}, {1, numbers({1, 1, 1}, {1})}}},
       {"center_point_box"}},
      {{"BatchNormalization", {picture, {2}, {2}, {2}, {2}}}, {"training_mode"}},
      {{"Attention", {picture, picture, picture}, {}, {}, 23}, {"is_causal"}},
      {{"LSTM", {{4, 2, 3}, {1, 8, 3}, {1, 8, 2}}}, {"layout", "input_forget"}},
      {{"GRU", {{4, 2, 3}, {1, 6, 3}, {1, 6, 2}}}, {"layout", "linear_before_reset"}},
      {{"RNN", {{4, 2, 3}, {1, 2, 3}, {1, 2, 2}}}, {"layout"}},
  };
  for (const auto& [given, flags] : all)
    for (const char* flag : flags)
      for (const std::int64_t value :
           {std::int64_t(-1), std::int64_t(2), std::int64_t(7), std::int64_t(1) << 40U}) {
        CAPTURE(given.operation, flag, value);
        CHECK(complaint_of(given).empty());
        OperatorCase wrong = given;
        wrong.attributes[flag] = value;
        const std::string said = complaint_of(wrong);
        CHECK_THAT(said, contains("attribute '" + std::string(flag) + "' is "));
        CHECK_THAT(said, contains(std::to_string(value) + ", expected 0 "));
      }
}
