#include <tapestry/io/implementation.hpp>
