#include <tapestry/image/implementation_double.hpp>
