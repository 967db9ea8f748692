// Kernels of the rasteriser for one instruction set; raster_kernels.hpp includes this file once for each of
// them, inside a namespace of its own and with TAPESTRY_VECTOR_BYTES set. Generic vectors must be parsed
// under the target they are meant for, so nothing here may be a lambda or come from outside. All sets give
// the same bits: numbers that are not integers are computed without fused products, one operation a
// statement. The parts are a chain of files: each includes the one before it.
#include <tapestry/raster/detail/line_kernel.inl>

inline RasterKernels make_kernels() {
  return {project,      highest_index, list_faces,    set_up,     draw_triangles, scan_pixels,
          barycentrics, add_moments,   near_segments, look_along, choose_lookups, look_up};
}
