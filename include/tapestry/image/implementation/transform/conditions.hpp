#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/image/transform/chain.hpp>
#include <tapestry/image/transform/colour_change.hpp>
#include <tapestry/image/transform/warp.hpp>
#include <vector>

namespace tapestry::image {

Warp warp_of(const CameraMotion& motion) {
  if (!(motion.zoom > 0 && motion.focal > 0))
    throw DomainError("warp_of: a zoom of " + std::to_string(motion.zoom) + " of a focal length of " +
                      std::to_string(motion.focal) + "; both must be above 0");
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  const Eigen::Matrix3d first_from_moved =
      (AngleAxisd(motion.pan_rad, Vector3d::UnitY()) * AngleAxisd(-motion.tilt_rad, Vector3d::UnitX()) *
       AngleAxisd(motion.roll_rad, Vector3d::UnitZ()))
          .toRotationMatrix();
  const Vector3d first(motion.focal, motion.focal, 1);
  const Vector3d moved_inverse(1 / (motion.focal * motion.zoom), 1 / (motion.focal * motion.zoom), 1);
  return {first.asDiagonal() * first_from_moved * moved_inverse.asDiagonal()};
}

WarpedPoint::WarpedPoint(const Warp& warp, std::size_t height, std::size_t width)
    : target_from_source_(warp.source_from_target.inverse()),
      middle_x_(static_cast<double>(width) / 2),
      middle_y_(static_cast<double>(height) / 2) {}

std::optional<std::array<double, 2>> WarpedPoint::operator()(double x, double y) const {
  const Eigen::Vector3d target =
      target_from_source_ * Eigen::Vector3d((x - middle_x_) / middle_x_, (y - middle_y_) / middle_x_, 1);
  if (!(target.z() > 0)) return {};
  return std::array{middle_x_ + middle_x_ * target.x() / target.z(),
                    middle_y_ + middle_x_ * target.y() / target.z()};
}

}  // namespace tapestry::image

namespace tapestry::image::detail {

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
    const Eigen::Matrix3d& m = warp.source_from_target;
    step_ = m.col(0) / middle_x_;
    start_ = m.col(0) * (0.5 / middle_x_ - 1) + m.col(1) * down + m.col(2);
  }

  [[nodiscard]] WarpTap operator()(std::size_t x) const {
    const Eigen::Vector3d source = start_ + static_cast<double>(x) * step_;
    const double depth = std::max(source.z(), 1e-9);
    const auto [left, right, across] = taps(middle_x_ * (1 + source.x() / depth) - 0.5, width_);
    const auto [above, below, down] =
        taps(static_cast<double>(height_) / 2 + middle_x_ * source.y() / depth - 0.5, height_);
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
  Eigen::Vector3d start_, step_;
};

}  // namespace tapestry::image::detail

namespace tapestry::image {

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

template Array<float, 3> transformed<float>(const Array<float, 3>& picture, const Warp& warp);
template Array<double, 3> transformed<double>(const Array<double, 3>& picture, const Warp& warp);
template void transformed_adjoint<float>(const Array<float, 3>& picture, const Warp& warp,
                                         const Array<float, 3>& out_adjoint,
                                         Array<float, 3>& picture_adjoint);
template void transformed_adjoint<double>(const Array<double, 3>& picture, const Warp& warp,
                                          const Array<double, 3>& out_adjoint,
                                          Array<double, 3>& picture_adjoint);

Conditions conditions_by_names(const std::vector<std::string>& names) {
  const Conditions& all = physical_conditions;
  Conditions chosen;
  for (const std::string& name : names) {
    const auto is = [&](const char* kind) { return name == kind || name == "physical"; };
    bool is_known = false;
    const auto take = [&](const char* kind, auto... members) {
      if (!is(kind)) return;
      is_known = true;
      ((chosen.*members = all.*members), ...);
    };
    take("camera", &Conditions::turn_degrees, &Conditions::roll_degrees, &Conditions::zoom);
    take("light", &Conditions::exposure_stops, &Conditions::colour_cast, &Conditions::shadow);
    take("blur", &Conditions::blur_px);
    take("noise", &Conditions::noise);
    take("contrast", &Conditions::contrast);
    take("jpeg", &Conditions::worst_quality);
    take("print", &Conditions::printed_range, &Conditions::printed_error);
    if (!is_known)
      throw DomainError("conditions: '" + name +
                        "' is none of camera, light, blur, noise, contrast, jpeg, print, physical");
  }
  return chosen;
}

}  // namespace tapestry::image

namespace tapestry::image::detail {

/// Uniform in ±range; draws once, whatever the range, so that one range does not change other draws.
inline double either_way(Random& random, double range) { return random.uniform(-1, 1) * range; }

inline SensorNoise drawn_noise(const Conditions& conditions, Random& random) {
  const double deviation = random.uniform() * conditions.noise;  // at mid grey: half of its variance is shot
  return {deviation * deviation, std::max(deviation * std::numbers::sqrt2 / 2, 1e-9), random.bits()};
}

}  // namespace tapestry::image::detail

namespace tapestry::image {

TransformationChain draw_chain(const Conditions& conditions, Random random, bool is_smooth) {
  using detail::either_way;
  const double degree = std::numbers::pi / 180;
  TransformationChain chain;
  CameraMotion motion;
  motion.pan_rad = either_way(random, conditions.turn_degrees) * degree;
  motion.tilt_rad = either_way(random, conditions.turn_degrees) * degree;
  motion.roll_rad = either_way(random, conditions.roll_degrees) * degree;
  motion.zoom = 1 + either_way(random, conditions.zoom);
  if (conditions.turn_degrees > 0 || conditions.roll_degrees > 0 || conditions.zoom > 0)
    chain.emplace_back(warp_of(motion));

  LightChange light;
  const double exposure = std::exp2(either_way(random, conditions.exposure_stops));
  const double red = 1 + either_way(random, conditions.colour_cast);
  const double blue = 1 + either_way(random, conditions.colour_cast);
  light.gain = {exposure * red, exposure, exposure * blue};
  const bool is_shadowed = random.chance(0.5);
  light.shadow = random.uniform() * (is_shadowed ? conditions.shadow : 0);
  light.shadow_rad = random.uniform(0, 2 * std::numbers::pi);
  light.shadow_at = either_way(random, 0.5);
  if (conditions.exposure_stops > 0 || conditions.colour_cast > 0 || conditions.shadow > 0)
    chain.emplace_back(light);

  const double across = random.uniform() * conditions.blur_px, down = random.uniform() * conditions.blur_px;
  if (conditions.blur_px > 0) chain.emplace_back(Blur{across, down});
  const SensorNoise noise = detail::drawn_noise(conditions, random);
  if (conditions.noise > 0) chain.emplace_back(noise);
  const double contrast = 1 + either_way(random, conditions.contrast);
  const double saturation = 1 + either_way(random, conditions.contrast);
  if (conditions.contrast > 0 || conditions.noise > 0)  // also clips noisy values to 0 … 1
    chain.emplace_back(contrast_and_saturation(contrast, saturation));
  const double quality = random.uniform(conditions.worst_quality, 96);
  if (conditions.worst_quality > 0)
    chain.emplace_back(JpegCompression{static_cast<int>(quality), true, is_smooth});
  return chain;
}

ColourChange draw_print(const Conditions& conditions, Random random) {
  ColourChange print;
  const double black = random.uniform() * conditions.printed_range;
  const double white = 1 - random.uniform() * conditions.printed_range;
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 3; ++column)
      print.matrix(row, column) += detail::either_way(random, conditions.printed_error);
  print.matrix *= white - black;
  print.offset.setConstant(black);
  return print;
}

}  // namespace tapestry::image
