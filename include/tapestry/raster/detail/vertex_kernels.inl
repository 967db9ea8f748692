// Vertices and faces, up to triangles in samples, for one instruction set.
#include <tapestry/core/vector_memory.inl>
#include <tapestry/raster/detail/raster_kernels.hpp>
using namespace tapestry::raster;  // where an editor reads this file alone

constexpr std::size_t lanes = TAPESTRY_VECTOR_BYTES / 4;
using Ints = Register<std::int32_t>;
using Floats = Register<float>;
using Doubles = Register<double>;
using Longs = Register<std::int64_t>;
typedef std::int32_t FourInts __attribute__((vector_size(16)));
typedef FourInts FourIntsInMemory __attribute__((may_alias));

inline std::int32_t least(std::int32_t a, std::int32_t b) { return a < b ? a : b; }
inline std::int32_t greatest(std::int32_t a, std::int32_t b) { return a > b ? a : b; }
inline std::int64_t least(std::int64_t a, std::int64_t b) { return a < b ? a : b; }
inline std::int64_t greatest(std::int64_t a, std::int64_t b) { return a > b ? a : b; }

/// A block of vertices in separate arrays, for each coordinate.
struct VertexBlock {
  static constexpr std::size_t size = 32;
  static constexpr std::size_t wide = TAPESTRY_VECTOR_BYTES / 8;
  alignas(64) double world[3][size];
  alignas(64) double view[3][size];
  alignas(64) std::int64_t screen[2][size];
  alignas(64) std::int64_t outside[size];
  alignas(64) double inverse_depth[size];
};

/// Bits of the planes that points lie outside of, in the order of ViewClip::outside().
inline Longs planes_outside(const Projection& p, const Doubles* view) {
  Longs bits = (view[2] < p.near) & 1;
  bits |= (view[2] > p.far) & 2;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const std::int64_t unit = std::int64_t{1} << (2 * axis);
    const Doubles edge = p.picture[axis] * view[2];
    const Doubles guard = p.guard[axis] * view[2];
    bits |= (view[axis] < -edge) & (4 * unit);
    bits |= (view[axis] > edge) & (8 * unit);
    bits |= (view[axis] < -guard) & (0x100 * unit);
    bits |= (view[axis] > guard) & (0x200 * unit);
  }
  Longs is_usable = ~Longs{};
  for (std::size_t axis = 0; axis < 3; ++axis) is_usable &= (view[axis] <= 1e100) & (view[axis] >= -1e100);
  return (bits & is_usable) | (~is_usable & static_cast<std::int64_t>(unusable));
}

inline void project_block(const Projection& p, VertexBlock& block) {
  for (std::size_t i = 0; i < VertexBlock::size; i += VertexBlock::wide) {
    Doubles view[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Doubles x = load(block.world[0] + i) * p.rotation[axis][0];
      const Doubles y = load(block.world[1] + i) * p.rotation[axis][1];
      const Doubles z = load(block.world[2] + i) * p.rotation[axis][2];
      const Doubles xy = x + y;
      const Doubles xyz = xy + z;
      view[axis] = xyz + p.translation[axis];
      store(block.view[axis] + i, view[axis]);
    }
    store(block.outside + i, planes_outside(p, view));
    const Doubles inverse = 1.0 / view[2];
    store(block.inverse_depth + i, inverse);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const Doubles slope = view[axis] * inverse;
      const Doubles offset = slope * p.samples[axis];
      const Doubles coordinate = offset + p.centre[axis];
      const Doubles steps = coordinate * subpixel_steps;
      const Doubles rounded = steps + rounding_magic;
      store(block.screen[axis] + i, reinterpret_cast<Longs>(rounded));
    }
  }
}

/// Takes positions of the world to view space and to the grid of samples.
inline void project(const Projection& p, const std::array<double, 3>* world, std::size_t count,
                    std::array<double, 3>* view, ScreenVertex* screen) {
  VertexBlock block = {};
  for (std::size_t begin = 0; begin < count; begin += VertexBlock::size) {
    const std::size_t size = count - begin < VertexBlock::size ? count - begin : VertexBlock::size;
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) block.world[axis][i] = world[begin + i][axis];
    project_block(p, block);
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) view[begin + i][axis] = block.view[axis][i];
      screen[begin + i] = {
          static_cast<std::int32_t>(block.screen[0][i]), static_cast<std::int32_t>(block.screen[1][i]),
          static_cast<std::uint32_t>(block.outside[i]), static_cast<float>(block.inverse_depth[i])};
    }
  }
}

/// The highest of some indices; negative ones count as higher than all others.
inline std::uint32_t highest_index(const std::int32_t* indices, std::size_t count) {
  using Unsigned = Register<std::uint32_t>;
  Unsigned most = {};
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto index = reinterpret_cast<Unsigned>(load(indices + i));
    most = index > most ? index : most;
  }
  std::uint32_t highest = 0;
  for (std::size_t lane = 0; lane < lanes; ++lane) highest = most[lane] > highest ? most[lane] : highest;
  for (; i < count; ++i) {
    const auto index = static_cast<std::uint32_t>(indices[i]);
    highest = index > highest ? index : highest;
  }
  return highest;
}

/// Lists the faces that may own a sample: not all corners outside one plane, and a sample in the face's box.
/// For faces to be cut, or with an unusable corner, ~face is listed instead. Returns their number.
/// \param faces  of a mesh; first … first + count − 1 are looked at, and their corners must exist
inline std::size_t list_faces(const std::array<std::int32_t, 3>* faces, std::int32_t first,
                              std::int32_t count, const ScreenVertex* vertices, std::int32_t columns,
                              std::int32_t rows, std::int32_t* list) {
  constexpr std::int32_t half = subpixel_steps / 2;
  constexpr std::int32_t exempt = ViewClip::needs_cut | unusable;
  const FourInts last = {columns - 1, rows - 1, 0, 0};
  const FourInts zero = {};
  std::size_t size = 0;
  for (std::int32_t face = first; face < first + count; ++face) {
    const FourInts a = *reinterpret_cast<const FourIntsInMemory*>(vertices + faces[face][0]);
    const FourInts b = *reinterpret_cast<const FourIntsInMemory*>(vertices + faces[face][1]);
    const FourInts c = *reinterpret_cast<const FourIntsInMemory*>(vertices + faces[face][2]);
    const FourInts low_ab = a < b ? a : b;
    const FourInts high_ab = a > b ? a : b;
    const FourInts low = low_ab < c ? low_ab : c;
    const FourInts high = high_ab > c ? high_ab : c;
    const FourInts from = (low + (subpixel_steps - 1 - half)) >> subpixel_bits;
    const FourInts to = (high - half) >> subpixel_bits;
    const FourInts begin = from > zero ? from : zero;
    const FourInts end = to < last ? to : last;
    const FourInts is_empty = begin > end;
    const std::int32_t outside_all = (a & b & c)[2] & static_cast<std::int32_t>(ViewClip::invisible);
    const std::int32_t outside_any = (a | b | c)[2] & exempt;
    list[size] = outside_any == 0 ? face : ~face;
    const bool has_samples = (is_empty[0] | is_empty[1]) == 0;
    size += static_cast<std::size_t>((outside_all == 0) & ((outside_any != 0) | has_samples));
  }
  return size;
}

/// Corners of faces in separate arrays: first, second and third by their place on the screen.
struct FaceBlock {
  static constexpr std::size_t size = 16;
  alignas(64) double corner[3][3][size];
};

/// Which corner comes first, second and third by x, then y, in bits 0-1, 2-3 and 4-5.
inline std::uint32_t screen_order(const ScreenVertex* const* v) {
  const std::int64_t a = (std::int64_t{v[0]->x} << 34) + std::int64_t{v[0]->y} * 4;
  const std::int64_t b = (std::int64_t{v[1]->x} << 34) + std::int64_t{v[1]->y} * 4 + 1;
  const std::int64_t c = (std::int64_t{v[2]->x} << 34) + std::int64_t{v[2]->y} * 4 + 2;
  const std::int64_t low = least(a, b), high = greatest(a, b);
  const std::int64_t first = least(low, c), other = greatest(low, c);
  return static_cast<std::uint32_t>((first & 3) | (least(high, other) & 3) << 2 |
                                    (greatest(high, other) & 3) << 4);
}

/// Tiles of a triangle's box, which must have samples.
inline TileRange tiles_of(const ScreenVertex* const* v, const FourInts& last_sample) {
  constexpr std::int32_t half = subpixel_steps / 2;
  const FourInts a = *reinterpret_cast<const FourIntsInMemory*>(v[0]);
  const FourInts b = *reinterpret_cast<const FourIntsInMemory*>(v[1]);
  const FourInts c = *reinterpret_cast<const FourIntsInMemory*>(v[2]);
  const FourInts low_ab = a < b ? a : b;
  const FourInts high_ab = a > b ? a : b;
  const FourInts low = low_ab < c ? low_ab : c;
  const FourInts high = high_ab > c ? high_ab : c;
  const FourInts from = (low + (subpixel_steps - 1 - half)) >> subpixel_bits;
  const FourInts to = (high - half) >> subpixel_bits;
  const FourInts begin = from > 0 ? from : FourInts{};
  const FourInts end = to < last_sample ? to : last_sample;
  constexpr std::int32_t wide = tile_width, high_rows = tile_height;
  return {static_cast<std::uint16_t>(begin[0] / wide), static_cast<std::uint16_t>(begin[1] / high_rows),
          static_cast<std::uint16_t>(end[0] / wide), static_cast<std::uint16_t>(end[1] / high_rows)};
}

/// Sets everything of a triangle but its depth; returns false when it has no area, or is turned away and
/// culled.
inline bool set_screen(const ScreenVertex* const* v, std::int32_t face, bool culls_back, ScreenTriangle& t) {
  const std::int64_t x1 = std::int64_t{v[1]->x} - v[0]->x, y1 = std::int64_t{v[1]->y} - v[0]->y;
  const std::int64_t x2 = std::int64_t{v[2]->x} - v[0]->x, y2 = std::int64_t{v[2]->y} - v[0]->y;
  const std::int64_t doubled_area = x1 * y2 - y1 * x2;
  const ScreenVertex* const second = doubled_area < 0 ? v[2] : v[1];  // rows grow downwards
  const ScreenVertex* const third = doubled_area < 0 ? v[1] : v[2];
  t.x[0] = v[0]->x, t.x[1] = second->x, t.x[2] = third->x;
  t.y[0] = v[0]->y, t.y[1] = second->y, t.y[2] = third->y;
  t.face = face;
  const float a = v[0]->inverse_depth, b = v[1]->inverse_depth, c = v[2]->inverse_depth;
  const float low = a < b ? a : b, high = a < b ? b : a;
  t.inverse_depth_min = low < c ? low : c;
  t.inverse_depth_max = high > c ? high : c;
  return (doubled_area != 0) & !((doubled_area > 0) & culls_back);
}

/// Keeps 53 − Bits significant bits.
template <int Bits>
inline Doubles cut_short(const Doubles& value) {
  return reinterpret_cast<Doubles>(reinterpret_cast<Longs>(value) & (~std::int64_t{0} << Bits));
}

inline Doubles within(const Doubles& value) {
  return reinterpret_cast<Doubles>((value <= 1e37) & (value >= -1e37));
}

/// The plane n·q = n·a through corners a, b, c meets the ray z·(rx, ry, 1) at 1/z = n·(rx, ry, 1) / n·a.
/// Corners come in an order that depends on their places only, so that faces with the same corners get the
/// same bits and tie, whatever their winding.
inline void set_depths(const RayGrid& rays, const FaceBlock& block, std::size_t count,
                       ScreenTriangle* triangles) {
  for (std::size_t i = 0; i < count; i += VertexBlock::wide) {
    Doubles a[3], u[3], w[3], normal[3];
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = load(block.corner[0][k] + i);
      u[k] = load(block.corner[1][k] + i) - a[k];
      w[k] = load(block.corner[2][k] + i) - a[k];
    }
    Doubles volume = {};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
      const Doubles minuend = u[next] * w[last];
      const Doubles subtrahend = u[last] * w[next];
      normal[k] = minuend - subtrahend;
      const Doubles part = normal[k] * a[k];
      volume += part;
    }
    const Doubles inverse = 1.0 / volume;
    const Doubles per_x = normal[0] * inverse, per_y = normal[1] * inverse;
    const Doubles first_x = per_x * rays.first[0], first_y = per_y * rays.first[1];
    const Doubles per_z = normal[2] * inverse;
    const Doubles first_xz = per_z + first_x;
    const Doubles first = first_xz + first_y;
    const Doubles per_column = cut_short<16>(per_x * rays.step[0]),
                  per_row = cut_short<16>(per_y * rays.step[1]);
    const Doubles step = cut_short<33>(per_column);
    const Longs is_sound = reinterpret_cast<Longs>(within(first)) &
                           reinterpret_cast<Longs>(within(per_column)) &
                           reinterpret_cast<Longs>(within(per_row));
    for (std::size_t lane = 0; lane < VertexBlock::wide && i + lane < count; ++lane) {
      ScreenTriangle& t = triangles[i + lane];
      const bool is_steep = is_sound[lane] == 0;
      t.inverse_depth[0] = is_steep ? static_cast<double>(t.inverse_depth_max) : first[lane];
      t.inverse_depth[1] = is_steep ? 0 : per_column[lane];
      t.inverse_depth[2] = is_steep ? 0 : per_row[lane];
      t.step = is_steep ? 0 : static_cast<float>(step[lane]);
    }
  }
}

/// Sets up faces that need no cutting. Returns the number of triangles, at most `count`.
/// \param list  faces of the mesh
inline std::size_t set_up(const RayGrid& rays, const std::array<std::int32_t, 3>* faces,
                          const std::int32_t* list, std::size_t count, const ScreenVertex* vertices,
                          const std::array<double, 3>* view, const SetupOptions& options,
                          ScreenTriangle* triangles, TileRange* tiles) {
  FaceBlock block = {};
  const FourInts last_sample = {options.columns - 1, options.rows - 1, 0, 0};
  std::size_t total = 0, waiting = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<std::int32_t, 3>& corners = faces[list[i]];
    const ScreenVertex* const v[3] = {vertices + corners[0], vertices + corners[1], vertices + corners[2]};
    const std::uint32_t order = screen_order(v);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::array<double, 3>& position = view[corners[order >> (2 * k) & 3]];
      for (std::size_t axis = 0; axis < 3; ++axis) block.corner[k][axis][waiting] = position[axis];
    }
    tiles[total + waiting] = tiles_of(v, last_sample);
    waiting += set_screen(v, list[i], options.culls_back, triangles[total + waiting]) ? 1 : 0;
    if (waiting < FaceBlock::size && i + 1 < count) continue;
    set_depths(rays, block, waiting, triangles + total);
    total += waiting;
    waiting = 0;
  }
  return total;
}
