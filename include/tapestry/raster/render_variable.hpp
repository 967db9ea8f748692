#pragma once
#include <tapestry/geometry/point_columns.hpp>
#include <tapestry/raster/detail/light_adjoint.hpp>
#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/silhouette.hpp>
#include <tapestry/raster/texture_operator.hpp>

namespace tapestry::raster {
namespace detail {
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] bool is_given(const ArrayVariable<T, Rank>& input) {
  return input.shape()[0] != 0;
}

template <std::floating_point T>
[[nodiscard]] geometry::Pose pose_of(const char* operation, const ArrayVariable<T, 1>& pose) {
  if (!is_given(pose)) return {};
  require_shape(operation, "pose", pose.value(), {6});
  const T* const p = pose.value().data();
  const auto vector = [](const T* at) {
    return geometry::Vector3{static_cast<double>(at[0]), static_cast<double>(at[1]),
                             static_cast<double>(at[2])};
  };
  const geometry::Pose result{vector(p), vector(p + 3)};
  if (!geometry::is_finite(result.rotation) || !geometry::is_finite(result.translation))
    throw DomainError({operation, ": the pose must be finite"});
  return result;
}

/// Adds derivatives by positions to an adjoint [V, 3].
template <std::floating_point T>
void add_positions(const std::vector<geometry::Vector3>& gradient, Array<T, 2>& positions_adjoint) {
  for (std::size_t i = 0; i < positions_adjoint.size(); ++i)
    positions_adjoint.data()[i] += static_cast<T>(gradient[i / 3][i % 3]);
}

/// Adds the derivative by the pose to an adjoint [6]; `moving` as in geometry::posed_adjoint().
template <std::floating_point T>
void add_pose(const geometry::Pose& pose, const geometry::Mesh& mesh,
              const std::vector<geometry::Vector3>& moving, Array<T, 1>& pose_adjoint) {
  geometry::Pose gradient;
  geometry::posed_adjoint(pose, mesh.positions, moving, gradient);
  for (std::size_t k = 0; k < 3; ++k) {
    pose_adjoint(k) += static_cast<T>(gradient.rotation[k]);
    pose_adjoint(k + 3) += static_cast<T>(gradient.translation[k]);
  }
}
}  // namespace detail

/// Inputs that a picture can be differentiated by. An input that is left out, of extent 0, is taken from
/// body, camera or light.
template <std::floating_point T>
struct RenderInputs {
  ArrayVariable<T, 2> texels{};     ///< [texel_count, 3], of a filtered atlas all levels; always given
  ArrayVariable<T, 2> positions{};  ///< [V, 3], instead of the mesh's own
  /// [6], w (radians) and t (units of the world): the body is seen at exp(w)·x + t, and its light moves with
  /// it. This equals moving the camera around a fixed world, see geometry::posed()
  ArrayVariable<T, 1> pose{};
  ArrayVariable<T, 1> light{};  ///< see light_parameters()
};

/// A picture on the tape: over(picture, coverage, background) is differentiable right through silhouettes.
template <std::floating_point T>
struct Rendering {
  ArrayVariable<T, 3> picture;   ///< [H, W, 3], lit colour times coverage
  ArrayVariable<T, 2> coverage;  ///< [H, W] in [0, 1], see silhouette()
};

namespace detail {
/// Whether a picture under this light can be differentiated by the mesh's positions.
template <LightModel Model>
inline constexpr bool has_slope = requires(const Model& light, const geometry::Mesh& mesh,
                                           const geometry::Camera& camera) {
  prepare(mesh, camera, light).slope(std::size_t{}, std::array<double, 3>{});
};

/// A view with the values of its inputs.
template <LightModel Model>
struct PosedView {
  PaintedMesh body;
  geometry::Camera camera;
  geometry::Pose pose;
  Model light;
};

template <std::floating_point T, LightModel Model>
[[nodiscard]] PosedView<Model> posed_view(const PaintedMesh& body, const geometry::Camera& camera,
                                          const Model& light, const RenderInputs<T>& inputs) {
  const auto pose = pose_of("render", inputs.pose);
  PosedView<Model> view{body, geometry::posed(camera, pose), pose, light};
  if (is_given(inputs.positions)) geometry::set_positions("render", view.body.mesh, inputs.positions.value());
  if constexpr (ParametricLight<Model>) {
    if (is_given(inputs.light)) view.light = with_parameters(light, inputs.light.value());
  } else if (is_given(inputs.light)) {
    throw DomainError("render: a light is given, but the picture's kind of light has no parameters");
  }
  if (inputs.positions.is_active() || inputs.pose.is_active()) {
    require_bilinear("render", body.layout);
    if (!has_slope<Model>) throw DomainError("render: the mesh moves, but its kind of light has no slope");
  }
  return view;
}

/// Adds the derivatives by positions and pose, where not null.
template <std::floating_point T, LightModel Model, class Gradient>
void pull_back_shape(const PosedView<Model>& view, const FragmentBands& fragments, const Array<T, 2>& texels,
                     const Array<T, 3>& adjoint, const Gradient& gradient, Array<T, 2>* positions_adjoint,
                     Array<T, 1>* pose_adjoint) {
  if (positions_adjoint == nullptr && pose_adjoint == nullptr) return;
  std::vector<geometry::Vector3> moving(view.body.mesh.positions.size(), geometry::Vector3{0, 0, 0});
  auto turning = moving;  // the light goes with the body: it turns with faces, but not with the pose
  const bool is_apart = positions_adjoint != nullptr && pose_adjoint != nullptr;
  if constexpr (has_slope<Model>)  // others do not move, see posed_view()
    add_motion(Surface<T, Model>{view.body, texels, view.light}, fragments, adjoint,
               {&moving, is_apart                       ? &turning
                         : positions_adjoint != nullptr ? &moving
                                                        : nullptr},
               gradient);
  if (pose_adjoint != nullptr) add_pose(view.pose, view.body.mesh, moving, *pose_adjoint);
  if (positions_adjoint == nullptr) return;
  for (std::size_t i = 0; is_apart && i < moving.size(); ++i)
    moving[i] = geometry::add(moving[i], turning[i]);
  add_positions(moving, *positions_adjoint);
}
}  // namespace detail

/// Draws a painted mesh on the active tape, as render_textured() does. Picture and coverage are a record
/// each, or none if they depend on passive inputs only; passive inputs are not differentiated. Positions move
/// the picture through vertex_adjoint(), and coverage through silhouette_adjoint(). Texels and light get the
/// exact derivatives of the samples that were drawn, but the sun's shadow has a fixed place: the derivative
/// by the sun's direction lacks the shadow's motion, which can be larger than the rest. Textures that are
/// drawn from unmoved cameras again and again are faster through a TextureOperator that is kept.
///
/// \param body      copied: it may change or end once this returns
/// \param light     Unlit, Light (flat), SmoothLight, OutdoorLight, or a ClearCoat over one of them; with
///                  numbers of its own or of inputs.light
/// \param gradient  BoundaryIntegral or InteriorOnly, see vertex_adjoint(); its samples_per_axis is the
///                  picture's, too
/// \throws ShapeError if an input does not fit; DomainError for a pose that is not finite, and for a
///         filtered atlas, an OutdoorLight or a ClearCoat on a mesh that moves; otherwise as
///         render_textured()
template <std::floating_point T, LightModel Model, class Gradient = BoundaryIntegral>
[[nodiscard]] Rendering<T> render(const PaintedMesh& body, const geometry::Camera& camera, std::size_t height,
                                  std::size_t width, const Model& light, const RenderInputs<T>& inputs,
                                  Gradient gradient = {}) {
  using View = detail::PosedView<Model>;
  const auto view = std::make_shared<const View>(detail::posed_view(body, camera, light, inputs));
  const bool moves = inputs.positions.is_active() || inputs.pose.is_active();
  std::optional<FragmentGrain> kept;  // for the derivatives
  if (moves) kept = detail::grain_of(body.layout);
  const auto fragments = std::make_shared<const FragmentBands>(
      "render", view->body.mesh, view->camera, height, width, gradient.samples_per_axis, kept);
  auto drawn = render_textured(view->body, *fragments, view->light, inputs.texels.value());
  std::shared_ptr<const MeshEdges> edges;  // for both records
  if constexpr (requires { gradient.edges; }) {
    if (moves) edges = gradient.edges = detail::edges_of("render", view->body.mesh, gradient.edges);
  }
  auto pullback = [view, gradient, fragments = moves ? fragments : nullptr,
                   texels = inputs.texels.shared_value()](
                      const Array<T, 3>& adjoint, Array<T, 2>* texels_adjoint, Array<T, 2>* positions_adjoint,
                      Array<T, 1>* pose_adjoint, Array<T, 1>* light_parameters_adjoint) {
    const std::size_t samples = gradient.samples_per_axis;
    if (texels_adjoint != nullptr)
      render_adjoint(texture_operator<T>(view->body, view->camera, adjoint.shape(0), adjoint.shape(1),
                                         view->light, samples),
                     adjoint, *texels_adjoint);
    if (fragments != nullptr)
      detail::pull_back_shape(*view, *fragments, *texels, adjoint, gradient, positions_adjoint, pose_adjoint);
    if constexpr (ParametricLight<Model>)
      if (light_parameters_adjoint != nullptr)
        light_adjoint(view->body, view->camera, view->light, *texels, adjoint, *light_parameters_adjoint,
                      samples);
  };
  auto picture = record_array(std::move(drawn.colour), std::move(pullback), inputs.texels, inputs.positions,
                              inputs.pose, inputs.light);
  if constexpr (std::same_as<Gradient, InteriorOnly>)  // outlines count as fixed
    return {std::move(picture), std::move(drawn.coverage)};
  else
    return {std::move(picture),
            detail::record_coverage<T>({view, &view->body.mesh}, view->camera, view->pose,
                                       std::move(drawn.coverage), inputs.positions, inputs.pose,
                                       gradient.samples_per_axis, std::move(edges))};
}
}  // namespace tapestry::raster
