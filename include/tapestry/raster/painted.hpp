#pragma once
#include <tapestry/raster/texture_operator.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::raster {
/// Choices of painted(): the faces that a texture covers, and how it is kept.
struct PaintChoice {
  std::string material{};                          ///< of the painted faces; empty: all faces
  TextureKind kind = TextureKind::atlas;           ///< how texels are kept
  std::size_t rows = 64;                           ///< of an atlas; texels per edge of a cube
  TextureFilter filter = TextureFilter::bilinear;  ///< of an atlas
  image::ColourSpace space =
      image::ColourSpace::linear;  ///< space to light the mesh and lay it over photographs
};

/// Widest atlas that painted() lays out, in units of u. The uvs of a texture that repeats reach further.
inline constexpr double widest_atlas = 64;

/// Width in u of an atlas for a mesh: the largest u of the painted faces, rounded up to a whole number but
/// for a file's rounding, at least 1. \throws DomainError if it is above widest_atlas
[[nodiscard]] inline double u_extent_of(const PaintedMesh& body) {
  double extent = 1;
  const auto& mesh = body.mesh;
  for (std::size_t face = 0; face < std::min(mesh.face_uvs.size(), body.painted.size()); ++face) {
    if (body.painted[face] == 0) continue;
    for (const auto corner : mesh.face_uvs[face])
      if (corner >= 0 && static_cast<std::size_t>(corner) < mesh.uvs.size())
        extent = std::max(extent, std::ceil(mesh.uvs[static_cast<std::size_t>(corner)][0] - 1e-5));
  }
  if (extent > widest_atlas)
    throw DomainError({"painted: u of the painted faces goes up to ", extent, ", expected at most 64"});
  return extent;
}

/// A mesh with a texture over the faces of one material:
///
///   const auto car = raster::painted(io::read_obj("car.obj").mesh, {.material = "body"});
///
/// The atlas spans the painted faces' u from 0 to the next whole number, with square texels: of a car with u
/// in [0, 2) it has twice as many columns as rows. A filtered atlas comes with its pyramid.
///
/// \throws Error (mismatch) if the mesh has no material of that name
/// \throws DomainError if painted faces have u above 64
[[nodiscard]] inline PaintedMesh painted(geometry::Mesh mesh, const PaintChoice& choice = {}) {
  PaintedMesh body{std::move(mesh), {}, {}};
  if (choice.material.empty())
    body.painted.assign(body.mesh.faces.size(), 1);
  else
    body.painted = geometry::faces_by_material(body.mesh, {choice.material});
  body.space = choice.space;
  body.layout.kind = choice.kind;
  body.layout.texels_per_edge = choice.rows;
  if (!body.layout.traits().is_picture) return body;
  body.layout.u_extent = u_extent_of(body);
  body.layout.height = choice.rows;
  body.layout.width = choice.rows * static_cast<std::size_t>(body.layout.u_extent);
  body.layout.filter = choice.filter;
  if (choice.filter != TextureFilter::bilinear) body.pyramid = pyramid_of(body);
  return body;
}

/// A view's picture, a loss of it, and the gradient by the texels.
template <std::floating_point T>
struct PictureGradient {
  Array<T, 3> picture;  ///< [H, W, 3], colour times coverage
  T loss;
  Array<T, 2> gradient;  ///< ∂loss/∂texels, [texel_count, 3]
};

/// Renders a view, and differentiates a loss of the picture by the texels, on a tape of its own.
///
///   const auto found = raster::picture_and_gradient(view, texels, [](const auto& picture) { return
///   sum(picture); });
///
/// \param texels  [texel_count, 3]
/// \param loss    of an ArrayVariable<T, 3>, [H, W, 3], returns a Variable<T>
/// \throws ShapeError if texels does not fit the operator
template <std::floating_point T, class Loss>
[[nodiscard]] PictureGradient<T> picture_and_gradient(const TextureOperator<T>& view,
                                                      const Array<T, 2>& texels, const Loss& loss) {
  Tape<T> tape;
  const auto scope = tape.activate();
  const auto paint = tape.input(texels);
  const ArrayVariable<T, 3> picture = render(view, paint);
  const Variable<T> total = loss(picture);
  tape.reverse(total);
  return {picture.value(), total.value(), paint.adjoint()};
}
}  // namespace tapestry::raster
