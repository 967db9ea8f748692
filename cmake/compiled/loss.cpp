#include <tapestry/loss/implementation.hpp>
