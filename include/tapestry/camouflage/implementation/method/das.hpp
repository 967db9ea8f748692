#pragma once
#include <concepts>
#include <tapestry/camouflage/method/das.hpp>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/panels.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> das_full() {
  Method<T> method;
  method.attention = 1;
  return method;
}

template <std::floating_point T>
Method<T> das(const raster::PaintedMesh& car) {
  Method<T> method = paint_panels<T>(car, panel_texels("das", car));
  method.attention = das_full<T>().attention;
  return method;
}

template decltype(das_full<float>) das_full<float>;
template decltype(das_full<double>) das_full<double>;
template decltype(das<float>) das<float>;
template decltype(das<double>) das<double>;

}  // namespace tapestry::camouflage
