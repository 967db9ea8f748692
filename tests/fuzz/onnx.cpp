#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/onnx_builder.hpp"
#include "target.hpp"

namespace {
using namespace tapestry;

void read(const std::string& bytes) { (void)io::parse_onnx(bytes, fuzz::folder().path("a.onnx")); }

void read_tensor(const std::string& bytes) {
  (void)io::read_onnx_tensor(fuzz::folder().write("tensor.pb", bytes));
}

std::vector<std::string> tensors() {
  using namespace test::onnx;
  return {float_tensor("a", {1, 2}, {0.5F, -2}), int64_tensor("", {3}, {1, -1, 7}),
          tensor("b", float32, {2}, floats_field(4, {1, 2}, Packing::packed)),
          tensor("c", float16, {2}, integers_field(5, {0x3C00, 0x7BFF}))};
}

const fuzz::Registered onnx({"onnx", read,
                             [] { return std::vector{test::onnx::model(test::onnx::small_model())}; }});
const fuzz::Registered tensor({"onnx_tensor", read_tensor, tensors});
}  // namespace
