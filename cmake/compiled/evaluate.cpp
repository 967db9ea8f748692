#include <tapestry/evaluate/implementation.hpp>
