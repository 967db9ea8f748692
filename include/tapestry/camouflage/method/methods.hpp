#pragma once
#include <tapestry/camouflage/method/comparators.hpp>

namespace tapestry::camouflage {
/// Requirements of a method, and how it differs from others for a program.
struct MethodTraits {
  bool needs_atlas = false;        ///< paints parts of an atlas
  bool maps_attention = false;     ///< needs one detector that observes a layer; has no adversarial loss
  bool moves_shape = false;        ///< needs views that can be drawn in another shape
  bool needs_photo_light = false;  ///< needs light estimated from photographs, see photo_light()
  bool is_optimised = true;        ///< false: the paint stays as it begins
  bool tells_texels_apart = true;  ///< false: a texture of one texel is enough
  std::string usual_options{};     ///< options of the program camouflage where methods are compared
};

namespace detail {
/// The method that a function makes for a car, with a seed, or alone.
template <std::floating_point T, auto function>
Method<T> made(const raster::PaintedMesh& car, std::uint64_t seed) {
  if constexpr (std::invocable<decltype(function)>)
    return function();
  else if constexpr (std::invocable<decltype(function), decltype(car)>)
    return function(car);
  else
    return function(car, seed);
}
}  // namespace detail

/// A method by its name.
template <std::floating_point T>
struct NamedMethod {
  std::string name;
  std::string sentence;  ///< for help
  Method<T> (*make)(const raster::PaintedMesh& car, std::uint64_t seed);
  MethodTraits traits{};
};

/// All methods, a row each: help, checks, scripts and tests read them here.
template <std::floating_point T>
[[nodiscard]] const std::vector<NamedMethod<T>>& methods() {
  static const std::vector<NamedMethod<T>> rows{
      {"fca", "the whole body", detail::made<T, fca<T>>},
      {"mesh_adv",
       "fca and the car's shape, with --filter bilinear",
       detail::made<T, mesh_adv<T>>,
       {.moves_shape = true, .usual_options = "--filter bilinear"}},
      {"camou", "a small pattern repeated all over", detail::made<T, camou<T>>, {.needs_atlas = true}},
      {"upc", "patches close to a natural picture", detail::made<T, upc<T>>, {.needs_atlas = true}},
      {"das",
       "roof, hood and doors, to scatter the detector's attention",
       detail::made<T, das<T>>,
       {.needs_atlas = true, .maps_attention = true, .usual_options = "--smoothness-weight 0"}},
      {"das_full",
       "das on the whole body",
       detail::made<T, das_full<T>>,
       {.maps_attention = true, .usual_options = "--smoothness-weight 0"}},
      {"rauca",
       "fca with --light photo",
       detail::made<T, fca<T>>,
       {.needs_photo_light = true, .usual_options = "--light photo"}},
      {"planar_patch",
       "one picture on roof, hood and doors",
       detail::made<T, planar_patch<T>>,
       {.needs_atlas = true}},
      {"random", "noise that is not optimised", detail::made<T, random_paint<T>>, {.is_optimised = false}},
      {"solid", "one colour", detail::made<T, solid_paint<T>>, {.tells_texels_apart = false}}};
  return rows;
}

/// The row of that name.
/// \throws DomainError if there is none
template <std::floating_point T>
[[nodiscard]] const NamedMethod<T>& method_row(const std::string& name) {
  for (const auto& row : methods<T>())
    if (row.name == name) return row;
  throw DomainError({"no method is called ", in_quotes(name)});
}

/// The method of that name for a car; the same seed draws the same.
/// \throws DomainError as method_row(), or unless the texture is an atlas if the method needs one; as
///         shape_parameter(); Error (mismatch) as panel_texels()
template <std::floating_point T>
[[nodiscard]] Method<T> method_by_name(const std::string& name, const raster::PaintedMesh& car,
                                       std::uint64_t seed) {
  return method_row<T>(name).make(car, seed);
}
}  // namespace tapestry::camouflage
