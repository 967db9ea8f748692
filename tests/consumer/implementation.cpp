#include <tapestry/laboratory_implementation.hpp>
