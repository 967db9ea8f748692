#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::evaluate {

/// A control: a texture that was not optimised. What hides the car from a detector must hide it better than
/// these do.
template <class T>
struct Control {
  std::string name;
  camouflage::Paint<T> paint{};
};

/// The control that an attack's effect is stated against.
inline constexpr const char* matched_noise_name = "matched noise";
inline constexpr const char* shuffled_patches_name = "shuffled";
/// Another camouflage, measured among the controls.
inline constexpr const char* other_run_name = "other run";

/// The controls that a camouflage is taken apart into: "matched noise" has its colours and its spectrum and
/// "shuffled" its parts, neither its design; see matched_noise() and shuffled_patches(). Texels that no view
/// has shown to the optimisation have kept their first colour, which moves about in their chart like others.
/// Where a camouflage covers parts of the car, so do they: each piece of a part that hangs together is a
/// chart of its own, and the rest stays the car's own. Copies of one picture are not copies in the noise. The
/// same for the same seed.
///
/// \throws ShapeError unless the paint is of the car's texels; as raster::texture_charts(), matched_noise()
template <std::floating_point T>
[[nodiscard]] std::vector<Control<T>> matched_controls(const raster::PaintedMesh& car,
                                                       const camouflage::Paint<T>& paint, std::uint64_t seed);

/// Controls that know nothing of a camouflage: random noise and six solid colours all over the car; the same
/// for the same seed.
template <class T>
[[nodiscard]] std::vector<Control<T>> plain_controls(std::size_t texel_count, std::uint64_t seed);

/// All controls of a camouflage: the matched ones, then the plain ones; parameters as for matched_controls().
template <std::floating_point T>
[[nodiscard]] std::vector<Control<T>> make_controls(const raster::PaintedMesh& car,
                                                    const camouflage::Paint<T>& paint, std::uint64_t seed);

}  // namespace tapestry::evaluate
