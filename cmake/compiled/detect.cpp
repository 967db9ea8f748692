#include <tapestry/detect/implementation.hpp>
