#pragma once
#include <tapestry/detect/detector.hpp>

namespace tapestry::detect {
/// The same window in rows and columns, for networks.
[[nodiscard]] inline nn::MapWindow rows_and_columns(const image::PixelWindow& window) {
  return {{window.top, window.top + window.height}, {window.left, window.left + window.width}};
}

/// Kept layers of one picture that changes from pass to pass within a window only, as a car's does while its
/// paint is optimised: of each layer the surroundings of the part that the window reaches.
/// Detector::forward_within() fills it and checks whether it is still valid. Two threads must not share one.
template <std::floating_point T>
class KeptPicture {
 public:
  /// \param window  the picture is constant outside of it; may be empty
  explicit KeptPicture(const image::PixelWindow& window) : window_(window) {}

  [[nodiscard]] const image::PixelWindow& window() const { return window_; }

  /// Memory that it holds, bytes: 0 before the first pass, and for detectors that compute everything each
  /// time.
  [[nodiscard]] std::size_t bytes() const { return values_.bytes(); }

  /// For detectors, to read and to fill.
  [[nodiscard]] nn::KeptValues<T>& values() { return values_; }

 private:
  image::PixelWindow window_;
  nn::KeptValues<T> values_{};
};

/// \throws ShapeError unless there is one for each image, with windows inside the detector's pictures or null
template <std::floating_point T>
void require_kept(const char* operation, const Detector<T>& detector, const Array<T, 4>& images,
                  const std::vector<KeptPicture<T>*>& kept) {
  if (kept.size() != images.shape(0))
    throw ShapeError({operation, ": ", kept.size(), " kept pictures for ", images.shape(0), " images"});
  for (const KeptPicture<T>* picture : kept)
    if (picture != nullptr)
      image::require_window(operation, picture->window(), detector.input_height(), detector.input_width());
}
}  // namespace tapestry::detect
