#pragma once
#include <tapestry/nn/detail/convolution.hpp>
#include <tapestry/nn/detail/few_channel_convolution.hpp>

/// \file
/// Convolutions of operands rounded to bfloat16 (the sign, the exponent and the 7 leading fraction bits of a
/// float), summed in float. A processor with AVX512_BF16 computes twice as many of these products as of
/// floats in the same time.
///
/// Inputs and weights are rounded when a convolution reads them; with Winograd's algorithm, the transformed
/// ones are rounded. Everything stored between layers is float, and so are bias, activation and sums of
/// layers. Rounding is to nearest, ties to even. Subnormals become zero, values from 2¹²⁸ − 2¹¹⁹ on become
/// infinity, and NaN stays. The relative error of one layer is 2e-3, and 1.1e-2 with tiles of 4 × 4 outputs.
///
/// The neighbouring channels 2k and 2k + 1 share a word; the even one is in its low half. A sum takes the
/// words one after another, and of each word the odd channel's product before the even one's:
///
///   sum ← (sum + in₂ₖ₊₁ · w₂ₖ₊₁) + in₂ₖ · w₂ₖ
///
/// Each step is rounded to nearest, as in the instruction VDPBF16PS. Processors without it do the same in
/// float, with the same bits, except where a product overflows, or a product or sum is below 2⁻¹²⁶: the
/// instruction makes that zero. Winograd's transforms are in float, so their rounding differs between
/// instruction sets, and the layers it is chosen for may differ too, as without bfloat16.

namespace tapestry::nn {
/// True if Engine::bfloat16 rounds a convolution's operands: float, one group and more than four channels
/// out. Others take little time, and depthwise ones have no sums over channels, so they stay in float.
template <std::floating_point T>
[[nodiscard]] bool takes_pairs(const PackedConvolution<T>& packed) {
  return std::is_same_v<T, float> && packed.shape.groups == 1 && !has_few_channels(packed);
}

namespace detail {
/// Words of a pixel; an odd channel's partner is zero.
[[nodiscard]] constexpr std::size_t pair_count(std::size_t channels) { return (channels + 1) / 2; }

/// The same convolution of words, with rounded weights in `weights`.
inline PackedConvolution<float> paired(const PackedConvolution<float>& packed,
                                       const std::shared_ptr<Buffer<float>>& weights) {
  const std::size_t channels = packed.shape.in_channels, taps = packed.shape.taps();
  const std::size_t lanes = kernels<float>().lanes;
  const std::size_t padded = round_up(packed.shape.out_channels, lanes);
  PackedConvolution<float> pairs = packed;
  pairs.shape.in_channels = pair_count(channels);
  pairs.holds_pairs = true;
  pairs.weights = weights;
  weights->resize(padded * pairs.reduction());
  const std::size_t panels = block_count(padded, 2 * lanes);
  parallel_for(panels, [&](std::size_t panel) {
    static thread_local Buffer<float> zeros(2 * kernels<float>().lanes);
    zeros.fill_zero();
    const std::size_t first = panel * 2 * lanes;
    const std::size_t width = panel_lanes(first, padded, lanes);
    const float* from = packed.weights->data() + first * packed.reduction();
    float* to = weights->data() + first * pairs.reduction();
    for (std::size_t tap = 0; tap < taps; ++tap)
      for (std::size_t c = 0; c < channels; c += 2, to += width) {
        const float* const even = from + (tap * channels + c) * width;
        kernels<float>().pair_rows(even, c + 1 < channels ? even + width : zeros.data(), width, to);
      }
  });
  return pairs;
}

/// Rounds the input rows that a convolution reads; `words` has room for whole pictures.
inline void pair_inputs(const ConvolutionShape& shape, std::size_t images, const float* in, float* words) {
  const std::size_t channels = shape.in_channels;
  const std::size_t row_pixels = shape.columns.input;
  const auto rows = static_cast<std::ptrdiff_t>(shape.rows.input);
  const std::ptrdiff_t begin = std::clamp(-shape.rows.padding, std::ptrdiff_t(0), rows);
  const std::ptrdiff_t end = std::clamp(
      static_cast<std::ptrdiff_t>(shape.rows.reach(shape.rows.output)) - shape.rows.padding, begin, rows);
  const auto row_count = static_cast<std::size_t>(end - begin);
  parallel_for(images * row_count, [&](std::size_t task) {
    const std::size_t row =
        task / row_count * shape.rows.input + static_cast<std::size_t>(begin) + task % row_count;
    const float* from = in + row * row_pixels * channels;
    float* to = words + row * row_pixels * pair_count(channels);
    if (channels % 2 == 0) return kernels<float>().pair_neighbours(from, row_pixels * channels, to);
    for (std::size_t x = 0; x < row_pixels; ++x, from += channels, to += pair_count(channels))
      kernels<float>().pair_neighbours(from, channels, to);
  });
}
}  // namespace detail

/// convolve() with rounded operands; takes_pairs() must be true. Other arguments as there.
inline void convolve_pairs(const PackedConvolution<float>& packed, std::size_t images, const float* in,
                           const Epilogue<float>& end, float* out, std::size_t out_image_size) {
  static thread_local const auto weights = std::make_shared<Buffer<float>>();
  static thread_local Buffer<float> words;
  const PackedConvolution<float> pairs = detail::paired(packed, weights);
  words.resize(images * pairs.shape.in_size());
  detail::pair_inputs(packed.shape, images, in, words.data());
  convolve(pairs, images, static_cast<const float*>(words.data()), end, out, out_image_size);
}
}  // namespace tapestry::nn
