#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/image/colour.hpp>
#include <tapestry/image/letterbox.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

template <class T>
std::size_t view_bytes(const View<T>& view) {
  const std::size_t mask = view.sight ? view.sight->mask.size() : 0;
  return (view.background.size() + view.interior->size() + mask) * sizeof(T) +
         raster::memory_bytes(*view.paint_to_picture);
}

template <class T>
typename ViewStore<T>::ViewPointer ViewStore<T>::view(std::size_t index) {
  const Kept& kept = kept_[index];  // which does not change once it is there
  if (locked([&] { return kept.view != nullptr; })) return unpacked(kept);
  auto made = make(index);
  keep(index, made);
  return made;
}

template <class T>
typename ViewStore<T>::ViewPointer ViewStore<T>::make(std::size_t index) const {
  const auto& [height, width, samples, keep_bytes, fit, photo_light, redrawn] = settings_;
  const io::Frame frame = loaders_[index]();
  auto view = make_view<T>(frame, car_, height, width, samples, fit, photo_light);
  if (redrawn)
    view.sight =
        std::make_shared<const Sight<T>>(sight_of<T>(frame, car_.space, height, width, samples, fit.kind));
  return std::make_shared<const View<T>>(std::move(view));
}

template <class T>
void ViewStore<T>::keep(std::size_t index, const ViewPointer& view) {
  if (locked([&] { return kept_bytes_ >= settings_.keep_bytes; })) return;
  Kept kept = packed(view);
  const std::size_t bytes = view_bytes(*kept.view) + kept.background.size();
  locked([&] {
    if (kept_[index].view) return;  // another thread was quicker
    if (kept_bytes_ + bytes > settings_.keep_bytes) {
      kept_bytes_ = settings_.keep_bytes;  // full from now on
      return;
    }
    kept_bytes_ += bytes;
    kept_[index] = std::move(kept);
  });
}

template <class T>
typename ViewStore<T>::Kept ViewStore<T>::packed(const ViewPointer& view) {
  Kept kept{view, image::to_bytes(view->background)};
  if (image::from_bytes<T>(kept.background) != view->background) return {view};
  auto rest = std::make_shared<View<T>>(*view);
  rest->background = Array<T, 3>();
  kept.view = std::move(rest);
  return kept;
}

template <class T>
typename ViewStore<T>::ViewPointer ViewStore<T>::unpacked(const Kept& kept) {
  if (kept.background.size() == 0) return kept.view;
  auto view = std::make_shared<View<T>>(*kept.view);
  view->background = image::from_bytes<T>(kept.background);
  return view;
}

template decltype(view_bytes<float>) view_bytes<float>;
template decltype(view_bytes<double>) view_bytes<double>;
template class ViewStore<float>;
template class ViewStore<double>;

}  // namespace tapestry::camouflage
