// Sums over the samples of faces, for one instruction set.
#include <tapestry/raster/detail/line_kernel.inl>

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
