#pragma once
#include <map>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/image/over.hpp>
#include <tapestry/raster/cropped.hpp>
#include <tapestry/raster/fitted_camera.hpp>

namespace tapestry::camouflage {
namespace detail {
/// m = 1 where any pixel of the frame's mask under the bilinear kernel is not zero: the rule of the
/// published data set, whose masks are slightly dilated silhouettes. Beside the frame it is 0.
template <std::floating_point T>
Array<T, 2> mask_of(const io::Frame& frame, std::size_t height, std::size_t width, image::FitKind fit) {
  Array<T, 3> marked(Extents<3>{frame.image.shape(0), frame.image.shape(1), 1});
  for (std::size_t i = 0; i < marked.size(); ++i)
    marked.data()[i] = !frame.mask || frame.mask->data()[i] != 0 ? T(1) : T(0);
  const Array<T, 3> canvas = image::fitted(marked, height, width, {fit, 0});
  Array<T, 2> mask(Extents<2>{height, width});
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = canvas.data()[i] > T(0) ? T(1) : T(0);
  return mask;
}

template <std::floating_point T>
Array<T, 2> interior_of(const Array<T, 2>& coverage) {
  auto interior = zeros<T, 2>(coverage.shape());
  for (std::size_t y = 0; y + 1 < coverage.shape(0); ++y)
    for (std::size_t x = 0; x + 1 < coverage.shape(1); ++x)
      if (coverage(y, x) == T(1) && coverage(y + 1, x) == T(1) && coverage(y, x + 1) == T(1))
        interior(y, x) = 1;
  return interior;
}

/// See View::orbit.
inline geometry::Orbit orbit_around(const geometry::Mesh& car, const geometry::Camera& camera) {
  const auto bounds = geometry::bounds_of(car.positions);
  const auto offset = geometry::subtract(geometry::eye_of(camera), bounds.middle());
  if (!(geometry::length(offset) > 0) || !geometry::is_finite(offset)) return {};
  auto orbit = geometry::orbit_of(camera, bounds.middle());
  if (bounds.half_length() > 0) orbit.distance /= bounds.half_length();
  return orbit;
}

/// Pixels of coverage where the frame lies.
template <std::floating_point T>
double covered_in(const Array<T, 2>& coverage, const image::Placement& place) {
  double sum = 0;
  for (std::size_t y = place.top; y < place.top + place.height; ++y)
    for (std::size_t x = place.left; x < place.left + place.width; ++x)
      sum += static_cast<double>(coverage(y, x));
  return sum;
}

/// Intersection over union of a frame's mask and the car's silhouette, by pixels of the frame.
inline double registration_of(const io::Frame& frame, const geometry::Mesh& car) {
  const auto seen =
      raster::visibility(car, io::camera_of(frame), frame.image.shape(0), frame.image.shape(1), 1);
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < seen.face.size(); ++i) {
    const bool is_masked = frame.mask->data()[i] != 0, is_covered = seen.face[i] >= 0;
    both += is_masked && is_covered ? 1U : 0U;
    either += is_masked || is_covered ? 1U : 0U;
  }
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 0;
}

inline detect::Box box_around(const image::PixelWindow& window) {
  const auto height = static_cast<double>(window.height), width = static_cast<double>(window.width);
  return {static_cast<double>(window.left) + width / 2, static_cast<double>(window.top) + height / 2, width,
          height};
}

/// PhotoLight::shows_car of a frame without a mask; none if there is no such rule.
template <std::floating_point T>
std::optional<bool> car_is_shown(const io::Frame& frame, const geometry::Mesh& car, const Sight<T>& sight,
                                 const Array<T, 3>& picture, const std::optional<PhotoLight>& photo) {
  if (frame.mask || !photo || !photo->shows_car) return std::nullopt;
  const auto seen = raster::visibility(car, sight.camera, picture.shape(0), picture.shape(1), 1);
  Array<T, 2> covered(Extents<2>{picture.shape(0), picture.shape(1)});
  for (std::size_t i = 0; i < covered.size(); ++i) covered.data()[i] = seen.face[i] >= 0 ? T(1) : T(0);
  Array<float, 3> numbers(picture.shape());
  std::copy(picture.begin(), picture.end(), numbers.begin());
  return photo->shows_car(numbers, frame.name, box_around(raster::covered_window(covered)));
}

/// Pixels of the frame for faces without paint, if it holds the car; else null. See make_view().
template <std::floating_point T>
std::shared_ptr<const Array<float, 3>> kept_photograph(const View<T>& view, bool is_lit_by_photograph) {
  const bool holds_car = view.registration ? *view.registration >= least_registration
                                           : is_lit_by_photograph && view.shows_car.value_or(false);
  if (!holds_car) return nullptr;
  Array<float, 3> pixels(view.background.shape());
  std::copy(view.background.begin(), view.background.end(), pixels.begin());
  return std::make_shared<const Array<float, 3>>(image::in_space(view.space, pixels));
}

/// An estimate without the arrays it was drawn with, to save memory: many views are kept.
[[nodiscard]] inline std::shared_ptr<const raster::EstimatedLight> small_copy(
    raster::EstimatedLight estimate) {
  estimate.light.shadow = nullptr;
  estimate.light.occlusion = nullptr;
  estimate.light.photograph = nullptr;
  return std::make_shared<const raster::EstimatedLight>(std::move(estimate));
}

/// The light that was estimated for a frame's place, or else from the frame alone.
inline std::optional<raster::EstimatedLight> light_of(const io::Frame& frame, const raster::PaintedMesh& car,
                                                      const PhotoLight& settings) {
  if (!settings.known) return photo_light({&frame, 1}, car, settings);
  raster::EstimatedLight estimate = *settings.known;
  estimate.light.occlusion = settings.occlusion;
  estimate.light.shadow = std::make_shared<const raster::ParallelView>(car.mesh, estimate.light.direction,
                                                                       settings.shadow_pixels);
  return estimate;
}
}  // namespace detail

template <std::floating_point T>
Sight<T> sight_of(const io::Frame& frame, image::ColourSpace space, std::size_t height, std::size_t width,
                  std::size_t samples_per_axis, image::FitKind fit) {
  const auto place = image::placement(frame.image.shape(0), frame.image.shape(1), height, width, fit);
  return {raster::fitted_camera(io::camera_of(frame), place, height, width), io::frame_light(frame, space),
          detail::mask_of<T>(frame, height, width, fit), samples_per_axis};
}

template <std::floating_point T>
View<T> make_view(const io::Frame& frame, const raster::PaintedMesh& car, std::size_t height,
                  std::size_t width, std::size_t samples_per_axis, const image::Fit& fit,
                  const std::optional<PhotoLight>& photo, bool keeps_photograph) {
  if (frame.mask)
    require_shape("make_view", "mask", *frame.mask, {frame.image.shape(0), frame.image.shape(1)});
  if (raster::is_filtered(car.layout) != (car.pyramid != nullptr))
    throw DomainError("make_view: expected a pyramid with a filtered atlas, and none without");
  const Sight<T> sight = sight_of<T>(frame, car.space, height, width, samples_per_axis, fit.kind);
  const auto place = image::placement(frame.image.shape(0), frame.image.shape(1), height, width, fit.kind);
  View<T> view;
  view.frame_extents = {frame.image.shape(0), frame.image.shape(1)};
  view.background = image::fitted(image::from_bytes<T>(frame.image), height, width, fit);
  double silhouette = 0;  // pixels
  const auto lit = [&](const auto& light) {
    auto bare = raster::texture_operator<T>(car, sight.camera, height, width, light, samples_per_axis);
    silhouette = detail::covered_in(bare.coverage, place);
    return raster::masked(std::move(bare), sight.mask);
  };
  view.space = car.space;
  if (frame.mask && keeps_photograph) view.registration = detail::registration_of(frame, car.mesh);
  view.shows_car = detail::car_is_shown(frame, car.mesh, sight, view.background, photo);
  auto estimate =
      photo && view.shows_car.value_or(true) ? detail::light_of(frame, car, *photo) : std::nullopt;
  raster::KeptPhotograph kept;
  if (keeps_photograph) kept.photograph = detail::kept_photograph(view, estimate.has_value());
  view.keeps_photograph = kept.photograph != nullptr;
  if (estimate) static_cast<raster::KeptPhotograph&>(estimate->light) = kept;
  const auto whole =
      estimate ? lit(estimate->light) : lit(raster::LightOverPhotograph{sight.light, std::move(kept)});
  if (estimate) view.photo_light = detail::small_copy(*estimate);
  view.name = frame.name;
  view.pyramid = car.pyramid;
  view.window = raster::covered_window(whole.coverage);
  view.paint_to_picture =
      std::make_shared<const raster::CompactOperator<T>>(compacted(raster::cropped(whole, view.window)));
  const auto& coverage = view.paint_to_picture->coverage;
  view.interior = std::make_shared<const Array<T, 2>>(detail::interior_of(coverage));
  view.visible_pixels = static_cast<std::size_t>(
      std::count_if(coverage.begin(), coverage.end(), [](T share) { return share > T(0); }));
  if (silhouette > 0) view.hidden_share = 1 - detail::covered_in(whole.coverage, place) / silhouette;
  view.orbit = detail::orbit_around(car.mesh, io::camera_of(frame));
  if (view.visible_pixels > 0) view.target = detail::box_around(view.window);
  return view;
}

template <std::floating_point T>
Array<T, 3> picture_of(const View<T>& view, const Array<T, 2>& colours) {
  return picture_of_texels(view, texels_of(view, colours));
}

template <std::floating_point T>
Array<T, 2> texels_of(const View<T>& view, const Array<T, 2>& colours) {
  return raster::stored_texels(view.pyramid, colours, view.space);
}

template <std::floating_point T>
Array<T, 3> picture_of_texels(const View<T>& view, const Array<T, 2>& texels) {
  const auto& paint = *view.paint_to_picture;
  const auto render = raster::render(paint, raster::own_texels(paint, texels));
  return image::over(render, paint.coverage, view.background, view.window.top, view.window.left, view.space);
}

template <std::floating_point T>
std::size_t view_bytes(const View<T>& view) {
  const std::size_t mask = view.sight ? view.sight->mask.size() : 0;
  const std::size_t interior = view.interior ? view.interior->size() : 0;
  return (view.background.size() + interior + mask) * sizeof(T) +
         raster::memory_bytes(*view.paint_to_picture);
}

template <std::floating_point T>
typename ViewStore<T>::ViewPointer ViewStore<T>::view(std::size_t index) {
  const Kept& kept = kept_[index];  // does not change once it is set
  if (locked([&] { return kept.view != nullptr; })) return unpacked(kept);
  auto made = make(index);
  keep(index, made);
  return made;
}

template <std::floating_point T>
void ViewStore<T>::find_places() const {
  std::vector<std::optional<std::array<std::int64_t, 6>>> keys(size());
  parallel_for(size(), [&](std::size_t i) { keys[i] = place_of(loaders_[i](), *settings_.photo_light); });
  std::map<std::array<std::int64_t, 6>, std::shared_ptr<Place>> known;
  std::vector<std::shared_ptr<Place>> of_frame;
  for (std::size_t i = 0; i < size(); ++i) {
    auto& place = keys[i] ? known[*keys[i]] : of_frame.emplace_back();
    if (!place) place = std::make_shared<Place>();
    place->frames.push_back(i);
    if (keys[i]) of_frame.push_back(place);
  }
  places_->of_frame = std::move(of_frame);
}

template <std::floating_point T>
void ViewStore<T>::estimate(Place& place) const {
  constexpr std::size_t most = 16;  // more tell nothing new
  const auto& [height, width, samples, keep_bytes, fit, photo_light, redrawn, keeps_photograph] = settings_;
  const std::size_t stride = block_count(place.frames.size(), most);
  std::vector<io::Frame> frames;
  for (std::size_t i = 0; i < place.frames.size(); i += stride) {
    io::Frame frame = loaders_[place.frames[i]]();
    const auto sight = sight_of<T>(frame, car_.space, height, width, samples, fit.kind);
    const auto picture = image::fitted(image::from_bytes<T>(frame.image), height, width, fit);
    if (detail::car_is_shown(frame, car_.mesh, sight, picture, photo_light).value_or(true))
      frames.push_back(std::move(frame));
  }
  if (frames.empty()) return;
  const auto light = camouflage::photo_light(frames, car_, *photo_light);
  if (light) place.light = detail::small_copy(*light);
}

template <std::floating_point T>
std::optional<PhotoLight> ViewStore<T>::light_rule(std::size_t index) const {
  auto rule = settings_.photo_light;
  if (!rule) return rule;
  std::call_once(places_->found, [&] { find_places(); });
  Place& place = *places_->of_frame[index];
  if (place.frames.size() < 2) return rule;
  std::call_once(place.estimated, [&] { estimate(place); });
  rule->known = place.light;
  return rule;
}

template <std::floating_point T>
typename ViewStore<T>::ViewPointer ViewStore<T>::make(std::size_t index) const {
  const auto& [height, width, samples, keep_bytes, fit, photo_light, redrawn, keeps_photograph] = settings_;
  const io::Frame frame = loaders_[index]();
  auto view = make_view<T>(frame, car_, height, width, samples, fit, light_rule(index), keeps_photograph);
  if (redrawn)
    view.sight =
        std::make_shared<const Sight<T>>(sight_of<T>(frame, car_.space, height, width, samples, fit.kind));
  return std::make_shared<const View<T>>(std::move(view));
}

template <std::floating_point T>
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

template <std::floating_point T>
typename ViewStore<T>::Kept ViewStore<T>::packed(const ViewPointer& view) {
  auto rest = std::make_shared<View<T>>(*view);
  rest->interior = nullptr;
  auto background = image::to_bytes(view->background);
  if (image::from_bytes<T>(background) != view->background) return {std::move(rest), {}};
  rest->background = Array<T, 3>();
  return {std::move(rest), std::move(background)};
}

template <std::floating_point T>
typename ViewStore<T>::ViewPointer ViewStore<T>::unpacked(const Kept& kept) {
  auto view = std::make_shared<View<T>>(*kept.view);
  view->interior = std::make_shared<const Array<T, 2>>(detail::interior_of(view->paint_to_picture->coverage));
  if (kept.background.size() > 0) view->background = image::from_bytes<T>(kept.background);
  return view;
}
}  // namespace tapestry::camouflage
