#include <tapestry/segment/implementation.hpp>
