// The compiled parts of the readers alone: instrumented for a fuzzer, kernels would take a compiler minutes.
#undef TAPESTRY_EXTERN_KERNELS
#include <tapestry/implementation.hpp>
