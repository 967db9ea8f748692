// Barycentric coordinates of points, and triangles into tiles, for one instruction set.
#include <tapestry/raster/detail/vertex_kernels.inl>

/// Terms of the barycentric weights for one point each lane: three planes through the eye and two corners,
/// b_k ∝ x·plane[k][0] + y·plane[k][1] + plane[k][2].
struct Planes {
  Doubles plane[3][3];
};

inline void weigh(const RayGrid& rays, const Planes& p, const double* column, const double* row,
                  double* const* result, std::size_t offset) {
  const Doubles x_steps = load(column + offset) * rays.step[0];
  const Doubles y_steps = load(row + offset) * rays.step[1];
  const Doubles x = x_steps + rays.first[0], y = y_steps + rays.first[1];
  Doubles weight[3], sum = {}, total = {};
  for (std::size_t k = 0; k < 3; ++k) {
    const Doubles part_x = x * p.plane[k][0], part_y = y * p.plane[k][1];
    const Doubles part = part_x + part_y;
    weight[k] = part + p.plane[k][2];
    sum += weight[k];
  }
  const Doubles zero = {};
  for (std::size_t k = 0; k < 3; ++k) {
    weight[k] = sum < 0 ? -weight[k] : weight[k];
    weight[k] = weight[k] > 0 ? weight[k] : zero;
    total += weight[k];
  }
  const Doubles largest = (sum < 0 ? -sum : sum) * 1e6;
  const Longs is_sound = (total <= largest) & (total > 0);
  const Doubles inverse = 1.0 / total;
  for (std::size_t k = 0; k < 3; ++k) {
    const Doubles value = weight[k] * inverse;
    store(result[k] + offset, is_sound ? value : 1.0 / 3 - zero);
  }
}

/// A run of points of one face.
inline void weigh_run(const RayGrid& rays, const std::array<std::int32_t, 3>& corners,
                      const std::array<double, 3>* view, std::size_t begin, std::size_t end,
                      const double* column, const double* row, double* const* result) {
  Planes p;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::array<double, 3>& q = view[corners[(k + 1) % 3]];
    const std::array<double, 3>& r = view[corners[(k + 2) % 3]];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double minuend = q[(axis + 1) % 3] * r[(axis + 2) % 3];
      const double subtrahend = q[(axis + 2) % 3] * r[(axis + 1) % 3];
      p.plane[k][axis] = (minuend - subtrahend) - Doubles{};
    }
  }
  for (std::size_t i = begin; i < end; i += VertexBlock::wide) weigh(rays, p, column, row, result, i);
}

/// Points of as many faces as there are lanes.
inline void weigh_mixed(const RayGrid& rays, const std::array<std::int32_t, 3>* faces,
                        const std::array<double, 3>* view, std::size_t begin, std::size_t end,
                        const std::int32_t* face, const double* column, const double* row,
                        double* const* result) {
  alignas(64) double corner[3][3][VertexBlock::wide] = {};
  for (std::size_t i = 0; i < VertexBlock::wide && begin + i < end; ++i) {
    const std::array<std::int32_t, 3>& corners = faces[face[begin + i]];
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis) corner[k][axis][i] = view[corners[k]][axis];
  }
  Planes p;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t next = (axis + 1) % 3, last = (axis + 2) % 3;
      const Doubles minuend = load(corner[(k + 1) % 3][next]) * load(corner[(k + 2) % 3][last]);
      const Doubles subtrahend = load(corner[(k + 1) % 3][last]) * load(corner[(k + 2) % 3][next]);
      p.plane[k][axis] = minuend - subtrahend;
    }
  }
  weigh(rays, p, column, row, result, begin);
}

/// Perspective-correct barycentric coordinates of points given in samples; see face_weights.hpp. All arrays
/// of numbers are readable and writable to 8 beyond `count`.
inline void barycentrics(const RayGrid& rays, const std::array<std::int32_t, 3>* faces,
                         const std::array<double, 3>* view, std::size_t count, const std::int32_t* face,
                         const double* column, const double* row, double* const* result) {
  for (std::size_t i = 0; i < count;) {
    std::size_t run = i + 1;
    while (run < count && face[run] == face[i]) ++run;
    if (run - i >= 3) {
      weigh_run(rays, faces[face[i]], view, i, run, column, row, result);
      i = run;
    } else {
      weigh_mixed(rays, faces, view, i, count, face, column, row, result);
      i += VertexBlock::wide;
    }
  }
}

/// Edge function of one side in whole samples, and its steps. A sample is inside where all three are ≥ 0.
/// Doubled-area units are divided by 256, rounded down; since steps are whole multiples of 256 this keeps
/// every sign.
struct Edge {
  std::int64_t value;  // at the first sample
  std::int64_t per_column;
  std::int64_t per_row;
};

inline Edge edge_of(const ScreenTriangle& t, std::size_t side, std::int32_t column, std::int32_t row) {
  const std::size_t next = side == 2 ? 0 : side + 1;
  Edge edge;
  edge.per_column = std::int64_t{t.y[side]} - t.y[next];
  edge.per_row = std::int64_t{t.x[next]} - t.x[side];
  const std::int64_t x = std::int64_t{column} * subpixel_steps + subpixel_steps / 2 - t.x[side];
  const std::int64_t y = std::int64_t{row} * subpixel_steps + subpixel_steps / 2 - t.y[side];
  // Rows grow downwards and corners run clockwise: left sides go up, top sides go right.
  const bool is_top_left = (edge.per_column > 0) | ((edge.per_column == 0) & (edge.per_row > 0));
  edge.value = (edge.per_row * y + edge.per_column * x - (is_top_left ? 0 : 1)) >> subpixel_bits;
  return edge;
}

/// Rows and columns of a tile, ends included.
struct PixelBox {
  std::int32_t first_row, last_row, first_column, last_column;
};

/// Intersection of a triangle's box with a tile; columns are widened to whole groups of 16.
inline PixelBox shared_box(const ScreenTriangle& t, const Tile& tile) {
  constexpr std::int32_t half = subpixel_steps / 2;
  const std::int32_t left = least(least(t.x[0], t.x[1]), t.x[2]), top = least(least(t.y[0], t.y[1]), t.y[2]);
  const std::int32_t right = greatest(greatest(t.x[0], t.x[1]), t.x[2]);
  const std::int32_t bottom = greatest(greatest(t.y[0], t.y[1]), t.y[2]);
  PixelBox box;
  box.first_column = greatest(((left + subpixel_steps - 1 - half) >> subpixel_bits) - tile.column, 0);
  box.last_column = least(((right - half) >> subpixel_bits) - tile.column, tile.columns - 1);
  box.first_row = greatest(((top + subpixel_steps - 1 - half) >> subpixel_bits) - tile.row, 0);
  box.last_row = least(((bottom - half) >> subpixel_bits) - tile.row, tile.rows - 1);
  if (box.first_column > box.last_column) box.last_row = box.first_row - 1;
  box.first_column &= -depth_group;
  box.last_column |= depth_group - 1;
  return box;
}

/// Fits the edges of a large triangle to 32 bits within a box: sides that do not cross the box become 0.
/// Returns false when the whole box is outside, or when an edge does not fit; then `fits` is false.
inline bool fit_edges(const PixelBox& box, Edge* edges, bool& fits) {
  const std::int64_t width = box.last_column - box.first_column, height = box.last_row - box.first_row;
  for (std::size_t side = 0; side < 3; ++side) {
    Edge& edge = edges[side];
    const std::int64_t along = edge.per_column * width, down = edge.per_row * height;
    const std::int64_t low = edge.value + (along < 0 ? along : 0) + (down < 0 ? down : 0);
    const std::int64_t high = edge.value + (along > 0 ? along : 0) + (down > 0 ? down : 0);
    if (high < 0) return false;
    if (low >= 0) {
      edge = {0, 0, 0};
    } else if (high - low > 0x7FFFFFFF || edge.per_column * 16 > 0x7FFFFFFF ||
               edge.per_column * -16 > 0x7FFFFFFF) {
      fits = false;
    }
  }
  return fits;
}

/// One sample after the other, with 64 bits, for sides longer than about 100,000 samples.
inline void draw_by_samples(const ScreenTriangle& t, const Tile& tile, const PixelBox& box,
                            const Edge* edges) {
  for (std::int32_t row = box.first_row; row <= box.last_row; ++row) {
    for (std::int32_t column = box.first_column; column <= least(box.last_column, tile.columns - 1);
         ++column) {
      std::int64_t outside = 0;
      for (std::size_t side = 0; side < 3; ++side)
        outside |= edges[side].value + edges[side].per_column * (column - box.first_column) +
                   edges[side].per_row * (row - box.first_row);
      if (outside < 0) continue;
      const std::int32_t lane = column % depth_group;
      const double at_group = t.inverse_depth[0] + t.inverse_depth[1] * (tile.column + column - lane);
      const auto base = static_cast<float>(at_group + t.inverse_depth[2] * (tile.row + row));
      float value = base + static_cast<float>(lane) * t.step;
      value = value < t.inverse_depth_min ? t.inverse_depth_min : value;
      value = value > t.inverse_depth_max ? t.inverse_depth_max : value;
      float& depth =
          tile.depth[static_cast<std::size_t>(row) * tile_width + static_cast<std::size_t>(column)];
      if (!(value > depth)) continue;
      depth = value;
      tile.faces[static_cast<std::size_t>(row) * tile.stride + static_cast<std::size_t>(column)] = t.face;
    }
  }
}

/// Constants for drawing a triangle's rows.
struct RowSetup {
  static constexpr std::size_t parts = 16 / lanes;  // vectors of a group
  Ints start[3];                                    // edges at the first row's first vector
  Ints per_vector[3];                               // change of an edge from a vector to the next
  Ints per_row[3];                                  // step from a row to the next
  Floats offset[parts];                             // lane · step of each vector of a group
  Floats low, high;                                 // bounds of 1/z
  Ints face;
};

inline Ints all(std::int32_t value) { return Ints{} + value; }

inline Floats all(float value) { return value - Floats{}; }  // less 0 nothing changes, not even a sign

inline RowSetup row_setup(const ScreenTriangle& t, const Edge* edges) {
  RowSetup setup;
  Ints lane;
  for (std::size_t i = 0; i < lanes; ++i) lane[i] = static_cast<std::int32_t>(i);
  for (std::size_t side = 0; side < 3; ++side) {
    const auto step = static_cast<std::int32_t>(edges[side].per_column);
    setup.start[side] = lane * step + static_cast<std::int32_t>(edges[side].value);
    setup.per_vector[side] = all(step * static_cast<std::int32_t>(lanes));
    setup.per_row[side] = all(static_cast<std::int32_t>(edges[side].per_row));
  }
  for (std::size_t part = 0; part < RowSetup::parts; ++part)
    setup.offset[part] =
        __builtin_convertvector(lane + static_cast<std::int32_t>(part * lanes), Floats) * t.step;
  setup.low = all(t.inverse_depth_min);
  setup.high = all(t.inverse_depth_max);
  setup.face = all(t.face);
  return setup;
}

/// Depth test of `lanes` samples. The nearer face wins; on a tie the one drawn first.
inline void draw_vector(const RowSetup& setup, const Ints& outside, const Floats& base, const Floats& offset,
                        float* depths, std::int32_t* faces) {
  const Floats depth = load(depths);
  Floats value = base + offset;
  value = value < setup.low ? setup.low : value;
  value = value > setup.high ? setup.high : value;
  value = outside < 0 ? Floats{} : value;
  const Ints is_nearer = value > depth;
  store(depths, is_nearer ? value : depth);
  store(faces, is_nearer ? setup.face : load(faces));
}

/// Draws the rows of a box. Values that are read repeatedly are copied first, since the compiler must assume
/// that pixels alias them.
inline void draw_rows(const ScreenTriangle& t, const Tile& tile, const PixelBox& box, const Edge* edges) {
  const RowSetup setup = row_setup(t, edges);
  const std::int32_t groups = (box.last_column - box.first_column + 1) / depth_group;
  const double per_row = t.inverse_depth[2];
  const std::int32_t first_row = tile.row;
  const std::size_t stride = tile.stride;
  double at_group[tile_width / 16];
  for (std::int32_t g = 0; g < groups; ++g)
    at_group[g] = t.inverse_depth[0] + t.inverse_depth[1] * (tile.column + box.first_column + 16 * g);
  Ints row_start[3] = {setup.start[0], setup.start[1], setup.start[2]};
  const auto first = static_cast<std::size_t>(box.first_column);
  float* depth_row = tile.depth + static_cast<std::size_t>(box.first_row) * tile_width + first;
  std::int32_t* face_row = tile.faces + static_cast<std::size_t>(box.first_row) * stride + first;
  for (std::int32_t row = box.first_row; row <= box.last_row; ++row) {
    const double down = per_row * (first_row + row);
    float* depths = depth_row;
    std::int32_t* faces = face_row;
    Ints edge[3] = {row_start[0], row_start[1], row_start[2]};
    for (std::int32_t g = 0; g < groups; ++g) {
      const Floats base = all(static_cast<float>(at_group[g] + down));
      for (std::size_t part = 0; part < RowSetup::parts; ++part) {
        draw_vector(setup, edge[0] | edge[1] | edge[2], base, setup.offset[part], depths, faces);
        depths += lanes;
        faces += lanes;
        for (std::size_t side = 0; side < 3; ++side) edge[side] += setup.per_vector[side];
      }
    }
    for (std::size_t side = 0; side < 3; ++side) row_start[side] += setup.per_row[side];
    depth_row += tile_width;
    face_row += stride;
  }
}

inline void draw_triangle(const ScreenTriangle& t, const Tile& tile) {
  const PixelBox box = shared_box(t, tile);
  if (box.first_row > box.last_row) return;
  Edge edges[3];
  for (std::size_t side = 0; side < 3; ++side)
    edges[side] = edge_of(t, side, tile.column + box.first_column, tile.row + box.first_row);
  std::int64_t reach = 0;
  for (const Edge& edge : edges) {
    reach |= edge.per_column < 0 ? -edge.per_column : edge.per_column;
    reach |= edge.per_row < 0 ? -edge.per_row : edge.per_row;
  }
  bool fits = true;
  if (reach >= (std::int64_t{1} << 14) && !fit_edges(box, edges, fits)) {
    if (!fits) draw_by_samples(t, tile, box, edges);
    return;
  }
  draw_rows(t, tile, box, edges);
}

inline void draw_triangles(const ScreenTriangle* const* triangles, std::size_t count, const Tile& tile) {
  for (std::size_t i = 0; i < count; ++i) draw_triangle(*triangles[i], tile);
}
