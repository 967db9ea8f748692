#pragma once
#include <tapestry/image/detail/transform/warp.hpp>
#include <tapestry/image/transform/colour_change.hpp>

namespace tapestry::image {
namespace detail {
/// The four pixels that a warped pixel is mixed from.
struct WarpTap {
  std::array<std::size_t, 4> pixel;
  std::array<double, 4> share;
};

/// Source pixels of a row of warped pixels: those beyond the edge are taken at the edge, as are those behind
/// the camera.
class WarpRow {
 public:
  WarpRow(const Warp& warp, std::size_t y, std::size_t height, std::size_t width)
      : height_(height), width_(width), middle_x_(static_cast<double>(width) / 2) {
    const double down = (static_cast<double>(y) + 0.5 - static_cast<double>(height) / 2) / middle_x_;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& m = warp.source_from_target[i];
      step_[i] = m[0] / middle_x_;
      start_[i] = m[0] * (0.5 / middle_x_ - 1) + m[1] * down + m[2];
    }
  }

  [[nodiscard]] WarpTap operator()(std::size_t x) const {
    const auto source = [&](std::size_t i) { return start_[i] + static_cast<double>(x) * step_[i]; };
    const double depth = std::max(source(2), 1e-9);
    const auto [left, right, across] = taps(middle_x_ * (1 + source(0) / depth) - 0.5, width_);
    const auto [above, below, down] =
        taps(static_cast<double>(height_) / 2 + middle_x_ * source(1) / depth - 0.5, height_);
    return {{above * width_ + left, above * width_ + right, below * width_ + left, below * width_ + right},
            {(1 - down) * (1 - across), (1 - down) * across, down * (1 - across), down * across}};
  }

 private:
  struct Taps {
    std::size_t first, second;
    double share;
  };
  static Taps taps(double position, std::size_t count) {
    const double last = static_cast<double>(count - 1);
    const double clamped = std::clamp(position, 0.0, last);
    const auto first = static_cast<std::size_t>(clamped);
    return {first, std::min(first + 1, count - 1), clamped - static_cast<double>(first)};
  }

  std::size_t height_, width_;
  double middle_x_;
  std::array<double, 3> start_{}, step_{};
};
}  // namespace detail

template <std::floating_point T>
Array<T, 3> transformed(const Array<T, 3>& picture, const Warp& warp) {
  const std::size_t width = picture.shape(1), channels = picture.shape(2);
  Array<T, 3> out(picture.shape());
  detail::for_each_row(picture.shape(0), [&](std::size_t y) {
    const detail::WarpRow row(warp, y, picture.shape(0), width);
    for (std::size_t x = 0; x < width; ++x) {
      const auto tap = row(x);
      for (std::size_t c = 0; c < channels; ++c) {
        T sum = 0;
        for (std::size_t i = 0; i < 4; ++i)
          sum += static_cast<T>(tap.share[i]) * picture.data()[tap.pixel[i] * channels + c];
        out.data()[(y * width + x) * channels + c] = sum;
      }
    }
  });
  return out;
}

template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const Warp& warp, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint) {
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, picture.shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  const std::size_t width = out_adjoint.shape(1), channels = out_adjoint.shape(2);
  for (std::size_t y = 0; y < out_adjoint.shape(0); ++y) {
    const detail::WarpRow row(warp, y, out_adjoint.shape(0), width);
    for (std::size_t x = 0; x < width; ++x) {
      const auto tap = row(x);
      const T* const from = out_adjoint.data() + (y * width + x) * channels;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t c = 0; c < channels; ++c)
          picture_adjoint.data()[tap.pixel[i] * channels + c] += static_cast<T>(tap.share[i]) * from[c];
    }
  }
}
}  // namespace tapestry::image
