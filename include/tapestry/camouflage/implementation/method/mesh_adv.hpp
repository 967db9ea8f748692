#pragma once
#include <concepts>
#include <memory>
#include <tapestry/camouflage/method/mesh_adv.hpp>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> mesh_adv(const raster::PaintedMesh& car) {
  Method<T> method;
  method.shape = std::make_shared<const ShapeParameter>(shape_parameter(car));
  return method;
}

template decltype(mesh_adv<float>) mesh_adv<float>;
template decltype(mesh_adv<double>) mesh_adv<double>;

}  // namespace tapestry::camouflage
