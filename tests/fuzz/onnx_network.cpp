#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/onnx_builder.hpp"
#include "target.hpp"

namespace {
using namespace tapestry;

void make_network(const std::string& bytes) {
  const nn::Network<float> network(io::parse_onnx(bytes, fuzz::folder().path("a.onnx")));
}

const fuzz::Registered network({"onnx_network", make_network,
                                [] { return std::vector{test::onnx::model(test::onnx::model_of_many())}; }});
}  // namespace
