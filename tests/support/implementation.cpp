#include <tapestry/io/implementation.hpp>
#include <tapestry/nn/implementation.hpp>
#include <tapestry/raster/implementation.hpp>
