#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/transform/camera_effects.hpp>
#include <tapestry/image/transform/chain.hpp>
#include <tapestry/image/transform/colour_change.hpp>
#include <tapestry/image/transform/warp.hpp>
#include <vector>

namespace tapestry::image::detail {

void require_sound(const SensorNoise& noise) {
  if (!(noise.shot >= 0 && noise.read > 0))
    throw DomainError("sensor noise: shot must be at least 0 and read above 0");
}

}  // namespace tapestry::image::detail

namespace tapestry::image {

ColourChange contrast_and_saturation(double contrast, double saturation) {
  const Eigen::RowVector3d luma(0.299, 0.587, 0.114);
  const Eigen::Matrix3d saturated =
      saturation * Eigen::Matrix3d::Identity() + (1 - saturation) * Eigen::Vector3d::Ones() * luma;
  return {contrast * saturated, Eigen::Vector3d::Constant((1 - contrast) / 2)};
}

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

namespace tapestry::image::detail {

void require_sound(const JpegCompression& jpeg) {
  if (jpeg.quality < 1 || jpeg.quality > 100)
    throw DomainError("JPEG: quality " + std::to_string(jpeg.quality) + " is not 1 to 100");
}

}  // namespace tapestry::image::detail
