// Sums over the samples of faces, for one instruction set.
#include <tapestry/raster/detail/line_kernel.inl>

typedef double EightDoubles __attribute__((vector_size(64)));

/// Adds value_i · {1, b_0, b_1, b_0², b_0·b_1, b_1², 0, 0} to row i of the sums of each point's face.
inline void add_moments(const MomentBatch& batch, std::array<std::array<double, 8>, 4>* sums) {
  EightDoubles row[4];
  for (std::size_t i = 0; i < batch.size;) {
    const std::uint32_t slot = batch.slot[i];
    double* const own = sums[slot][0].data();
    for (std::size_t v = 0; v < 4; ++v) __builtin_memcpy(&row[v], own + 8 * v, sizeof row[v]);
    for (; i < batch.size && batch.slot[i] == slot; ++i) {
      const double x = batch.barycentric[i][0], y = batch.barycentric[i][1];
      const EightDoubles powers = {1, x, y, x * x, x * y, y * y, 0, 0};
      for (std::size_t v = 0; v < 4; ++v) row[v] += powers * batch.value[i][v];
    }
    for (std::size_t v = 0; v < 4; ++v) __builtin_memcpy(own + 8 * v, &row[v], sizeof row[v]);
  }
}
