// The compiled parts of the readers alone: instrumented for a fuzzer, kernels would take a compiler minutes.
#include <tapestry/io/implementation.hpp>

#include <tapestry/detect/implementation.hpp>
