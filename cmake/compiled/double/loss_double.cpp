#include <tapestry/loss/implementation_double.hpp>
