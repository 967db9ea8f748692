#pragma once
#include <tapestry/raster/detail/fragment_shader.hpp>
#include <tapestry/raster/detail/light_adjoint/light_sums.hpp>

namespace tapestry::raster {
/// The numbers of a light as an array, [8]: ambient, directional, direction x, y, z, colour r, g, b.
template <std::floating_point T>
[[nodiscard]] Array<T, 1> light_parameters(const Light& light) {
  const auto& [x, y, z] = light.direction;
  const auto& [red, green, blue] = light.colour;
  Array<T, 1> parameters(Extents<1>{8});
  const std::array<double, 8> values{light.ambient, light.directional, x, y, z, red, green, blue};
  for (std::size_t i = 0; i < 8; ++i) parameters(i) = static_cast<T>(values[i]);
  return parameters;
}

/// A light, flat or smooth, with the numbers that light_parameters() lists.
/// \throws ShapeError unless there are eight
template <std::derived_from<Light> Model = Light, std::floating_point T>
[[nodiscard]] Model light_of(const Array<T, 1>& parameters) {
  require_shape("light_of", "parameters", parameters, {8});
  std::array<double, 8> p{};
  for (std::size_t i = 0; i < 8; ++i) p[i] = static_cast<double>(parameters(i));
  Model light;
  light.ambient = p[0];
  light.directional = p[1];
  light.direction = {p[2], p[3], p[4]};
  light.colour = {p[5], p[6], p[7]};
  return light;
}

/// The numbers of a light of sun and sky as an array, [16]: sun, direction x, y, z, colour r, g, b, and the
/// nine coefficients of the sky.
template <std::floating_point T>
[[nodiscard]] Array<T, 1> light_parameters(const OutdoorLight& light) {
  Array<T, 1> parameters(Extents<1>{16});
  parameters(0) = static_cast<T>(light.sun);
  for (std::size_t i = 0; i < 3; ++i) {
    parameters(1 + i) = static_cast<T>(light.direction[i]);
    parameters(4 + i) = static_cast<T>(light.colour[i]);
  }
  for (std::size_t i = 0; i < 9; ++i) parameters(7 + i) = static_cast<T>(light.sky[i]);
  return parameters;
}

/// A light, flat or smooth, with other numbers, in the order of light_parameters().
/// \throws ShapeError unless there are eight
template <std::derived_from<Light> Model, std::floating_point T>
[[nodiscard]] Model with_parameters(const Model&, const Array<T, 1>& parameters) {
  return light_of<Model>(parameters);
}

/// A light of sun and sky with other numbers; occlusion and shadow stay unchanged.
/// \throws ShapeError unless there are sixteen
template <std::floating_point T>
[[nodiscard]] OutdoorLight with_parameters(OutdoorLight light, const Array<T, 1>& parameters) {
  require_shape("with_parameters", "parameters", parameters, {16});
  const auto at = [&](std::size_t i) { return static_cast<double>(parameters(i)); };
  light.sun = at(0);
  light.direction = {at(1), at(2), at(3)};
  light.colour = {at(4), at(5), at(6)};
  for (std::size_t i = 0; i < 9; ++i) light.sky[i] = at(7 + i);
  return light;
}

/// The numbers of a light with a clear coat as an array: the light's, then coat and roughness.
template <std::floating_point T, class Base>
[[nodiscard]] Array<T, 1> light_parameters(const ClearCoat<Base>& light) {
  const auto base = light_parameters<T>(static_cast<const Base&>(light));
  Array<T, 1> parameters(Extents<1>{base.size() + 2});
  std::copy(base.begin(), base.end(), parameters.begin());
  parameters(base.size()) = static_cast<T>(light.coat);
  parameters(base.size() + 1) = static_cast<T>(light.roughness);
  return parameters;
}

/// A light with a clear coat with other numbers, in the order of light_parameters().
/// \throws ShapeError unless there are as many
template <class Base, std::floating_point T>
[[nodiscard]] ClearCoat<Base> with_parameters(const ClearCoat<Base>& light, const Array<T, 1>& parameters) {
  const auto own = light_parameters<T>(light);
  require_shape("with_parameters", "parameters", parameters, own.shape());
  Array<T, 1> base(Extents<1>{own.size() - 2});
  std::copy_n(parameters.begin(), base.size(), base.begin());
  return {with_parameters(static_cast<const Base&>(light), base),
          static_cast<double>(parameters(base.size())), static_cast<double>(parameters(base.size() + 1))};
}

/// A light with numbers that a picture can be differentiated by: Light, SmoothLight, OutdoorLight, and each
/// of them with a ClearCoat.
template <class Model>
concept ParametricLight = requires(const Model& light, const Array<double, 1>& parameters) {
  { with_parameters(light, parameters) } -> std::same_as<Model>;
};

namespace detail {
/// Colour of a fragment before the light.
template <std::floating_point T, class Lighting>
[[nodiscard]] std::array<double, 3> unlit_colour(const FragmentShader<Lighting>& shader,
                                                 const Array<T, 2>& texels, const Fragment& fragment) {
  if (shader.body.painted[static_cast<std::size_t>(fragment.face)] == 0) return shader.own_colour(fragment);
  std::array<double, 3> colour{0, 0, 0};
  shader.visit_taps(fragment, [&](const Tap& tap) {
    for (std::size_t c = 0; c < 3; ++c) colour[c] += tap.weight * static_cast<double>(texels(tap.texel, c));
  });
  return colour;
}
}  // namespace detail

/// Adds ∂L/∂light to light_adjoint, L being a function of the picture of render(): exact for that picture,
/// since it visits the same fragments. Let s = ⟨adjoint, coverage · light.colour · colour⟩ for a fragment
/// with the normal n. Then ambient receives s, directional receives s · max(0, n·L), and L receives s ·
/// directional · n where n·L > 0, which is passed on through L = direction/|direction|. The sun of an
/// OutdoorLight and its direction receive this times the visible share V of the sun, with the shadow's place
/// held still; its sky receives s · A · sky_transfer(n) where that is lit. A ClearCoat adds the mirrored part
/// to all of them. Sums are in double, the same for any number of threads.
///
/// \param light          Light (flat), SmoothLight or OutdoorLight, or one of them with a ClearCoat
/// \param texels         [texel_count, 3]; for a filtered atlas its pyramid
/// \param render_adjoint ∂L/∂picture, [H, W, 3]
/// \param light_adjoint  as light_parameters()
/// \throws ShapeError if an array does not fit; otherwise as texture_operator()
template <std::floating_point T, ParametricLight Model>
void light_adjoint(const PaintedMesh& body, const geometry::Camera& camera, const Model& light,
                   const Array<T, 2>& texels, const Array<T, 3>& render_adjoint, Array<T, 1>& light_adjoint,
                   std::size_t samples_per_axis = 2) {
  const std::size_t height = render_adjoint.shape(0), width = render_adjoint.shape(1);
  detail::require_layout("light_adjoint", body);
  require_shape("light_adjoint", "render_adjoint", render_adjoint, {height, width, 3});
  require_shape("light_adjoint", "texels", texels, {stored_texel_count(body.layout, body.mesh), 3});
  require_shape("light_adjoint", "light_adjoint", light_adjoint, light_parameters<T>(light).shape());
  const FragmentBands fragments("light_adjoint", body.mesh, camera, height, width, samples_per_axis);
  const auto lighting = prepare(body.mesh, camera, light);
  const auto shader = detail::make_shader(body, lighting, fragments, camera, height, width);
  const geometry::Vector3 eye = geometry::eye_of(camera);
  auto sum = detail::no_sums(light);
  std::vector<decltype(sum)> bands(fragments.band_count());
  parallel_for(bands.size(), [&](std::size_t index) {
    fragments.visit_band(index, detail::grain_of(body.layout), [&](const Fragment& fragment) {
      const T* const adjoint = render_adjoint.data() + 3 * fragment.pixel;
      std::array<double, 3> covered, seen = detail::unlit_colour(shader, texels, fragment);
      for (std::size_t c = 0; c < 3; ++c) {
        covered[c] = fragment.coverage * static_cast<double>(adjoint[c]);
        seen[c] *= covered[c];
      }
      detail::add_fragment(light, lighting, body.mesh, eye, fragment, shader.light_of(fragment), covered,
                           seen, bands[index]);
    });
  });
  for (const auto& band : bands) sum.add(band);
  const auto parameters = light_parameters<T>(sum.adjoint(light));
  for (std::size_t i = 0; i < parameters.size(); ++i) light_adjoint(i) += parameters(i);
}
}  // namespace tapestry::raster
