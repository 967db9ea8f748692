#pragma once
#include <array>
#include <cstddef>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/random.hpp>

namespace tapestry::camouflage {

/// How the texture starts.
enum class TextureStart {
  random,  ///< every texel an independent colour, uniform in [0.02, 0.98]³
  zero,    ///< parameter 0, mid grey
  own,     ///< the colours that the mesh's materials give
};

/// Colours farther than this from 0 and 1 are kept exactly by parameter_of_colours().
inline constexpr double colour_margin = 1e-3;

/// The colours of a texture parameter on the tape: c = ½ (tanh p + 1), so that no step leaves (0, 1). Its
/// slope keeps its relative accuracy where tanh saturates. Others write sigmoid(p) or clamp(p, 0, 1) here.
///
/// \param parameter  p, [texel, 3], any real value
/// \returns          c, [texel, 3], in [0, 1]; exactly 0 or 1 where tanh saturates
/// Source: the texture parametrisation of Wang et al.'s published FCA program.
template <class T>
[[nodiscard]] ArrayVariable<T, 2> texture_colours(const ArrayVariable<T, 2>& parameter) {
  return (tanh(parameter) + T(1)) / T(2);
}

/// The same of plain numbers.
template <class T>
[[nodiscard]] Array<T, 2> texture_colours(const Array<T, 2>& parameter) {
  return texture_colours(ArrayVariable<T, 2>(parameter)).value();
}

/// The parameter whose colours are given: p = atanh(2c − 1), with c first moved into
/// [colour_margin, 1 − colour_margin], since a full white or black would need an infinite p.
template <class T>
[[nodiscard]] Array<T, 2> parameter_of_colours(const Array<T, 2>& colours);

/// Every texel an independent colour, uniform in [0.02, 0.98]³: the random start and the noise control.
template <class T>
[[nodiscard]] Array<T, 2> random_colours(std::size_t texel_count, Random& random);

/// Every texel the same colour.
template <class T>
[[nodiscard]] Array<T, 2> solid_colours(std::size_t texel_count, const std::array<double, 3>& colour);

}  // namespace tapestry::camouflage
