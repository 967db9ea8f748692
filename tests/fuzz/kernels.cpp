// The vector kernels, not instrumented: that would take a compiler minutes. Only folded constants reach them.
#include <tapestry/nn/vector_kernel_definitions.hpp>

namespace tapestry::nn {
template Kernels<float> kernels_of<float>(InstructionSet);
template Kernels<double> kernels_of<double>(InstructionSet);
}  // namespace tapestry::nn
