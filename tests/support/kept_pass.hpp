#pragma once
#include <tapestry/detect/darknet_model.hpp>
#include "catch.hpp"
#include "random_array.hpp"

namespace tapestry::test {
using image::PixelWindow;

template <class T>
[[nodiscard]] bool is_same(T a, T b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

/// Values of the logits of two passes that differ by a bit.
template <class T>
[[nodiscard]] std::size_t differences(const std::vector<Array<T, 4>>& a, const std::vector<Array<T, 4>>& b) {
  std::size_t count = a.size() == b.size() ? 0 : 1;
  for (std::size_t h = 0; h < a.size(); ++h) {
    REQUIRE(a[h].shape() == b[h].shape());
    for (std::size_t i = 0; i < a[h].size(); ++i)
      if (!is_same(a[h].data()[i], b[h].data()[i])) ++count;
  }
  return count;
}

[[nodiscard]] inline bool is_inside(const PixelWindow& window, std::size_t y, std::size_t x) {
  return y >= window.top && y < window.top + window.height && x >= window.left &&
         x < window.left + window.width;
}

/// Draws new colours within a window of one image.
template <class T>
void repaint(Array<T, 4>& images, std::size_t image, const PixelWindow& window, Random& random) {
  for (std::size_t y = window.top; y < window.top + window.height; ++y)
    for (std::size_t x = window.left; x < window.left + window.width; ++x)
      for (std::size_t c = 0; c < 3; ++c) images(image, y, x, c) = static_cast<T>(random.uniform(-1, 1));
}

/// A weight for every logit.
template <class T>
[[nodiscard]] std::vector<Array<T, 4>> weighting_of(const detect::Pass<T>& pass, Random& random) {
  auto weighting = pass.logits;
  for (auto& array : weighting)
    for (T& value : array.storage()) value = static_cast<T>(random.uniform(-1, 1));
  return weighting;
}

/// Number of values where a kept pass's adjoint differs from a whole one's: it adds within
/// the images' windows only.
template <class Network, class T>
[[nodiscard]] std::size_t adjoint_differences(const Network& network, detect::Pass<T>& kept_pass,
                                              detect::Pass<T>& whole_pass,
                                              const std::vector<PixelWindow>& windows, Random& random) {
  const auto weighting = weighting_of(whole_pass, random);
  const std::size_t height = network.input_height(), width = network.input_width();
  const auto before = random_array<T>({windows.size(), height, width, 3}, 5);
  auto gradient = before, expected = before;
  network.input_adjoint(kept_pass, weighting, gradient);
  network.input_adjoint(whole_pass, weighting, expected);
  std::size_t count = 0;
  for (std::size_t i = 0; i < windows.size(); ++i)
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          const T wanted = is_inside(windows[i], y, x) ? expected(i, y, x, c) : before(i, y, x, c);
          if (!is_same(gradient(i, y, x, c), wanted)) ++count;
        }
  return count;
}
}  // namespace tapestry::test
