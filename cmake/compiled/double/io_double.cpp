#include <tapestry/io/implementation_double.hpp>
