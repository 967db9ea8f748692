#include <tapestry/implementation.hpp>
