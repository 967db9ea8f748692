#include <tapestry/raster/implementation_double.hpp>
