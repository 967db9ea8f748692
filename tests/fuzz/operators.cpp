// The operators of networks, instrumented, since the bytes of a file reach them. The vector kernels are not:
// that would take a compiler minutes, and only folded constants reach them.
#include <tapestry/nn/implementation/network/operators.hpp>
