// The operators of networks, instrumented, for they are what the bytes of a file reach.
#include <tapestry/nn/network/operator_definitions.hpp>

namespace tapestry::nn {
template const OperatorTable<float>& operators<float>();
template const OperatorTable<double>& operators<double>();
}  // namespace tapestry::nn
