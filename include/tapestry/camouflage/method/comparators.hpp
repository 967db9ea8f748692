#pragma once
#include <tapestry/camouflage/detail/method/method.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {

/// The whole painted body, each texel for itself.
///
/// Source: Wang et al., "FCA: Learning a 3D Full-coverage Vehicle Camouflage for Multi-view Physical
/// Adversarial Attack" (AAAI 2022), eq. 1 and Algorithm 1. Faithful: what is painted, by what parameter and
/// optimiser. The loss is the objective's, for this as for all methods, so that designs are compared and not
/// losses.
///
/// The method rauca is the same texture in light that is transferred from the photographs, see photo_light():
/// Zhou et al., "RAUCA" (ICML 2024), section 3.2. Faithful: the render is multiplied by the light of its
/// photograph, and the loss −log(1 − max score) is our max_score. Simplified: RAUCA learns a network that
/// predicts from the photograph a factor and a summand for each pixel; here sun and sky are estimated from
/// the car in it, and only multiply.
template <std::floating_point T>
[[nodiscard]] Method<T> fca() {
  return {};
}

/// Noise, see random_colours(), that is not optimised: the effect of covering the car in any pattern.
///
/// Source: the control "random" of the tables; the papers lack it.
template <std::floating_point T>
[[nodiscard]] Method<T> random_paint(std::size_t texel_count, std::uint64_t seed);

/// One colour for the whole body, optimised from its start like every other method; another start may end in
/// another colour. The gain of a method over it is the gain of its pattern.
///
/// Source: ours; the papers measure single colours at most, as the solid controls of the tables do.
template <std::floating_point T>
[[nodiscard]] Method<T> solid_paint(std::size_t texel_count);

namespace detail {

inline bool is_inside(const std::array<double, 2>& place) {
  return std::min(place[0], place[1]) >= 0 && std::max(place[0], place[1]) <= 1;
}

}  // namespace detail

/// One square picture on roof, hood and doors, upright and readable on each, as large as the panel allows;
/// the rest of the car keeps its own colours. The picture has about as many pixels as its largest copy has
/// texels.
///
/// Source: the patches of Thys et al., "Fooling automated surveillance cameras" (CVPR workshops 2019),
/// section 3, pasted on a car as the camouflage papers compare with them. Faithful: one picture for all
/// places. Seen by a camera the panel's picture is its homography as far as the panel is flat. Simplified:
/// smoothness and printability are those of the objective.
///
/// \throws as panel_texels(); Error (mismatch) if no panel holds a square of texels
template <std::floating_point T>
[[nodiscard]] Method<T> planar_patch(const raster::PaintedMesh& car);

/// Colours along an edge of CAMOU's pattern.
inline constexpr std::size_t camou_pattern_edge = 16;

/// A pattern of 16 × 16 colours, row by row, that is repeated all over the atlas, at most four times along
/// its height: a colour fills a square of as few texels as allow it.
///
/// Source: Zhang et al., "CAMOU: Learning a Vehicle Camouflage for Physical Adversarial Attack on Object
/// Detectors in the Wild" (ICLR 2019), section 3. Faithful: the small repeated pattern. Simplified, in its
/// favour: CAMOU's renderer has no gradient, so it learns a network that imitates renderer and detector, and
/// follows the gradient of that network; here the pattern follows the gradient itself.
///
/// \throws DomainError unless the texture is an atlas
template <std::floating_point T>
[[nodiscard]] Method<T> camou(const raster::PaintedMesh& car);

/// Largest distance of a colour of upc() from its picture.
inline constexpr double upc_bound = 35.0 / 255;

/// A set of patches, one for roof, hood and either side's doors, each texel for itself but within upc_bound
/// of a natural picture; the rest of the car keeps its own colours.
///
/// Source: Huang et al., "Universal Physical Camouflage Attacks on Object Detectors" (CVPR 2020),
/// sections 3.2 and 3.3: patterns on few regions, shared by all views, with a semantic constraint ‖pattern −
/// picture‖∞ ≤ ε. Faithful: regions, universality, and the bound. Simplified: there are four regions instead
/// of eight. Drawn foliage replaces a photograph. The parametrisation keeps the bound, see method_colours(),
/// instead of a projection after each step. Detectors have no first stage whose proposals could be attacked;
/// the loss is the objective's. Pictures are transformed only if the conditions of a run require it, in the
/// paper at every step.
///
/// \throws as panel_texels()
template <std::floating_point T>
[[nodiscard]] Method<T> upc(const raster::PaintedMesh& car, std::uint64_t seed);

/// The whole body, each texel for itself, to scatter the detector's attention: minimises loss::attention() of
/// a heat map, and smoothness as always, instead of an adversarial loss.
///
/// Source: Wang et al., "Dual Attention Suppression Attack: Generate Adversarial Camouflage in Physical
/// World" (CVPR 2021), eq. 4 and 5, on the faces that FCA (AAAI 2022) compares with as DAS-full. Faithful:
/// the loss, in which score and layer are constants as in its published program. Simplified: the map is the
/// LayerCAM of the attacked detector's most confident candidate, over the last layer that all its heads
/// depend on. The Grad-CAM of a classifier is not used, since it shows next to nothing of a detector's score.
/// The second term is left out: closeness to the edges of a content picture, which is for human eyes.
///
/// The loss is small, about 0.005 against YOLOX-nano, where the smoothness term is 0.01 to 0.04 at its usual
/// weight: the optimisation then smooths the paint, and the car is found as often as without it. DAS has no
/// such term; give it the weight 0.
template <std::floating_point T>
[[nodiscard]] Method<T> das_full();

/// The same on roof, hood and doors only, which DAS selects by hand (309 faces of its car); the rest of the
/// car keeps its own colours.
/// \throws as panel_texels()
template <std::floating_point T>
[[nodiscard]] Method<T> das(const raster::PaintedMesh& car);

/// Texture and shape: the whole painted body, each texel for itself, and an offset of every position of the
/// car, painted or not, of at most a hundredth of its length along each axis. Both start and step together.
///
/// Source: Xiao et al., "MeshAdv: Adversarial Meshes for Visual Recognition" (CVPR 2019). Faithful: texture
/// and shape by the gradient of a rasteriser over several views, Adam, and the Laplacian loss of
/// displacements, see shape_roughness(). Simplified: the mean over edges instead of the sum, with a weight of
/// ours; smoothness of the texture is the objective's, not total variation; offsets are bounded, which the
/// paper leaves to its loss. Better than its source: the gradient is that of the picture, outlines included;
/// the paper takes Neural Mesh Renderer's. In photographs the car is cut off where the frame's mask ends, so
/// that it cannot grow into its surroundings, see redrawn(); its target box stays that of the unchanged car.
///
/// \throws as shape_parameter()
template <std::floating_point T>
[[nodiscard]] Method<T> mesh_adv(const raster::PaintedMesh& car);

}  // namespace tapestry::camouflage
