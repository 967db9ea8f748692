#pragma once
#include <tapestry/camouflage/view.hpp>
#include <tapestry/loss/mesh_regularity.hpp>
#include <tapestry/raster/render_variable.hpp>

namespace tapestry::camouflage {
/// The shape of a car as a parameter p, a row for each of its V positions: position v moves by
///
///   reach · longest extent of the car · tanh p[w(v)],
///
/// with w(v) the first position at the same place, so that seams stay closed. p = 0 is the unchanged car.
struct ShapeParameter {
  raster::PaintedMesh car;                         ///< the original car
  std::shared_ptr<const raster::MeshEdges> edges;  ///< edges of the car
  geometry::MeshTopology topology;                 ///< topology, with positions at one place as one
  double reach = 0.01;                             ///< greatest offset along an axis, in longest extents
  double stiffness = 1;                            ///< weight of shape_roughness()

  [[nodiscard]] std::size_t row_count() const { return car.mesh.positions.size(); }
};

/// \throws DomainError for a filtered atlas, through which no picture can be differentiated by positions;
///         Error (mismatch) if a face refers to a missing position
[[nodiscard]] ShapeParameter shape_parameter(const raster::PaintedMesh& car);

/// Steps of the positions on the tape, in shares of the reach: d = tanh p[w(v)], [V, 3], each in [−1, 1].
///
/// \param parameter  [row, 3], whose last V rows are p
/// \throws ShapeError if there are not as many
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> shape_steps(const ShapeParameter& shape,
                                              const ArrayVariable<T, 2>& parameter);

/// Unevenness of the shape's motion: 1/E · Σ |d_a − d_b|² over edges, 0 where all of it moves alike. It is
/// the quadratic form of the mesh's Laplacian.
/// Source: Xiao et al., "MeshAdv" (CVPR 2019), the Laplacian loss of displacements, there a sum.
/// \param shape  must outlive the tape's last reverse()
/// \param steps  d, see shape_steps()
template <std::floating_point T>
[[nodiscard]] Variable<T> shape_roughness(const ShapeParameter& shape, const ArrayVariable<T, 2>& steps) {
  return loss::edge_length(shape.topology, steps);
}

/// The moved positions on the tape, [V, 3].
/// \param steps  see shape_steps()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> shape_positions(const ShapeParameter& shape,
                                                  const ArrayVariable<T, 2>& steps);

/// The offsets of a parameter, [V, 3], in longest extents of the car, whatever its units.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> shape_offsets(const ShapeParameter& shape, const Array<T, 2>& parameter);

/// The car in another shape. Normals stay the original car's.
/// \param offsets  see shape_offsets()
/// \throws ShapeError unless each position has one
template <std::floating_point T>
[[nodiscard]] raster::PaintedMesh reshaped(raster::PaintedMesh car, const Array<T, 2>& offsets);

/// A view whose car has another shape, on the tape.
template <std::floating_point T>
struct RedrawnView {
  ArrayVariable<T, 3> render;                   ///< m·O, [H, W, 3], multiplied by its coverage m·c
  ArrayVariable<T, 3> picture;                  ///< I_adv, [H, W, 3], see picture_of()
  std::shared_ptr<const Array<T, 2>> interior;  ///< as View::interior, of the whole picture; a constant
};

/// Draws a view anew, differentiable by texels and positions, right through silhouettes. The mask stays the
/// frame's: it cuts the car off where the car grows beyond it; where the car shrinks, the frame shows.
///
/// \param texels     [texel, 3], in the view's colour space
/// \param positions  [V, 3]
/// \throws DomainError if the view does not keep its Sight, see sight_of(); else as raster::render()
template <std::floating_point T>
[[nodiscard]] RedrawnView<T> redrawn(const View<T>& view, const ShapeParameter& shape,
                                     const ArrayVariable<T, 2>& texels, const ArrayVariable<T, 2>& positions);
}  // namespace tapestry::camouflage
