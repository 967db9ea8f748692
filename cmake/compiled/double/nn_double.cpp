#include <tapestry/nn/implementation_double.hpp>
