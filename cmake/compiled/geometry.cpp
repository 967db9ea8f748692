#include <tapestry/geometry/implementation.hpp>
