#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/fragment_shader.hpp>
#include <tapestry/raster/fragments.hpp>
#include <tapestry/raster/light_adjoint/coat_sums.hpp>
#include <tapestry/raster/light_adjoint/light_parameters.hpp>
#include <tapestry/raster/light_adjoint/light_sums.hpp>
#include <tapestry/raster/lighting.hpp>
#include <vector>

namespace tapestry::raster {

namespace detail {
/// Colour of a fragment before the light.
template <std::floating_point T, class Lighting>
[[nodiscard]] std::array<double, 3> unlit_colour(const FragmentShader<Lighting>& shader,
                                                 const Array<T, 2>& texels, const Fragment& fragment) {
  std::array<double, 3> colour{0, 0, 0};
  const auto face = static_cast<std::size_t>(fragment.face);
  if (shader.body.painted[face] == 0) {
    const auto material = shader.own_colours[face];
    for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<double>(material[c]);
    return colour;
  }
  shader.visit_taps(fragment, [&](const Tap& tap) {
    for (std::size_t c = 0; c < 3; ++c) colour[c] += tap.weight * static_cast<double>(texels(tap.texel, c));
  });
  return colour;
}
}  // namespace detail

/// Adds ∂L/∂light to light_adjoint, L being a function of the picture that render() makes: exact for that
/// picture, since it visits the same fragments. With s = ⟨adjoint, coverage · light.colour · colour⟩ of a
/// fragment and its normal n, ambient receives s, directional s · max(0, n·L), L s · directional · n where
/// n·L > 0, which is then taken through L = direction/|direction|. The sun of an OutdoorLight and its
/// direction receive this times the share V of the sun that is seen, where its shadow falls being held still,
/// and its sky s · A · sky_transfer(n) where that is lit. Of a ClearCoat all receive what is mirrored, too.
/// Sums are in double, the same for any number of threads.
///
/// \param light          Light (flat), SmoothLight or OutdoorLight, or one of them with a ClearCoat
/// \param texels         [texel_count, 3], of a filtered atlas its pyramid
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
