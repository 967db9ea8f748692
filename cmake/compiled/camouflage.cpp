#include <tapestry/camouflage/implementation.hpp>
