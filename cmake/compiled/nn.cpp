#include <tapestry/nn/implementation.hpp>
