#pragma once
#include <tapestry/nn/vector_kernel_definitions.hpp>

/// \file
/// The convolution kernels, compiled. They take most of the time that a source file with a network needs to
/// compile. A program of several such files defines TAPESTRY_EXTERN_KERNELS for all of them and includes this
/// header in one; without that macro nothing is needed.

namespace tapestry::nn {

template Kernels<float> kernels_of<float>(InstructionSet);
template Kernels<double> kernels_of<double>(InstructionSet);

}  // namespace tapestry::nn
