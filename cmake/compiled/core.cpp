#include <tapestry/core/implementation.hpp>
