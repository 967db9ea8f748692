#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/raster/clear_coat.hpp>
#include <tapestry/raster/lighting.hpp>
#include <tapestry/raster/outdoor_light.hpp>

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

/// A light, flat or smooth, of the numbers that light_parameters() lists.
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

/// A light of sun and sky with other numbers; occlusion and shadow stay those they are.
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

/// The numbers of a light with a clear coat as an array: those of the light, then coat and roughness.
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

}  // namespace tapestry::raster
