#pragma once
#include <tapestry/nn/detail/bfloat16.hpp>
#include <tapestry/nn/detail/convolution_window.hpp>
#include <tapestry/nn/detail/winograd.hpp>

namespace tapestry::nn {
/// How convolutions are computed where there is a choice. All work from the same packed weights.
enum class Engine {
  automatic,    ///< the cheapest by a model of the shape; the default
  direct,       ///< sums of products as written
  winograd_f2,  ///< tiles of 2 × 2 outputs where they apply, up to 2.25 times fewer products
  winograd_f4,  ///< tiles of 4 × 4 outputs where they apply, up to 4 times fewer products
  bfloat16,     ///< automatic, of operands rounded to bfloat16; see bfloat16.hpp. Less accurate
};

[[nodiscard]] constexpr std::string_view name_of(Engine engine) {
  constexpr std::string_view names[] = {"automatic", "direct", "winograd_f2", "winograd_f4", "bfloat16"};
  return names[static_cast<std::size_t>(engine)];
}

namespace detail {
/// Estimated time of a convolution of one image, in multiply-adds of one vector. The costs of transforming
/// one tile or one filter vector were measured with AVX-512; loads and stores limit them.
template <std::floating_point T>
[[nodiscard]] double modelled_cost(const ConvolutionShape& shape, std::optional<WinogradForm> form,
                                   bool pairs = false) {
  const auto lanes = kernels<T>().lanes;
  const auto vectors_in = static_cast<double>(block_count(shape.in_channels, lanes));
  const auto vectors_out = static_cast<double>(block_count(shape.out_channels, lanes));
  const auto channels = static_cast<double>(shape.in_channels);
  const double step = pairs ? 0.5 : 1;  // cost of a reduction, per channel
  if (!form) {
    const auto products = static_cast<double>(shape.taps() * shape.rows.output * shape.columns.output);
    return 1.15 * step * products * channels * vectors_out;
  }
  const WinogradPlan plan = plan_winograd<T>(shape, 1, *form, pairs);
  const auto tiles = static_cast<double>(plan.tiles);
  const auto products = static_cast<double>(plan.products);
  const auto of_filter = 6 * products;
  return 1.15 * step * products * tiles * channels * vectors_out +
         of_filter * static_cast<double>(plan.shares_filters ? 1 : plan.ranges) * channels * vectors_out +
         8 * products * tiles * (vectors_in + vectors_out);
}

/// The form of Winograd's algorithm that `engine` uses for this convolution, if any. The choice does not
/// depend on the number of images, so that an image's results do not either.
template <std::floating_point T>
[[nodiscard]] std::optional<WinogradForm> winograd_form(Engine engine, const PackedConvolution<T>& packed) {
  std::optional<WinogradForm> best;
  const bool pairs = engine == Engine::bfloat16 && takes_pairs(packed);
  if (pairs && packed.shape.in_channels % 2 != 0) return best;
  const bool is_free = engine == Engine::automatic || engine == Engine::bfloat16;
  double cost = modelled_cost<T>(packed.shape, best, pairs);
  for (std::size_t i = 0; i < winograd_form_count; ++i) {
    const auto form = static_cast<WinogradForm>(i);
    const bool is_small = extents_of(form).outputs == 2;
    const bool is_allowed = is_free || engine == (is_small ? Engine::winograd_f2 : Engine::winograd_f4);
    if (!is_allowed || !has_form(packed, form)) continue;
    const double other = modelled_cost<T>(packed.shape, form, pairs);
    if (is_free && other >= cost) continue;
    best = form;
    cost = other;
  }
  return best;
}
}  // namespace detail

/// Outputs and inputs that the engine computes together along either axis: a tile where it uses Winograd's
/// algorithm. In a tile only the product at the point ∞ reads the last input, and only the last output uses
/// that product. With three taps, the same holds for the product at 0 and the first input and output.
template <std::floating_point T>
[[nodiscard]] OutputTile tile_of(Engine engine, const PackedConvolution<T>& packed) {
  const auto form = detail::winograd_form(engine, packed);
  if (!form) return {};
  return {extents_of(*form).outputs, extents_of(*form).taps == 3 ? std::size_t(1) : std::size_t(0), 1};
}

/// convolve() with the algorithm that the engine chooses. Other arguments as there.
///
/// \param window  part of the picture that outputs are written to: only the outputs there and those of the
///                same tiles are computed, see windowed(), with the same bits as without it. None: all
///
/// Engines differ in rounding. Winograd's algorithm also turns a NaN or an infinity into NaN in every output
/// of a tile that reads it, and overflows already within two decades of the largest number.
template <std::floating_point T>
void convolve(Engine engine, const PackedConvolution<T>& packed, std::size_t images, const T* in,
              const Epilogue<T>& end, T* out, std::size_t out_image_size,
              const std::optional<MapWindow>& window = {}) {
  const bool pairs = engine == Engine::bfloat16 && takes_pairs(packed);
  const bool has_few = has_few_channels(packed) && end.addend == nullptr && end.factor == nullptr &&
                       end.gate == nullptr && end.curve.kind == CurveKind::none;
  const auto form = has_few ? std::nullopt : detail::winograd_form(engine, packed);
  const auto run = [&](const PackedConvolution<T>& part) {
    if (has_few) return convolve_few_channels(part, images, in, end, out, out_image_size);
    if (form) return convolve_winograd(part, *form, images, in, end, out, out_image_size, pairs);
    if constexpr (std::is_same_v<T, float>)
      if (pairs) return convolve_pairs(part, images, in, end, out, out_image_size);
    convolve(part, images, in, end, out, out_image_size);
  };
  if (!window) return run(packed);
  const PackedConvolution<T> part = windowed(packed, tile_of(engine, packed), *window);
  if (part.shape.rows.output > 0 && part.shape.columns.output > 0) run(part);
}
}  // namespace tapestry::nn
