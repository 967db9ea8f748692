#pragma once
#include <concepts>
#include <cstddef>
#include <string_view>
#include <tapestry/nn/convolution.hpp>
#include <tapestry/nn/few_channel_convolution.hpp>
#include <tapestry/nn/winograd.hpp>

namespace tapestry::nn {

/// How convolutions are computed where there is a choice. All work from the same packed weights.
enum class Engine {
  automatic,    ///< the cheapest by a model of the shape; the default
  direct,       ///< sums of products as written
  winograd_f2,  ///< F(2 × 2, 3 × 3) where it applies, 2.25 times fewer products
  winograd_f4,  ///< F(4 × 4, 3 × 3) where it applies, 4 times fewer products
};

[[nodiscard]] constexpr std::string_view name_of(Engine engine) {
  constexpr std::string_view names[] = {"automatic", "direct", "winograd_f2", "winograd_f4"};
  return names[static_cast<std::size_t>(engine)];
}

namespace detail {

/// Time of Winograd's algorithm for one image, in multiply-adds of one vector; tile 0 means the direct sum.
/// The cost of a transform of one tile or filter vector was measured with AVX-512 and is bound by its loads
/// and stores.
template <std::floating_point T>
[[nodiscard]] double modelled_cost(const ConvolutionShape& shape, std::size_t tile) {
  const auto lanes = kernels<T>().lanes;
  const auto vectors_in = static_cast<double>(block_count(shape.in_channels, lanes));
  const auto vectors_out = static_cast<double>(block_count(shape.out_channels, lanes));
  const auto channels = static_cast<double>(shape.in_channels);
  if (tile == 0) {
    const auto pixels = static_cast<double>(shape.rows.output * shape.columns.output);
    return 1.1 * 9 * pixels * channels * vectors_out;
  }
  const WinogradPlan plan = plan_winograd<T>(shape, 1, tile);
  const auto tiles = static_cast<double>(plan.tiles);
  const auto products = static_cast<double>(plan.points * plan.points);
  const double of_filter = 6 * products;
  const double of_tile = 8 * products;
  return 1.15 * products * tiles * channels * vectors_out +
         of_filter * static_cast<double>(plan.shares_filters ? 1 : plan.ranges) * channels * vectors_out +
         of_tile * tiles * (vectors_in + vectors_out);
}

/// Outputs along an axis of a Winograd tile that `engine` uses for this convolution, or 0. The choice does
/// not depend on the number of images, so that an image's results do not either.
template <std::floating_point T>
[[nodiscard]] std::size_t winograd_tile(Engine engine, const PackedConvolution<T>& packed) {
  if (engine == Engine::direct || !has_winograd(packed)) return 0;
  if (engine != Engine::automatic) return engine == Engine::winograd_f4 ? 4 : 2;
  std::size_t best = 0;
  double cost = modelled_cost<T>(packed.shape, 0);
  for (const std::size_t tile : {std::size_t(4), std::size_t(2)}) {
    const double other = modelled_cost<T>(packed.shape, tile);
    if (other < cost) best = tile;
    cost = std::min(cost, other);
  }
  return best;
}
}  // namespace detail

/// convolve() by the engine's choice of algorithm. Arguments otherwise as there.
///
/// Engines differ in rounding. Winograd's also carry a NaN or an infinity to every output of the tile that
/// reads reads it, as NaN.
template <std::floating_point T>
void convolve(Engine engine, const PackedConvolution<T>& packed, std::size_t images, const T* in,
              const Epilogue<T>& end, T* out, std::size_t out_image_size) {
  if (has_few_channels(packed)) return convolve_few_channels(packed, images, in, end, out, out_image_size);
  const std::size_t tile = detail::winograd_tile(engine, packed);
  if (tile > 0) return convolve_winograd(packed, tile, images, in, end, out, out_image_size);
  convolve(packed, images, in, end, out, out_image_size);
}

}  // namespace tapestry::nn
