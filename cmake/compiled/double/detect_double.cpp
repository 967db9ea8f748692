#include <tapestry/detect/implementation_double.hpp>
