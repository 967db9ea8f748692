// The operators of networks, instrumented, for they are what the bytes of a file reach. The vector kernels
// are not: that would take a compiler minutes, and only folded constants reach them.
#include <tapestry/nn/implementation/network/operators.hpp>
