#pragma once
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::evaluate {
namespace detail {
/// \throws ShapeError unless colours are [texel, 3] with the texels of the charts; NumericError if the colour
///         of such a texel is not finite
void require_chart_colours(const char* operation, const Array<float, 2>& colours,
                           const std::vector<raster::TextureChart>& charts);
}  // namespace detail

/// Rounds of matched_noise(), each imposing values, then spectrum; later rounds change little.
inline constexpr std::size_t matched_noise_rounds = 30;
/// The same of picture_with_noise(), which draws noise for every picture: in a car's outline one round brings
/// the spectrum as close as thirty rounds, to a hundredth.
inline constexpr std::size_t picture_noise_rounds = 1;

/// The control for an optimised texture: noise with its colours and its spectrum, but without its design. In
/// each chart the Fourier phases are drawn anew, the same shift α(k) for the three channels, so that their
/// correlation stays; then values and spectrum are imposed in turn:
///
///   values     the plane's are replaced by the chart's, in the order of their ranks
///   spectrum   F_c(k) = X_c(k) · e^(iα(k)), where e^(iα) is the direction of Σ_c S_c(k) · conj X_c(k)
///
/// with X the spectrum of the optimised channel and S the plane's, so that F is nearest to S among all
/// spectra with the amplitudes and the relative phases of X.
///
/// The values are exact: each channel of each chart has the same values as before, each as often. The power
/// spectrum is approximate, since the last step imposes the values. The spectrum is closer for evenly spread
/// colours and for charts that fill their boxes, with extents by image::fourier_extent(). Texels outside a
/// chart count as its mean colour, and the spectrum is corrected for them. The noise fills the whole box
/// before the chart is cut out of it. The texels outside are not reset to the mean in between: the amplitudes
/// of a spectrum and a known border determine a picture (Fienup, Applied Optics 21, 1982), and where more
/// than half of a box was border, the rounds ended at the optimised texture itself. Joint distributions of
/// channels keep only their second moments. Texels outside all charts are unchanged.
///
/// Sources: the iterated amplitude adjusted Fourier transform of Schreiber and Schmitz, "Improved surrogate
/// data for nonlinearity tests" (Physical Review Letters 77, 1996); for several channels the same authors,
/// "Surrogate time series" (Physica D 142, 2000), where channels of small amplitude weigh as much as others.
///
/// \param colours  [texel, 3]
/// \param charts   of the texture, see raster::texture_charts(); no texel in two of them
/// \param random   not advanced; the same noise for the same state, for any number of threads
/// \param rounds   as many as matched_noise_rounds
/// \returns        [texel, 3]
/// \throws ShapeError unless colours are [texel, 3] with the charts' texels; NumericError for a colour in a
///         chart that is not finite
[[nodiscard]] Array<float, 2> matched_noise(const Array<float, 2>& colours,
                                            const std::vector<raster::TextureChart>& charts,
                                            const Random& random, std::size_t rounds = matched_noise_rounds);

/// Extents of the patches that shuffled_patches() moves, in texels of a chart.
struct PatchExtents {
  std::size_t height = 1, width = 1;
};

/// atlas: squares of an eighth of its height; cube: the whole of a face; other kinds: single texels.
[[nodiscard]] PatchExtents patch_extents(const raster::TextureLayout& layout);

/// The control that keeps the parts of an optimised texture but not their arrangement. In each chart, the
/// patches that lie wholly in it change places in one random cycle, so that none stays where it is. The rest
/// of the chart, or all of it if there is room for one patch only, is cut into patches of half the extents,
/// which change places among themselves, and so on down to single texels. Each texel's colour stays somewhere
/// in its chart.
///
/// \param colours  [texel, 3]
/// \param charts   of the texture, see raster::texture_charts(); no texel in two of them
/// \param patch    extents of the largest patches, see patch_extents()
/// \param random   not advanced; the same places for the same state
/// \returns        [texel, 3]; texels outside all charts unchanged
/// \throws DomainError for a patch without texels; ShapeError unless colours are [texel, 3] with the charts'
///         texels; NumericError for a colour in a chart that is not finite
[[nodiscard]] Array<float, 2> shuffled_patches(const Array<float, 2>& colours,
                                               const std::vector<raster::TextureChart>& charts,
                                               PatchExtents patch, const Random& random);

/// A control: a texture that was not optimised for this. A camouflage must hide the car better than its
/// controls do.
struct Control {
  std::string name;
  camouflage::Paint<float> paint{};
  /// Share of a matched control's values that equal the camouflage's at the same place; chance leaves some
  /// where a value is common. 0 for other controls.
  double share_in_place = 0;
};

/// The control that an attack's effect is stated against.
inline constexpr const char* matched_noise_name = "matched noise";
/// The control of noise that is drawn in each picture, see picture_with_noise().
inline constexpr const char* picture_noise_name = "picture noise";
/// The control of patches in other places.
inline constexpr const char* shuffled_patches_name = "shuffled";
/// Another camouflage, measured among the controls.
inline constexpr const char* other_run_name = "other run";

/// 1 for each face that a camera around the mesh sees, from the horizon to 60 degrees above
/// it. All, if it sees none.
[[nodiscard]] std::vector<std::uint8_t> faces_seen_around(const geometry::Mesh& mesh);

/// Charts as one. Texels of an atlas keep their places, so that distances in the chart are those in uv; other
/// kinds lie below each other.
/// \param charts  no texel in two of them
[[nodiscard]] raster::TextureChart joined_chart(const std::vector<raster::TextureChart>& charts,
                                                const raster::TextureLayout& layout);

/// Bytes that matched_controls() takes for each place of a texture: planes, spectra, ranks, charts.
inline constexpr std::uint64_t matched_controls_bytes = 180;

/// The matched controls of a camouflage: "matched noise" has its colours and its spectrum, "shuffled" its
/// parts; neither has its design. See matched_noise() and shuffled_patches().
///
/// Noise is drawn over the whole car, see joined_chart(): a chart of a coarse atlas has few texels, so that
/// values drawn within it often stay where they were, and the control would hold part of the design. Patches
/// change places within charts. Both take place among the texels that cameras around the car can see, see
/// faces_seen_around(); below the car no view has optimised anything, and its first colour would dilute the
/// noise. If a camouflage covers parts of the car, so do its controls, and the rest stays the car's own.
/// Where a texture repeats a picture, the noise differs at each copy. Seeds fix the results.
///
/// \param noise_draws  of matched noise, under one name, one after another; the first does not depend on it
/// \throws ShapeError unless the paint is of the car's texels; as raster::texture_charts(), matched_noise()
[[nodiscard]] std::vector<Control> matched_controls(const raster::PaintedMesh& car,
                                                    const camouflage::Paint<float>& paint, std::uint64_t seed,
                                                    std::size_t noise_draws = 1);

/// Control::share_in_place of matched noise, the mean over its draws; none without it.
[[nodiscard]] std::optional<double> noise_in_place(const std::vector<Control>& controls);

/// Picture of a view with noise in place of its paint. The noise is drawn in the picture and not on the car:
/// it matches the paint as it appears there, in the same light. The same picture with black and with grey
/// paint separates each pixel's paint from its light. So the noise has the colours and the spectrum that this
/// camera sees of the paint, at whatever scale, and no design. No texture looks like it from two sides.
///
/// \param paint   colours and, where it covers parts of the car, which these are
/// \param random  not advanced; see matched_noise()
/// \returns       [H, W, 3]; camouflage::picture_of() where the paint does not show
/// \throws ShapeError as camouflage::picture_of(), camouflage::require_sound()
[[nodiscard]] Array<float, 3> picture_with_noise(const camouflage::View<float>& view,
                                                 const camouflage::Paint<float>& paint, const Random& random);

/// Controls that do not depend on a camouflage: random noise and six solid colours all over the car; the same
/// for the same seed.
[[nodiscard]] std::vector<Control> plain_controls(std::size_t texel_count, std::uint64_t seed);

/// All controls of a camouflage: the matched ones, then the plain ones; parameters as for matched_controls().
[[nodiscard]] std::vector<Control> make_controls(const raster::PaintedMesh& car,
                                                 const camouflage::Paint<float>& paint, std::uint64_t seed,
                                                 std::size_t noise_draws = 1);
}  // namespace tapestry::evaluate
