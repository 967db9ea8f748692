#pragma once
#include <tapestry/raster/raster_kernel_definitions.hpp>

/// \file
/// The rasteriser's kernels, compiled. A program of several files that render defines TAPESTRY_EXTERN_KERNELS
/// for all of them, so that they compile faster, and includes this header in one; without that macro nothing
/// is needed.
