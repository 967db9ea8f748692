#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/raster/faces_in_view.hpp>

/// Deferred shading: a picture in four steps, each with its adjoint. Between them a user adds own
/// formulas of shading on the tape.
///
///   rasterise    mesh, camera -> face and barycentric coordinates b at the centre of each pixel
///   interpolate  b, attributes of corners -> attributes of pixels, such as uv, normal or position
///   look_up      texture, uv -> colours
///   antialias    colours -> picture, in which neighbours blend where an outline passes between them
///
/// Positions move a picture within faces through b, and its outlines through antialias(). Source: Laine et
/// al., "Modular Primitives for High-Performance Differentiable Rendering" (SIGGRAPH Asia 2020). Deviation:
/// finds an outline's crossing on view rays instead of in clip space; this needs no near plane. One sample a
/// pixel: render() counts coverage by several, and integrates along outlines between pixels, too.
namespace tapestry::raster {
/// Faces at the centres of a picture's pixels.
struct PixelFaces {
  std::shared_ptr<const geometry::Mesh> mesh;
  geometry::Camera camera{};
  std::size_t height = 0;
  std::size_t width = 0;
  std::vector<std::int32_t> face{};  ///< [H · W], -1 where none shows
  /// mesh_edges() of the mesh, valid as long as its faces do not change.
  std::shared_ptr<const MeshEdges> edges{};
};

/// \param edges  mesh_edges() of the mesh, when they are kept from view to view; null: found now
/// \throws as visibility(); ShapeError if edges are of another mesh
[[nodiscard]] PixelFaces pixel_faces(std::shared_ptr<const geometry::Mesh> mesh,
                                     const geometry::Camera& camera, std::size_t height, std::size_t width,
                                     std::shared_ptr<const MeshEdges> edges = nullptr);

/// Perspective-correct barycentric coordinates of the surface at the centres of pixels. With q_k the face's
/// corners in view space and d the pixel's ray,
///
///   b_k = c_k / (c_0 + c_1 + c_2),   c_k = d · (q_{k+1} × q_{k+2}),
///
/// which may lie a 256th of a pixel outside of the face, as far as the rasteriser moves corners.
///
/// \returns  [H, W, 3], 0 where no face shows
template <std::floating_point T>
[[nodiscard]] Array<T, 3> barycentrics(const PixelFaces& pixels);

/// Adds ∂L/∂positions, with constant faces of pixels, to positions_adjoint, one entry a position.
/// \param adjoint  ∂L/∂b, [H, W, 3]
/// \throws ShapeError if an argument does not fit
template <std::floating_point T>
void barycentrics_adjoint(const PixelFaces& pixels, const Array<T, 3>& adjoint,
                          std::vector<geometry::Vector3>& positions_adjoint);

/// Attributes of pixels, Σ b_k · attributes[corners[face][k]]; 0 where no face shows.
///
/// \param barycentric  b, [H, W, 3]
/// \param attributes   [A, C]
/// \param corners      an entry a face: mesh.faces for attributes of positions, mesh.face_uvs for uvs
/// \returns            [H, W, C]
/// \throws ShapeError if arrays do not fit; Error (mismatch) if a corner has no attribute
template <std::floating_point T>
[[nodiscard]] Array<T, 3> interpolate(const PixelFaces& pixels, const Array<T, 3>& barycentric,
                                      const Array<T, 2>& attributes,
                                      const std::vector<geometry::Corners>& corners);

/// Adds the derivatives of interpolate(); a null pointer stands for an argument that needs none.
/// \param out_adjoint  [H, W, C]
template <std::floating_point T>
void interpolate_adjoint(const PixelFaces& pixels, const Array<T, 3>& barycentric,
                         const Array<T, 2>& attributes, const std::vector<geometry::Corners>& corners,
                         const Array<T, 3>& out_adjoint, Array<T, 3>* barycentric_adjoint,
                         Array<T, 2>* attributes_adjoint);

/// Bilinear lookup in a texture, by the rule of visit_atlas_taps() with u_extent 1: v = 1 on top, uv outside
/// of [0, 1] repeats, the outer half texel is flat.
///
/// \param texture  [h, w, C]
/// \param uv       [H, W, 2]
/// \returns        [H, W, C]
/// \throws ShapeError if the texture has no texel or uv not two channels
template <std::floating_point T>
[[nodiscard]] Array<T, 3> look_up(const Array<T, 3>& texture, const Array<T, 3>& uv);

/// Adds the derivatives of look_up(); a null pointer stands for an argument that needs none. On a texel's
/// centre, where the slope by uv jumps, the side of the greater index counts.
/// \param out_adjoint  [H, W, C]
template <std::floating_point T>
void look_up_adjoint(const Array<T, 3>& texture, const Array<T, 3>& uv, const Array<T, 3>& out_adjoint,
                     Array<T, 3>* texture_adjoint, Array<T, 3>* uv_adjoint);

/// Blends pixels beside each other across outlines. Between the centres of pixels a and b that show different
/// faces, let an edge of the nearer face, with all its faces on one side, cross at the share s of the way:
///
///   s > ½: out[b] += (s − ½) · (colour[a] − colour[b]),   s < ½: out[a] += (½ − s) · (colour[b] −
///   colour[a]).
///
/// Exact for straight outlines along rows or columns. Pairs are summed in order: the same bits for any number
/// of threads.
///
/// \param colour  [H, W, C], with a background where no face shows
/// \throws ShapeError if colour does not fit
template <std::floating_point T>
[[nodiscard]] Array<T, 3> antialias(const PixelFaces& pixels, const Array<T, 3>& colour);

/// Adds the derivatives of antialias(): by colours, and by positions through the places where edges cross;
/// null for one that is not needed. \param positions_adjoint  one entry a position
template <std::floating_point T>
void antialias_adjoint(const PixelFaces& pixels, const Array<T, 3>& colour, const Array<T, 3>& out_adjoint,
                       Array<T, 3>* colour_adjoint, std::vector<geometry::Vector3>* positions_adjoint);

/// A rasterised mesh on the tape.
template <std::floating_point T>
struct Rasterised {
  std::shared_ptr<const PixelFaces> pixels;
  ArrayVariable<T, 3> barycentric;  ///< [H, W, 3]
  ArrayVariable<T, 2> positions;    ///< [V, 3]; of extent 0: the mesh's own
};

/// pixel_faces() and barycentrics() on the tape, by positions.
///
/// \param mesh       copied
/// \param positions  [V, 3], instead of the mesh's own; of extent 0: the mesh's own
/// \throws ShapeError if positions do not fit; otherwise as pixel_faces()
template <std::floating_point T>
[[nodiscard]] Rasterised<T> rasterise(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                      std::size_t height, std::size_t width,
                                      const ArrayVariable<T, 2>& positions = {},
                                      std::shared_ptr<const MeshEdges> edges = nullptr);

/// interpolate() on the tape. Values of 1 give 1 on the mesh and 0 beside it.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> interpolate(const Rasterised<T>& rasterised,
                                              const std::type_identity_t<ArrayVariable<T, 2>>& attributes,
                                              const std::vector<geometry::Corners>& corners);

/// interpolate() of attributes of positions, [V, C].
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> interpolate(const Rasterised<T>& rasterised,
                                              const std::type_identity_t<ArrayVariable<T, 2>>& attributes) {
  return interpolate(rasterised, attributes, rasterised.pixels->mesh->faces);
}

/// interpolate() of the mesh's uvs, [H, W, 2].
/// \throws ShapeError if the mesh has no uvs; Error (mismatch) if a face that shows has none
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> texture_coordinates(const Rasterised<T>& rasterised);

/// look_up() on the tape.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> look_up(const std::type_identity_t<ArrayVariable<T, 3>>& texture,
                                          const ArrayVariable<T, 3>& uv);

/// antialias() on the tape, by colours and positions.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> antialias(const Rasterised<T>& rasterised,
                                            const std::type_identity_t<ArrayVariable<T, 3>>& colour);
}  // namespace tapestry::raster
