// Kernels on pairs of bfloat16, for one instruction set.
#include <tapestry/nn/detail/winograd_kernels.inl>

/// The filters of pairs of channels; channel_count is even, and a point has half as many words.
template <WinogradForm F>
void winograd_filter_pairs(const WinogradFilterArguments<float>& a) {
  constexpr std::size_t lanes = Vector<float>::lanes;
  constexpr std::size_t count = extents_of(F).points;
  constexpr std::size_t tap_count = extents_of(F).taps;
  for (std::size_t channel = 0; channel < a.channel_count; channel += 2)
    for (std::size_t lane = 0; lane < a.width; lane += lanes) {
      Register<float> half[2][count * tap_count], whole[2][count];
#pragma GCC unroll 2
      for (std::size_t c = 0; c < 2; ++c) {
        const float* weights = a.weights + (channel + c) * a.width + lane;
        Register<float> taps[tap_count * tap_count];
#pragma GCC unroll 9
        for (std::size_t t = 0; t < tap_count * tap_count; ++t) taps[t] = load(weights + t * a.tap_step);
#pragma GCC unroll 3
        for (std::size_t x = 0; x < tap_count; ++x) {
          Winograd<float, F>::filter(taps + x, tap_count, whole[0]);
#pragma GCC unroll 6
          for (std::size_t y = 0; y < count; ++y) half[c][y * tap_count + x] = whole[0][y];
        }
      }
      float* const out = a.out + channel / 2 * a.width + lane;
#pragma GCC unroll 6
      for (std::size_t y = 0; y < count; ++y) {
#pragma GCC unroll 2
        for (std::size_t c = 0; c < 2; ++c) Winograd<float, F>::filter(half[c] + y * tap_count, 1, whole[c]);
#pragma GCC unroll 6
        for (std::size_t x = 0; x < count; ++x)
          store_words(out + (y * count + x) * a.point_step, pairs_of(whole[0][x], whole[1][x]));
      }
    }
}

/// out[i] = (in[2 i], in[2 i + 1]), with a zero after an odd count.
inline void pair_neighbours(const float* in, std::size_t count, float* out) {
  constexpr std::size_t lanes = Vector<float>::lanes;
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) store_neighbours(out + i / 2, load(in + i));
  if (i == count) return;
  float rest[lanes] = {}, pairs[lanes / 2];
  for (std::size_t k = i; k < count; ++k) rest[k - i] = in[k];
  store_neighbours(pairs, load(rest));
  __builtin_memcpy(out + i / 2, pairs, (count - i + 1) / 2 * sizeof(float));
}

/// out[i] = (first[i], second[i]) for whole registers.
inline void pair_rows(const float* first, const float* second, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; i += Vector<float>::lanes)
    store_words(out + i, pairs_of(load(first + i), load(second + i)));
}

template <int V, int P>
void fill_pair_rows(Kernels<float>& kernels) {
  kernels.reduce_pairs[V - 1][P - 1] = &reduce_tile<float, V, P, PairProduct>;
  if constexpr (P > 1) fill_pair_rows<V, P - 1>(kernels);
}

template <WinogradForm F>
void fill_winograd_pairs(Kernels<float>& kernels) {
  constexpr auto index = static_cast<std::size_t>(F);
  kernels.winograd_filter_pairs[index] = &winograd_filter_pairs<F>;
  kernels.winograd_input_pairs[index] = &winograd_input<float, F, true>;
}

inline void fill_bfloat16(Kernels<float>& kernels) {
  fill_pair_rows<1, tile_rows>(kernels);
  fill_pair_rows<2, tile_rows>(kernels);
  fill_winograd_pairs<WinogradForm::f2_taps3>(kernels);
  fill_winograd_pairs<WinogradForm::f4_taps3>(kernels);
  fill_winograd_pairs<WinogradForm::f4_taps2>(kernels);
  kernels.pair_neighbours = &pair_neighbours;
  kernels.pair_rows = &pair_rows;
}
