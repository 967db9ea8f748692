#pragma once
#include <bit>
#include <tapestry/core/instruction_set.hpp>
#include <tapestry/raster/detail/mip_levels.hpp>
#include <tapestry/raster/detail/view_clip.hpp>

namespace tapestry::raster {
/// A triangle ready for rasterising.
///
/// Depth has the same bits wherever and with whatever instructions it is computed, fused or not. At sample
/// (row, column) with column = 16·g + lane
///   1/z = clamp(float((c₀ + c₁·16·g) + c₂·row) + lane·step),
/// where c₁ and c₂ have 37 significant bits and step, which is c₁ again, has 20: all products are exact.
struct ScreenTriangle {
  std::array<std::int32_t, 3> x;  ///< 1/256 of a sample's width; corners run clockwise on the screen
  std::array<std::int32_t, 3> y;  ///< 1/256 of a sample's height
  std::int32_t face;
  float inverse_depth_min;  ///< 1/z is clamped to that of the face's own points: an edge-on plane is steep
  float inverse_depth_max;
  float step;
  std::array<double, 3> inverse_depth;  ///< c₀, c₁, c₂

  bool operator==(const ScreenTriangle&) const = default;
};

inline constexpr std::int32_t depth_group = 16;  ///< samples side by side that share c₀ + c₁·16·g

/// Samples of a tile along each axis; a tile's faces and depths fill 16 KiB.
inline constexpr std::size_t tile_width = 64;
inline constexpr std::size_t tile_height = 32;  ///< see tile_width

/// Tiles that a triangle's box touches, ends included.
struct TileRange {
  std::uint16_t first_column, first_row, last_column, last_row;

  bool operator==(const TileRange&) const = default;
};

/// The part of a picture that is drawn at once.
struct Tile {
  std::int32_t row;      ///< of its first sample in the picture
  std::int32_t column;   ///< likewise; a multiple of tile_width
  std::int32_t rows;     ///< samples, at most tile_height
  std::int32_t columns;  ///< samples, at most tile_width; what lies beyond, up to a multiple of 16, is
                         ///< overwritten, too
  std::int32_t* faces;   ///< [rows, columns]
  std::size_t stride;    ///< step between rows of `faces`
  float* depth;          ///< [rows, tile_width], 1/z, 0 for none
};

/// 1.5 · 2⁵²: the low bits of a sum with it are the nearest integer of the other summand.
inline constexpr double rounding_magic = 6755399441055744.0;

/// Options that decide which triangles are made, and their tiles.
struct SetupOptions {
  std::int32_t columns;  ///< samples of the picture
  std::int32_t rows;
  bool culls_back;
};

/// The samples of a pixel row: their faces, −1 for none.
struct SampleRows {
  const std::int32_t* faces;
  std::size_t stride;  ///< step between rows of samples
  std::size_t axis;    ///< samples along an axis of a pixel: 2, 4 or 8
};

/// Fragments to be written.
struct FragmentColumns {
  std::uint32_t* column;
  std::int32_t* face;
  float* coverage;
  double* sample_column;  ///< mean place of the fragment's samples
  double* sample_row;     ///< likewise
};

/// Points of faces, whose moments are wanted.
struct MomentBatch {
  static constexpr std::size_t most = 64;
  std::size_t size = 0;
  std::array<std::uint32_t, most> slot;                 ///< of the face's sums
  std::array<std::array<double, 4>, most> value;        ///< three weights, and the coverage
  std::array<std::array<double, 2>, most> barycentric;  ///< the third is 1 less these
};

/// A face near a line of a picture.
struct LineFace {
  std::array<std::array<double, 3>, 3> w;  ///< its weights, a·column + b·row + c, see FaceWeights
  std::array<double, 3> change;            ///< change of the weights from the line to the points beside it
  double face;
};

/// Weights of a face, a·column + b·row + c, see FaceWeights, and how far below 0 they may be near it.
struct FaceReach {
  std::array<std::array<double, 3>, 3> w;
  std::array<double, 3> margin;
};

/// Points of a line, and the faces that rays there and just beside it meet.
struct LinePoints {
  static constexpr std::size_t most = 64;
  using Values = std::array<double, most>;
  std::size_t size = 0;
  Values column{};
  Values row{};
  Values hidden_from{};                   ///< 1/z of faces that hide the point
  Values hider{};                         ///< a face that hides the point, or −1
  std::array<Values, 2> inverse_depth{};  ///< 1/z of the nearest face on each side, 0 for none
  std::array<Values, 2> face{};           ///< that face, of equals the lowest; −1 if no nearer one is found
};

/// The kernels of one instruction set; see raster_kernels.inl for what each computes.
struct RasterKernels {
  void (*project)(const Projection&, const std::array<double, 3>* world, std::size_t count,
                  std::array<double, 3>* view, ScreenVertex* screen) = nullptr;
  std::uint32_t (*highest_index)(const std::int32_t* indices, std::size_t count) = nullptr;
  std::size_t (*list_faces)(const std::array<std::int32_t, 3>* faces, std::int32_t first, std::int32_t count,
                            const ScreenVertex* vertices, std::int32_t columns, std::int32_t rows,
                            std::int32_t* list) = nullptr;
  std::size_t (*set_up)(const RayGrid& rays, const std::array<std::int32_t, 3>* faces,
                        const std::int32_t* list, std::size_t count, const ScreenVertex* vertices,
                        const std::array<double, 3>* view, const SetupOptions& options,
                        ScreenTriangle* triangles, TileRange* tiles) = nullptr;
  void (*draw_triangles)(const ScreenTriangle* const* triangles, std::size_t count,
                         const Tile& tile) = nullptr;
  std::size_t (*scan_pixels)(const SampleRows& samples, std::size_t row, std::size_t begin, std::size_t end,
                             const FragmentColumns& out) = nullptr;
  void (*barycentrics)(const RayGrid& rays, const std::array<std::int32_t, 3>* faces,
                       const std::array<double, 3>* view, std::size_t count, const std::int32_t* face,
                       const double* column, const double* row, double* const* result) = nullptr;
  void (*add_moments)(const MomentBatch& batch, std::array<std::array<double, 8>, 4>* sums) = nullptr;
  std::size_t (*near_segments)(const FaceReach& face, const std::array<const double*, 4>& ends,
                               std::uint32_t begin, std::uint32_t end, std::uint32_t* found) = nullptr;
  void (*look_along)(const LineFace* faces, std::size_t count, const std::array<double, 2>& limits,
                     LinePoints& points) = nullptr;
  void (*choose_lookups)(const LookupRule& rule, LookupBatch& batch, std::size_t count) = nullptr;
  void (*look_up)(const PyramidTexels& pyramid, const LookupBatch& batch, std::size_t count,
                  float* sums) = nullptr;
};

#if !defined(__clang__)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

/// {x, y} of ScreenVertex for a point of view space, with the bits of the kernels.
[[nodiscard]] [[gnu::noinline]] inline std::array<std::int32_t, 2> snapped(
    const Projection& p, const std::array<double, 3>& view) {
  std::array<std::int32_t, 2> place{};
  const double inverse = 1 / view[2];
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double slope = view[axis] * inverse;
    const double offset = slope * p.samples[axis];
    const double coordinate = offset + p.centre[axis];
    const double rounded = coordinate * subpixel_steps + rounding_magic;
    place[axis] = static_cast<std::int32_t>(std::bit_cast<std::int64_t>(rounded));
  }
  return place;
}

#if !defined(__clang__)
#pragma GCC pop_options
#endif

/// The kernels of one instruction set, which the processor must have. All give the same bits.
[[nodiscard]] RasterKernels raster_kernels_of(InstructionSet set);

/// The kernels in use, chosen once.
[[nodiscard]] inline const RasterKernels& raster_kernels() {
  static const RasterKernels chosen = raster_kernels_of(instruction_set());
  return chosen;
}
}  // namespace tapestry::raster
