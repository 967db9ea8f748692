#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/detect/network/kept_values.hpp>
#include <tapestry/image/pixel_window.hpp>

namespace tapestry::detect {

/// What a detector keeps of one picture that changes from pass to pass within a window only, as a car's does
/// while its paint is optimised: of each layer what is next to the part that the window reaches. See
/// Detector::forward_within(), which fills it and finds out by itself when it no longer holds. Two threads
/// must not share one.
template <std::floating_point T>
class KeptPicture {
 public:
  /// \param window  outside of which the picture stays as it is; may be empty
  explicit KeptPicture(const image::PixelWindow& window) : window_(window) {}

  [[nodiscard]] const image::PixelWindow& window() const { return window_; }

  /// Memory that it holds: 0 before the first pass, and for detectors that compute everything each time.
  [[nodiscard]] std::size_t bytes() const { return values_.bytes(); }

  /// For detectors, to read and to fill.
  [[nodiscard]] detail::KeptValues<T>& values() { return values_; }

 private:
  image::PixelWindow window_;
  detail::KeptValues<T> values_{};
};

}  // namespace tapestry::detect
