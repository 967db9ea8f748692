#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <tapestry/image/transform/conditions.hpp>
#include <utility>
#include <vector>

namespace tapestry::evaluate {

template <class T>
Photograph<T> photograph_of(const camouflage::View<T>& view, std::size_t view_index,
                            const camouflage::Paint<T>* paint, const Photography& photography,
                            std::size_t draw) {
  const auto in = [&](const Array<T, 2>& texture) { return camouflage::picture_of(view, texture); };
  const image::Conditions& conditions = photography.conditions;
  if (conditions == image::Conditions{})
    return {paint != nullptr ? in(paint->colours) : view.background, view.target};
  const Random random(photography.seed);
  const auto shot =
      camouflage::draw_shot(view, conditions, random.fork(1).fork(draw).fork(view_index), false);
  Array<T, 3> picture =
      paint != nullptr
          ? in(camouflage::printed(*paint, image::draw_print(conditions, random.fork(2).fork(draw))))
          : view.background;
  return {image::transformed(std::move(picture), shot.chain), shot.target};
}

template decltype(photograph_of<float>) photograph_of<float>;
template decltype(photograph_of<double>) photograph_of<double>;

}  // namespace tapestry::evaluate
