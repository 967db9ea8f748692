#include <tapestry/raster/implementation.hpp>
