#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/raster/texture_charts.hpp>
#include <vector>

namespace tapestry::evaluate {

/// How often matched_noise() alternates between values and spectrum; later rounds change little.
inline constexpr std::size_t matched_noise_rounds = 30;

/// The control for an optimised texture: noise with its colours and its spectrum, but without its design. In
/// each chart the Fourier phases are drawn anew, the same shift α(k) for the three channels, so that their
/// correlation stays; then values and spectrum are imposed in turn:
///
///   values     the plane's are replaced by the chart's, in the order of their ranks
///   spectrum   F_c(k) = X_c(k) · e^(iα(k)), where e^(iα) is the direction of Σ_c S_c(k) · conj X_c(k)
///
/// with X the spectrum of the optimised channel and S that of the plane, so that F is the nearest to S which
/// has the amplitudes and the relative phases of X.
///
/// Exact: each channel of each chart has the same values as before, each as often. Approximate: the power
/// spectrum; the last step is that of the values. It comes nearer the more evenly the colours are spread and
/// the fuller the chart's bounding box is. Texels outside a chart count as its mean colour, the spectrum is
/// corrected for them, and the noise fills the whole box before the chart is cut out of it. They are not
/// set back to the mean in between: a picture is determined by the amplitudes of its spectrum and a border
/// that is known (Fienup, Applied Optics 21, 1982), and where more than half of a box was border, the rounds
/// were seen to end at the optimised texture itself. Joint distributions of channels are kept in their second
/// moments only. Texels of no chart stay as they are.
///
/// Sources: the iterated amplitude adjusted Fourier transform of Schreiber and Schmitz, "Improved surrogate
/// data for nonlinearity tests" (Physical Review Letters 77, 1996); for several channels the same authors,
/// "Surrogate time series" (Physica D 142, 2000), where channels of small amplitude weigh as much as others.
///
/// \param colours  [texel, 3]
/// \param charts   of the texture, see raster::texture_charts(); no texel in two of them
/// \param random   not advanced; the same noise for the same state, for any number of threads
/// \returns        [texel, 3]
/// \throws ShapeError unless colours are [texel, 3] with the charts' texels; NumericError for a colour in a
///         chart that is not finite
template <std::floating_point T>
[[nodiscard]] Array<T, 2> matched_noise(const Array<T, 2>& colours,
                                        const std::vector<raster::TextureChart>& charts,
                                        const Random& random);

}  // namespace tapestry::evaluate
