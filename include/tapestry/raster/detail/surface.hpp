#pragma once
#include <tapestry/raster/detail/fragment_shader.hpp>
#include <tapestry/raster/detail/texture_kinds.hpp>
#include <tapestry/raster/faces_in_view.hpp>

namespace tapestry::raster {
/// Appearance of a mesh's faces: paint, material and light. Refers to its parts, which must outlive it.
template <std::floating_point T, LightModel Model = Light>
struct Surface {
  const PaintedMesh& body;
  const Array<T, 2>& texels;  ///< [texel_count, 3]
  const Model& light;
};

/// A surface's colour at a point of a face, and its derivative by the place of the point on the face; the
/// same function that texture_operator() samples.
template <std::floating_point T, class Lighting>
class SurfaceColour {
 public:
  using Colour = std::array<double, 3>;

  SurfaceColour(const PaintedMesh& body, const Array<T, 2>& texels, Lighting lighting)
      : mesh_(body.mesh),
        painted_(body.painted),
        layout_(body.layout),
        pictures_(body.pictures.get()),
        own_colours_(body),
        texels_(texels),
        lighting_(std::move(lighting)) {}

  /// Lit colour at barycentric coordinates b, all of them ≥ 0.
  [[nodiscard]] Colour at(std::int32_t face, const std::array<double, 3>& b) const {
    const auto index = static_cast<std::size_t>(face);
    Colour colour = unlit(index, b);
    const double light = lighting_.at(index, b);
    for (std::size_t c = 0; c < 3; ++c) colour[c] *= light * lighting_.light_colour[c];
    return colour;
  }

  /// Whether any two faces agree along an edge whose ends they share; false if unknown.
  [[nodiscard]] bool is_continuous() const {
    return std::same_as<Lighting, PreparedUnlit> && layout_.traits().is_interpolated &&
           std::find(painted_.begin(), painted_.end(), 0) == painted_.end();
  }

  /// Whether two faces that share an edge are known to have the same colours along it, without computing
  /// them: they have the same corners there, the same uv in an atlas, and the same light.
  [[nodiscard]] bool agrees(const HalfEdge& a, const HalfEdge& b) const {
    const auto face_a = static_cast<std::size_t>(a.face), face_b = static_cast<std::size_t>(b.face);
    if (!lighting_.agrees(face_a, face_b) || painted_[face_a] != painted_[face_b]) return false;
    const MeshPicture* const picture = picture_of(face_a);
    if (picture != picture_of(face_b)) return false;
    if (painted_[face_a] == 0 && !picture) return own_colours_[face_a] == own_colours_[face_b];
    const TextureTraits& traits = picture ? picture->layout.traits() : layout_.traits();
    if (traits.is_one_colour) return true;
    if (traits.is_by_face) return false;
    const auto end = [&](std::size_t face, std::int32_t corner) {
      return static_cast<std::size_t>(mesh_.faces[face][static_cast<std::size_t>(corner % 3)]);
    };
    const bool runs_alike = end(face_a, a.corner) == end(face_b, b.corner);
    for (std::int32_t step = 0; step < 2; ++step) {
      const std::int32_t corner_a = a.corner + step, corner_b = b.corner + (runs_alike ? step : 1 - step);
      if (end(face_a, corner_a) != end(face_b, corner_b)) return false;
      if (traits.is_picture && corner_uv(face_a, static_cast<std::size_t>(corner_a % 3)) !=
                                   corner_uv(face_b, static_cast<std::size_t>(corner_b % 3)))
        return false;
    }
    return true;
  }

  /// Colour before the light, times the light's colour: the light's factor multiplies it.
  [[nodiscard]] Colour tinted(std::int32_t face, const std::array<double, 3>& b) const {
    Colour colour = unlit(static_cast<std::size_t>(face), b);
    for (std::size_t c = 0; c < 3; ++c) colour[c] *= lighting_.light_colour[c];
    return colour;
  }

  /// ∂colour/∂b, [channel][k].
  [[nodiscard]] ColourSlope<3> slope(std::int32_t face, const std::array<double, 3>& b) const {
    const auto index = static_cast<std::size_t>(face);
    ColourSlope<3> slope = unlit_slope(index, b);
    const double light = lighting_.at(index, b);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 3; ++k) slope[c][k] *= lighting_.light_colour[c] * light;
    const std::array<double, 3> light_slope = lighting_.slope(index, b);
    if (light_slope == std::array<double, 3>{0, 0, 0}) return slope;
    const Colour colour = unlit(index, b);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 3; ++k)
        slope[c][k] += lighting_.light_colour[c] * light_slope[k] * colour[c];
    return slope;
  }

  /// Whether slope() is known to be the same all over a face.
  [[nodiscard]] bool has_constant_slope(std::int32_t face) const {
    constexpr bool is_even = std::same_as<Lighting, PreparedUnlit> || std::same_as<Lighting, PreparedLight>;
    return is_even && layout_.traits().is_interpolated && painted_[static_cast<std::size_t>(face)] != 0;
  }

  /// Σ_c weight_c · ∂colour_c/∂b.
  [[nodiscard]] std::array<double, 3> slope_adjoint(std::int32_t face, const std::array<double, 3>& b,
                                                    const std::array<double, 3>& weight) const {
    std::array<double, 3> sum{};
    const ColourSlope<3> slope = this->slope(face, b);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 3; ++k) sum[k] += weight[c] * slope[c][k];
    return sum;
  }

 private:
  /// The picture that an unpainted face shows, or null.
  [[nodiscard]] const MeshPicture* picture_of(std::size_t face) const {
    return pictures_ && painted_[face] == 0 ? pictures_->at(face) : nullptr;
  }

  [[nodiscard]] std::array<double, 2> corner_uv(std::size_t face, std::size_t k) const {
    return mesh_.uvs[static_cast<std::size_t>(mesh_.face_uvs[face][k])];
  }

  [[nodiscard]] Colour unlit(std::size_t face, const std::array<double, 3>& b) const {
    Colour colour{0, 0, 0};
    const auto look_up = [&](const TextureLayout& layout, const auto& texels) {
      visit_taps(layout, mesh_, face, b, [&](const Tap& tap) {
        for (std::size_t c = 0; c < 3; ++c)
          colour[c] += tap.weight * static_cast<double>(texels(tap.texel, c));
      });
    };
    if (const MeshPicture* const picture = picture_of(face)) {
      look_up(picture->layout, picture->texels);
    } else if (painted_[face] != 0) {
      look_up(layout_, texels_);
    } else {
      const auto material = own_colours_[face];
      for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<double>(material[c]);
    }
    return colour;
  }

  [[nodiscard]] ColourSlope<3> unlit_slope(std::size_t face, const std::array<double, 3>& b) const {
    if (const MeshPicture* const picture = picture_of(face))
      return texture_slope(picture->layout, mesh_, picture->texels, face, b);
    return painted_[face] != 0 ? texture_slope(layout_, mesh_, texels_, face, b) : ColourSlope<3>{};
  }

  const geometry::Mesh& mesh_;
  const std::vector<std::uint8_t>& painted_;
  const TextureLayout& layout_;
  const MeshPictures* pictures_;
  OwnColours own_colours_;
  const Array<T, 2>& texels_;
  Lighting lighting_;
};

namespace detail {
/// \throws DomainError for a filtered atlas, whose levels depend on where the corners are
inline void require_bilinear(const char* operation, const TextureLayout& layout) {
  if (is_filtered(layout))
    throw DomainError({operation, ": expected a bilinear atlas, found a filtered one"});
}
}  // namespace detail

/// The colours of a surface in one view. Errors name `operation`.
/// \throws as texture_operator(); DomainError for a filtered atlas; ShapeError if texels does not fit the
/// layout
template <std::floating_point T, class Model>
[[nodiscard]] auto surface_colour(const char* operation, const Surface<T, Model>& surface,
                                  const geometry::Camera& camera) {
  const auto& [mesh, painted, layout, space, pyramid, pictures] = surface.body;
  detail::require_layout(operation, surface.body);
  detail::require_bilinear(operation, layout);
  if (pictures)
    for (const MeshPicture& picture : pictures->pictures) detail::require_bilinear(operation, picture.layout);
  require_corners(operation, mesh);
  require_shape(operation, "texels", surface.texels, {layout.texel_count(mesh), 3});
  auto lighting = prepare(mesh, camera, surface.light);
  return SurfaceColour<T, decltype(lighting)>(surface.body, surface.texels, std::move(lighting));
}
}  // namespace tapestry::raster
