#pragma once
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/instruction_set.hpp>
#include <tapestry/core/vector_exp.hpp>
#include <tapestry/nn/activation.hpp>

namespace tapestry::nn {
/// Steps from a sum to the value stored at out[i], where i counts from `origin`:
///
///   value   = (sum + bias + (out[i] if adds)) · factor[i]
///   value   = value · slope where value ≤ 0 or, if there is a gate, where bit i of it is not set
///   bit i of `positive` = value > 0
///   out[i]  = value + addend[i]
///
/// or with a curve, which excludes factor, slope, gate and bits,
///
///   slopes[i] = curve'(value),   out[i] = curve(value) + addend[i]
///
/// Bit i is bit i mod 8 of byte i / 8; where bits are used, all vectors begin at whole bytes and are full.
template <std::floating_point T>
struct Epilogue {
  const T* bias = nullptr;             ///< one for each lane, readable up to whole vectors
  bool adds = false;                   ///< add to the outputs
  const T* factor = nullptr;           ///< laid out as the output, or null
  T slope = 1;                         ///< 1 changes nothing
  const std::uint8_t* gate = nullptr;  ///< bits, or null
  std::uint8_t* positive = nullptr;    ///< bits to write, or null
  const T* addend = nullptr;           ///< laid out as the output, or null
  Curve<T> curve = {};                 ///< kind none: no curve
  T* slopes = nullptr;                 ///< receives the curve's slopes, laid out as the output; or null
  const T* origin = nullptr;           ///< start of the output; the convolution sets it
};

/// A product of a small matrix, P rows, with a panel of weights: the core of every convolution.
template <std::floating_point T>
struct ReduceArguments {
  const T* in;
  std::ptrdiff_t in_row_step;
  std::ptrdiff_t in_outer_step;
  std::ptrdiff_t in_inner_step;
  const T* weights;  ///< [outer_count · inner_count, V · lanes]
  std::size_t outer_count;
  std::size_t inner_count;
  T* out;
  std::ptrdiff_t out_row_step;
  std::size_t lane_count;  ///< number of the V · lanes to store
  Epilogue<T> end;
};

/// One row of outputs of a convolution of each channel with its own filter, from the row taps that lie in the
/// picture.
template <std::floating_point T>
struct DepthwiseArguments {
  const T* in;  ///< the row of the first row tap, column 0
  std::size_t in_row_step;
  std::size_t row_taps;
  std::size_t column_taps;
  std::size_t column_stride;
  std::size_t column_spacing;
  std::ptrdiff_t column_padding;
  std::size_t in_columns;
  const T* weights;         ///< [row tap, column tap, weight_step]
  std::size_t weight_step;  ///< channels rounded up to whole vectors
  std::size_t channel_count;
  std::size_t out_columns;
  T* out;
  std::size_t out_pixel_step;
  Epilogue<T> end;
};

/// One row of the adjoint of such a convolution with respect to its weights.
template <std::floating_point T>
struct DepthwiseWeightArguments {
  const T* in;
  std::size_t in_pixel_step;
  const std::ptrdiff_t* tap_offsets;  ///< from a pixel's origin in `in`
  std::size_t tap_count;
  const T* out_adjoint;
  std::size_t pixel_count;
  std::size_t channel_count;
  T* weights_adjoint;       ///< [tap_count, weight_step], added to
  std::size_t weight_step;  ///< channels rounded up to whole vectors
};

/// One row of outputs that are sums of products computed before, for each tap and channel; see
/// convolve_few_channels().
template <std::floating_point T>
struct GatherArguments {
  const T* const* tap_rows;  ///< for each row tap its products, [pixel, products of a pixel]
  std::size_t row_taps;
  std::size_t column_taps;
  std::size_t products_step;  ///< from a pixel's products to the next one's
  std::size_t pixel_count;
  std::size_t channel_count;  ///< at most 4; a pixel's products are [row tap, column tap, channel]
  T* out;
  std::size_t out_pixel_step;
  Epilogue<T> end;
};

/// Index of a pixel in a picture; as wide as T, so that vectors of both have as many lanes.
template <std::floating_point T>
using ElementIndex = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;

/// Arguments of a kernel of MaxPool.
template <std::floating_point T>
struct MaxPoolArguments {
  const T* in;  ///< the window's first pixel
  std::size_t rows;
  std::size_t columns;
  std::size_t row_step;
  std::size_t channels;
  ElementIndex<T> first_position;
  std::size_t width;  ///< positions of a row of the picture
  T* out;
  ElementIndex<T>* choice;  ///< or null
};

/// Tiles that Winograd's algorithm is implemented for, the same along both axes; see winograd.hpp.
enum class WinogradForm { f2_taps3, f4_taps3, f4_taps2 };
inline constexpr std::size_t winograd_form_count = 3;

/// Numbers along one axis of a tile.
struct WinogradExtents {
  std::size_t outputs;
  std::size_t points;  ///< inputs, and as many products
  std::size_t taps;
};

[[nodiscard]] constexpr WinogradExtents extents_of(WinogradForm form) {
  constexpr WinogradExtents extents[] = {{2, 4, 3}, {4, 6, 3}, {4, 5, 2}};
  return extents[static_cast<std::size_t>(form)];
}

/// Transforms the filters of some input channels for Winograd's algorithm; see winograd.hpp.
template <std::floating_point T>
struct WinogradFilterArguments {
  const T* weights;  ///< [9 taps (tap_step apart), channel_count, width]
  std::size_t tap_step;
  std::size_t channel_count;
  std::size_t width;  ///< filters side by side, whole vectors
  T* out;             ///< [points (point_step apart), channel_count, width]
  std::size_t point_step;
};

/// Arguments of a transform of input tiles.
template <std::floating_point T>
struct WinogradInputArguments {
  const T* const* pixels;  ///< pixels of the tile by rows, each readable to a whole vector
  std::size_t first_channel;
  std::size_t channel_count;
  T* out;  ///< [points (point_step apart), channels]
  std::size_t point_step;
};

/// Transforms one tile's products back.
template <std::floating_point T>
struct WinogradOutputArguments {
  const T* sums;  ///< [points (point_step apart), filters]
  std::size_t point_step;
  std::size_t rows;     ///< rows of the tile within the picture
  std::size_t columns;  ///< likewise
  T* out;               ///< the tile's first pixel
  std::size_t row_step;
  std::size_t pixel_step;
  std::size_t lane_count;  ///< filters to store
  Epilogue<T> end;
};

/// The kernels of one instruction set; see vector_kernels.inl for what each computes.
template <std::floating_point T>
struct Kernels {
  static constexpr std::size_t most_tile_rows = 12;
  std::size_t lanes = 0;                                              ///< of one vector
  std::size_t tile_rows = 0;                                          ///< largest P
  void (*reduce[2][most_tile_rows])(const ReduceArguments<T>&) = {};  ///< [V − 1][P − 1]
  void (*winograd_filters[winograd_form_count])(const WinogradFilterArguments<T>&) = {};  ///< by WinogradForm
  void (*winograd_input[winograd_form_count])(const WinogradInputArguments<T>&) = {};
  void (*winograd_output[winograd_form_count])(const WinogradOutputArguments<T>&) = {};
  // The same kernels for words that hold pairs of bfloat16, see bfloat16.hpp; null unless T is float.
  void (*reduce_pairs[2][most_tile_rows])(const ReduceArguments<T>&) = {};
  void (*winograd_filter_pairs[winograd_form_count])(const WinogradFilterArguments<T>&) = {};
  void (*winograd_input_pairs[winograd_form_count])(const WinogradInputArguments<T>&) = {};
  void (*pair_neighbours)(const T*, std::size_t, T*) = nullptr;
  void (*pair_rows)(const T*, const T*, std::size_t, T*) = nullptr;
  void (*gather_row)(const GatherArguments<T>&) = nullptr;
  void (*depthwise_row)(const DepthwiseArguments<T>&) = nullptr;
  void (*depthwise_weight_adjoint_row)(const DepthwiseWeightArguments<T>&) = nullptr;
  void (*add)(const T*, T*, std::size_t) = nullptr;
  void (*positive_bits)(const T*, std::uint8_t*, std::size_t) = nullptr;
  void (*leaky_adjoint)(const std::uint8_t*, T, const T*, T*, std::size_t) = nullptr;
  void (*apply_curve)(const Curve<T>&, const T*, T*, T*, std::size_t) = nullptr;
  void (*multiply)(const T*, T*, std::size_t) = nullptr;
  void (*affine)(const T*, const T*, const T*, std::size_t, T*, std::size_t) = nullptr;
  void (*combine)(const T*, const T*, const T*, const T*, std::size_t, T*, std::size_t) = nullptr;
  void (*interleave)(const T*, const T*, std::size_t, std::size_t, T*) = nullptr;
  void (*interleave_adjoint)(const T*, std::size_t, std::size_t, T*, T*) = nullptr;
  void (*max_pool_pixel)(const MaxPoolArguments<T>&) = nullptr;
  void (*periodic_sums)(const T*, const T*, const T*, std::size_t, T*, T*, std::size_t) = nullptr;
};

using tapestry::best_instruction_set;
using tapestry::InstructionSet;

/// True if the processor has instructions for bfloat16. Without them, kernels emulate bfloat16 in float.
[[nodiscard]] inline bool has_bfloat16() {
#if defined(TAPESTRY_ONE_INSTRUCTION_SET) && !(defined(__AVX512BF16__) && defined(__AVX512BW__))
  return false;
#elif defined(__x86_64__)
  return best_instruction_set() == InstructionSet::avx512 && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512bf16");
#else
  return false;
#endif
}

/// The kernels of one instruction set; the processor must have it.
template <std::floating_point T>
[[nodiscard]] Kernels<T> kernels_of(InstructionSet set);

/// The kernels in use, chosen once. Results differ in rounding between instruction sets.
template <std::floating_point T>
[[nodiscard]] const Kernels<T>& kernels() {
  static const Kernels<T> chosen = kernels_of<T>(instruction_set());
  return chosen;
}
}  // namespace tapestry::nn
