// Faces near lines of a picture, and sums over the samples of faces, for one instruction set.
#include <tapestry/raster/detail/fragment_kernel.inl>

/// Lists segments, given by the columns and rows of their ends, that lie on the outer side of none of a
/// face's sides. Reads and writes up to 8 elements beyond the last.
inline std::size_t near_segments(const FaceReach& face, const std::array<const double*, 4>& ends,
                                 std::uint32_t begin, std::uint32_t end, std::uint32_t* found) {
  constexpr std::uint32_t wide = Vector<double>::lanes;
  std::size_t count = 0;
  for (std::uint32_t i = begin; i < end; i += wide) {
    const Doubles from_column = load(ends[0] + i), from_row = load(ends[1] + i);
    const Doubles to_column = load(ends[2] + i), to_row = load(ends[3] + i);
    Longs is_near = ~Longs{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::array<double, 3>& w = face.w[k];
      const Doubles from_across = from_column * w[0], from_down = from_row * w[1];
      const Doubles to_across = to_column * w[0], to_down = to_row * w[1];
      const Doubles from = from_across + from_down, to = to_across + to_down;
      const double least = -face.margin[k] - w[2];
      is_near &= (from >= least) | (to >= least);
    }
    for (std::uint32_t lane = 0; lane < wide; ++lane) {
      found[count] = i + lane;
      count += ((is_near[lane] != 0) & (i + lane < end)) ? 1 : 0;
    }
  }
  return count;
}

/// 1/z of a face, from its weights, where it is met between two limits, else 0.
inline Doubles met(const Doubles* weight, const std::array<double, 2>& limits) {
  const Doubles xy = weight[0] + weight[1];
  const Doubles inverse_depth = xy + weight[2];
  const Longs is_met = (weight[0] >= 0) & (weight[1] >= 0) & (weight[2] >= 0) & (inverse_depth >= limits[0]) &
                       (inverse_depth <= limits[1]);
  return is_met ? inverse_depth : Doubles{};
}

/// Finds faces that hide points of a line, and the nearest faces beside it, at point − step and point + step,
/// that are nearer than those known; see LinePoints.
inline void look_along(const LineFace* faces, std::size_t count, const std::array<double, 2>& limits,
                       LinePoints& points) {
  for (std::size_t i = 0; i < points.size; i += Vector<double>::lanes) {
    const Doubles column = load(points.column.data() + i), row = load(points.row.data() + i);
    const Doubles hidden_from = load(points.hidden_from.data() + i), zero = {};
    Doubles hider = zero - 1.0, seen[2] = {hider, hider}, nearest[2];
    for (std::size_t side = 0; side < 2; ++side) nearest[side] = load(points.inverse_depth[side].data() + i);
    for (const LineFace* face = faces; face != faces + count; ++face) {
      const Doubles own = zero + face->face;
      Doubles at[3], beside[2][3];
      for (std::size_t k = 0; k < 3; ++k) {
        const Doubles across = column * face->w[k][0], down = row * face->w[k][1];
        const Doubles both = across + down;
        at[k] = both + face->w[k][2];
        beside[0][k] = at[k] - face->change[k];
        beside[1][k] = at[k] + face->change[k];
      }
      hider = met(at, limits) > hidden_from ? own : hider;
      for (std::size_t side = 0; side < 2; ++side) {
        const Doubles there = met(beside[side], limits);
        const Longs is_nearer =
            (there > nearest[side]) | ((there == nearest[side]) & (there > 0) & (own < seen[side]));
        nearest[side] = is_nearer ? there : nearest[side];
        seen[side] = is_nearer ? own : seen[side];
      }
    }
    store(points.hider.data() + i, hider);
    for (std::size_t side = 0; side < 2; ++side) {
      store(points.inverse_depth[side].data() + i, nearest[side]);
      store(points.face[side].data() + i, seen[side]);
    }
  }
}

typedef double EightDoubles __attribute__((vector_size(64)));
typedef std::int64_t EightLongs __attribute__((vector_size(64)));

/// Adds value_i · {1, b_0, b_1, b_0², b_0·b_1, b_1², 0, 0} to row i of the sums of each point's face.
inline void add_moments(const MomentBatch& batch, std::array<std::array<double, 8>, 4>* sums) {
  constexpr EightLongs first_x = {0, -1, 0, -1, -1}, first_y = {0, 0, -1, 0, 0, -1};
  constexpr EightLongs second_x = {0, 0, 0, -1}, second_y = {0, 0, 0, 0, -1, -1};
  const EightDoubles one = {1}, ones = {1, 1, 1};
  EightDoubles row[4];
  for (std::size_t i = 0; i < batch.size;) {
    const std::uint32_t slot = batch.slot[i];
    double* const own = sums[slot][0].data();
    __builtin_memcpy(row, own, sizeof row);
    for (; i < batch.size && batch.slot[i] == slot; ++i) {
      const EightDoubles x = batch.barycentric[i][0] - EightDoubles{};
      const EightDoubles y = batch.barycentric[i][1] - EightDoubles{};
      const EightDoubles powers = (first_x ? x : first_y ? y : one) * (second_x ? x : second_y ? y : ones);
      row[0] += powers * batch.value[i][0];
      row[1] += powers * batch.value[i][1];
      row[2] += powers * batch.value[i][2];
      row[3] += powers * batch.value[i][3];
    }
    __builtin_memcpy(own, row, sizeof row);
  }
}
