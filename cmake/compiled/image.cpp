#include <tapestry/image/implementation.hpp>
