#pragma once
#include <tapestry/camouflage/detail/method/method.hpp>

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
/// Source: the control "random" of the tables; no paper has it.
template <std::floating_point T>
[[nodiscard]] Method<T> random_paint(const raster::PaintedMesh& car, std::uint64_t seed) {
  Random noise = Random(seed).fork(0x6E6F697365ULL);
  Method<T> method;
  method.least = method.greatest = random_colours<T>(car.layout.texel_count(car.mesh), noise);
  method.is_optimised = false;
  return method;
}

/// One colour for the whole body, optimised from its start like every other method; another start may end in
/// another colour. The gain of a method over it is the gain of its pattern.
///
/// Source: ours; the papers at most measure single colours, like the tables' solid controls.
template <std::floating_point T>
[[nodiscard]] Method<T> solid_paint(const raster::PaintedMesh& car) {
  Method<T> method;
  method.row_of_texel =
      std::make_shared<const std::vector<std::size_t>>(car.layout.texel_count(car.mesh), std::size_t(0));
  method.row_count = 1;
  return method;
}

namespace detail {
inline bool is_inside(const std::array<double, 2>& place) {
  return std::min(place[0], place[1]) >= 0 && std::max(place[0], place[1]) <= 1;
}

/// The largest upright square within the extents of a panel, about their middle.
struct PatchSquare {
  double left = std::numeric_limits<double>::max(), right = -std::numeric_limits<double>::max();
  double bottom = std::numeric_limits<double>::max(), top = -std::numeric_limits<double>::max();

  void reach(const PanelTexel& texel) {
    left = std::min(left, texel.right);
    right = std::max(right, texel.right);
    bottom = std::min(bottom, texel.up);
    top = std::max(top, texel.up);
  }
  /// Row and column shares in [0, 1] of a place in the picture; outside them, outside the square.
  [[nodiscard]] std::array<double, 2> operator()(const PanelTexel& texel) const {
    const double side = std::min(right - left, top - bottom);
    if (!(side > 0)) return {2, 2};
    return {0.5 - (texel.up - (top + bottom) / 2) / side, 0.5 + (texel.right - (left + right) / 2) / side};
  }
};
}  // namespace detail

/// One square picture on roof, hood and doors, upright and readable on each, as large as the panel allows;
/// the rest of the car keeps its own colours. The picture has about as many pixels as its largest copy has
/// texels.
///
/// Source: the patches of Thys et al., "Fooling automated surveillance cameras" (CVPR workshops 2019),
/// section 3, pasted on a car as the camouflage papers compare with them. Faithful: one picture for all
/// places. Seen by a camera the panel's picture is its homography as far as the panel is flat. Simplified:
/// smoothness and printability are the objective's.
///
/// \throws as panel_texels(); Error (mismatch) if no panel holds a square of texels
template <std::floating_point T>
[[nodiscard]] Method<T> planar_patch(const raster::PaintedMesh& car) {
  const auto texels = panel_texels("planar_patch", car);
  std::array<detail::PatchSquare, panel_count> squares{};
  for (const PanelTexel& texel : texels) squares[static_cast<std::size_t>(texel.panel)].reach(texel);
  const auto place_of = [&](const PanelTexel& texel) {
    return squares[static_cast<std::size_t>(texel.panel)](texel);
  };
  std::array<std::size_t, panel_count> sizes{};
  for (const PanelTexel& texel : texels)
    if (detail::is_inside(place_of(texel))) ++sizes[static_cast<std::size_t>(texel.panel)];
  const auto largest = static_cast<double>(*std::max_element(sizes.begin(), sizes.end()));
  if (largest == 0)
    throw Error(
        ErrorKind::mismatch,
        "the method planar_patch needs a panel of more than a line of texels; the atlas is too small");
  const auto edge = static_cast<std::size_t>(std::sqrt(largest));

  std::vector<std::size_t> rows(car.layout.texel_count(car.mesh), Method<T>::unpainted);
  const auto pixel = [&](double share) {
    return std::min(static_cast<std::size_t>(share * static_cast<double>(edge)), edge - 1);
  };
  for (const PanelTexel& texel : texels)
    if (const auto place = place_of(texel); detail::is_inside(place))
      rows[texel.texel] = pixel(place[0]) * edge + pixel(place[1]);
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(std::move(rows));
  method.row_count = edge * edge;
  method.elsewhere = own_colours<T>(car);
  return method;
}

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
[[nodiscard]] Method<T> camou(const raster::PaintedMesh& car) {
  require_atlas("camou", car);
  constexpr std::size_t edge = camou_pattern_edge;
  const std::size_t height = car.layout.height, width = car.layout.width;
  const std::size_t texels_a_colour = (height + 4 * edge - 1) / (4 * edge);
  std::vector<std::size_t> rows(height * width);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      rows[y * width + x] = y / texels_a_colour % edge * edge + x / texels_a_colour % edge;
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(std::move(rows));
  method.row_count = edge * edge;
  return method;
}

namespace detail {
/// Noise between the points of a lattice, in [0, 1): smooth, and the same at the same place.
[[nodiscard]] inline double lattice_noise(const std::array<double, 3>& x, const Random& random) {
  std::array<double, 3> share{}, base{};
  for (std::size_t k = 0; k < 3; ++k) {
    base[k] = std::floor(x[k]);
    const double t = x[k] - base[k];
    share[k] = t * t * (3 - 2 * t);
  }
  double sum = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double weight = 1;
    Random at = random;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t ahead = corner >> k & 1U;
      weight *= ahead == 1 ? share[k] : 1 - share[k];
      at = at.fork(
          static_cast<std::uint64_t>(static_cast<std::int64_t>(base[k]) + static_cast<std::int64_t>(ahead)));
    }
    sum += weight * at.uniform();
  }
  return sum;
}

/// Foliage, roughly: five octaves of noise whose amplitude falls as 1/f, as in natural pictures, between dark
/// green and straw.
[[nodiscard]] inline std::array<double, 3> foliage(const std::array<double, 3>& x, const Random& random) {
  double height = 0, total = 0;
  for (std::uint64_t octave = 0; octave < 5; ++octave) {
    const double frequency = std::ldexp(4.0, static_cast<int>(octave)), amplitude = 1 / frequency;
    height += amplitude *
              lattice_noise({frequency * x[0], frequency * x[1], frequency * x[2]}, random.fork(octave));
    total += amplitude;
  }
  const double share = std::clamp(2 * height / total - 0.5, 0.0, 1.0);  // noise seldom leaves its middle
  constexpr std::array<double, 3> dark{0.12, 0.2, 0.1}, straw{0.6, 0.55, 0.36};
  std::array<double, 3> colour{};
  for (std::size_t c = 0; c < 3; ++c) colour[c] = (1 - share) * dark[c] + share * straw[c];
  return colour;
}
}  // namespace detail

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
[[nodiscard]] Method<T> upc(const raster::PaintedMesh& car, std::uint64_t seed) {
  const auto texels = panel_texels("upc", car);
  Method<T> method = paint_panels<T>(car, texels);
  method.least = method.greatest = Array<T, 2>(Extents<2>{texels.size(), 3});
  const Random random = Random(seed).fork(0x666F6C69616765ULL);
  for (std::size_t row = 0; row < texels.size(); ++row) {
    const auto picture = detail::foliage(texels[row].position, random);
    for (std::size_t c = 0; c < 3; ++c) {
      method.least(row, c) = static_cast<T>(std::max(0.0, picture[c] - upc_bound));
      method.greatest(row, c) = static_cast<T>(std::min(1.0, picture[c] + upc_bound));
    }
  }
  return method;
}

/// The whole body, each texel for itself, to scatter the detector's attention: minimises loss::attention() of
/// a heat map, and smoothness as always, instead of an adversarial loss.
///
/// Source: Wang et al., "Dual Attention Suppression Attack: Generate Adversarial Camouflage in Physical
/// World" (CVPR 2021), eq. 4 and 5, on the faces that FCA (AAAI 2022) compares with as DAS-full. Faithful:
/// the loss, with score and layer as constants, as in its published program. Simplified: the map is the
/// LayerCAM of the attacked detector's most confident candidate, over the last layer that all its heads
/// depend on. The Grad-CAM of a classifier is not used, since it shows next to nothing of a detector's score.
/// The second term is left out: closeness to the edges of a content picture, which is for human eyes.
///
/// The loss is small, about 0.005 against YOLOX-nano; the smoothness term is 0.01 to 0.04 at its usual
/// weight. So the optimisation smooths the paint, and the car is found as often as without it. DAS has no
/// such term; give it the weight 0.
template <std::floating_point T>
[[nodiscard]] Method<T> das_full() {
  Method<T> method;
  method.attention = 1;
  return method;
}

/// The same on roof, hood and doors only, which DAS selects by hand (309 faces of its car); the rest of the
/// car keeps its own colours.
/// \throws as panel_texels()
template <std::floating_point T>
[[nodiscard]] Method<T> das(const raster::PaintedMesh& car) {
  Method<T> method = paint_panels<T>(car, panel_texels("das", car));
  method.attention = das_full<T>().attention;
  return method;
}

/// Texture and shape: the whole painted body, each texel for itself, and an offset of every position of the
/// car, painted or not, of at most a hundredth of its length along each axis. Both start and step together.
///
/// Source: Xiao et al., "MeshAdv: Adversarial Meshes for Visual Recognition" (CVPR 2019). Faithful: texture
/// and shape by the gradient of a rasteriser over several views, Adam, and the Laplacian loss of
/// displacements, see shape_roughness(). Simplified: the mean over edges instead of the sum, with a weight of
/// ours; smoothness of the texture is the objective's, not total variation; offsets are bounded, which the
/// paper leaves to its loss. Better than its source: the gradient is the picture's, with outlines; the paper
/// takes Neural Mesh Renderer's. In photographs the car is cut off where the frame's mask ends, so that it
/// cannot grow into its surroundings, see redrawn(); its target box stays the unchanged car's.
///
/// \throws as shape_parameter()
template <std::floating_point T>
[[nodiscard]] Method<T> mesh_adv(const raster::PaintedMesh& car) {
  Method<T> method;
  method.shape = std::make_shared<const ShapeParameter>(shape_parameter(car));
  return method;
}
}  // namespace tapestry::camouflage
