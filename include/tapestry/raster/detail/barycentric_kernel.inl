// Barycentric coordinates of points, for one instruction set.
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
