#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/camouflage/method/camou.hpp>
#include <tapestry/camouflage/method/das.hpp>
#include <tapestry/camouflage/method/fca.hpp>
#include <tapestry/camouflage/method/mesh_adv.hpp>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/methods.hpp>
#include <tapestry/camouflage/method/planar_patch.hpp>
#include <tapestry/camouflage/method/random.hpp>
#include <tapestry/camouflage/method/solid.hpp>
#include <tapestry/camouflage/method/upc.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> method_by_name(const std::string& name, const raster::PaintedMesh& car, std::uint64_t seed) {
  const std::size_t texel_count = car.layout.texel_count(car.mesh);
  if (name == "fca" || name == "rauca") return fca<T>();
  if (name == "planar_patch") return planar_patch<T>(car);
  if (name == "camou") return camou<T>(car);
  if (name == "upc") return upc<T>(car, seed);
  if (name == "das") return das<T>(car);
  if (name == "das_full") return das_full<T>();
  if (name == "mesh_adv") return mesh_adv<T>(car);
  if (name == "random") return random_paint<T>(texel_count, seed);
  if (name == "solid") return solid_paint<T>(texel_count);
  throw DomainError("no method is called " + in_quotes(name));
}

template decltype(method_by_name<float>) method_by_name<float>;
template decltype(method_by_name<double>) method_by_name<double>;

}  // namespace tapestry::camouflage
