#include <tapestry/tapestry.hpp>
