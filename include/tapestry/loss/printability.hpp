#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/compiled.hpp>

namespace tapestry::loss {
/// Standard deviation around a printable colour, in colour units: the spread of a printer's results for one
/// colour.
inline constexpr double printable_spread = 0.05;

/// Colours of a printer that was not measured: all mixtures of black, two greys and white in its three
/// channels, [64, 3], with its black at 0.05 and its white at 0.95.
[[nodiscard]] Array<double, 2> printable_colours();

namespace detail {
inline std::array<double, 3> colour_at(const auto& colours, std::size_t row) {
  return {static_cast<double>(colours(row, 0)), static_cast<double>(colours(row, 1)),
          static_cast<double>(colours(row, 2))};
}

/// The score of one colour, and its derivative by it where `slope` is not null.
double score_of(const std::array<double, 3>& colour, const Array<double, 2>& palette, double spread,
                std::array<double, 3>* slope);

/// \throws ShapeError, DomainError as non_printability()
template <class Texels, class UsedTexels>
void require_printable(const char* operation, const Texels& texels, const UsedTexels& used,
                       const Array<double, 2>& palette, double spread) {
  require_shape(operation, "texels", texels, {used.shape(0) * used.shape(1), 3});
  if (palette.shape(0) == 0 || palette.shape(1) != 3)
    throw ShapeError({operation, ": palette is [", palette.shape(0), ", ", palette.shape(1),
                      "], expected at least one colour of 3 channels"});
  for (const double channel : palette.storage())
    if (!(channel >= 0 && channel <= 1))
      throw DomainError({operation, ": the palette holds ", channel, ", expected channels from 0 to 1"});
  if (!(spread > 0 && spread * spread > 0 && std::isfinite(2 * spread * spread)))
    throw DomainError(
        {operation, ": spread is ", spread, ", expected a number above 0 whose square is, too, and finite"});
}

/// Σ M, in the order of the texels.
template <class UsedTexels>
[[nodiscard]] double used_count(const UsedTexels& used) {
  double count = 0;
  for (const auto weight : used.storage()) count += static_cast<double>(weight);
  return count;
}
}  // namespace detail

/// Non-printability score: distance of a paint's texels from the colours of a printer, as a mean over the
/// texels in use; smooth everywhere.
///
///   L = 1/ΣM · Σ M[i] · s(t[i]),   s(t) = −2σ² · ln( 1/K · Σ_k exp(−|t − p[k]|² / 2σ²) )
///
/// s is the squared distance to the nearest printable colour plus at most 2σ²·ln K, and exactly that distance
/// for a palette of one colour: the log-likelihood of a mixture of Gaussians around the printable colours.
/// Its gradient is twice the difference from the mean of the palette near t, so it is 0 between two equally
/// near colours. Source: Sharif et al., "Accessorize to a crime" (CCS 2016), eq. 5, whose score is the
/// product over the palette of |t − p[k]|: that has a kink at every printable colour, and with a large
/// palette next to no slope elsewhere. Thys et al. (CVPRW 2019) take the distance to the nearest colour,
/// which has kinks; this is its smooth form.
///
/// \param texels   t, [H·W, 3], colours in [0, 1]
/// \param used     M, [H, W], 1 where a painted face refers to the texel and 0 elsewhere
/// \param palette  p, [K, 3], printable colours in [0, 1], at least one
/// \param spread   σ in colour units, above 0
/// \returns L in squared colour units, summed in double in blocks of a fixed order; 0 where nothing is used
/// \throws ShapeError if texels has not H·W rows of 3 or the palette no colours of 3; DomainError if the
///         palette has channels outside [0, 1], or unless the spread and its square are finite and above 0
template <Mask Texels, Mask UsedTexels>
[[nodiscard]] auto non_printability(const Texels& texels, const UsedTexels& used,
                                    const Array<double, 2>& palette, double spread = printable_spread) {
  using T = typename Texels::value_type;
  detail::require_printable("non_printability", texels, used, palette, spread);
  constexpr std::size_t block_size = 256;
  std::vector<double> sums(block_count(used.size(), block_size));
  parallel_for(sums.size(), [&](std::size_t block) {
    const auto [begin, end] = block_range(block, used.size(), block_size);
    for (std::size_t i = begin; i < end; ++i)
      if (const auto weight = static_cast<double>(used.data()[i]); weight != 0)
        sums[block] += weight * detail::score_of(detail::colour_at(texels, i), palette, spread, nullptr);
  });
  const double count = detail::used_count(used);
  return static_cast<T>(count > 0 ? std::accumulate(sums.begin(), sums.end(), 0.0) / count : 0.0);
}

/// Adds loss_adjoint · ∂L/∂texels to texels_adjoint, [H·W, 3]; arguments otherwise as in non_printability().
template <Mask Texels, Mask UsedTexels>
void non_printability_adjoint(const Texels& texels, const UsedTexels& used, const Array<double, 2>& palette,
                              double spread, typename Texels::value_type loss_adjoint,
                              Texels& texels_adjoint) {
  using T = typename Texels::value_type;
  detail::require_printable("non_printability_adjoint", texels, used, palette, spread);
  require_shape("non_printability_adjoint", "texels_adjoint", texels_adjoint, texels.shape());
  const double count = detail::used_count(used);
  constexpr std::size_t block_size = 256;
  parallel_for_blocks(used.size(), block_size, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double weight = static_cast<double>(used.data()[i]);
      if (weight == 0) continue;
      std::array<double, 3> slope{};
      (void)detail::score_of(detail::colour_at(texels, i), palette, spread, &slope);
      for (std::size_t c = 0; c < 3; ++c)
        texels_adjoint(i, c) += static_cast<T>(static_cast<double>(loss_adjoint) * weight / count * slope[c]);
    }
  });
}

/// non_printability() on the active tape; its pullback is non_printability_adjoint().
///
/// \param texels  [H·W, 3]
/// \param used    [H, W]; it and `palette` are shared, and not to be changed before the tape's last reverse()
template <std::floating_point T>
[[nodiscard]] Variable<T> non_printability(const ArrayVariable<T, 2>& texels,
                                           std::shared_ptr<const Array<T, 2>> used,
                                           std::shared_ptr<const Array<double, 2>> palette,
                                           double spread = printable_spread);
}  // namespace tapestry::loss
