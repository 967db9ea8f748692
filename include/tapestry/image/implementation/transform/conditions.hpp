#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/image/transform/chain.hpp>
#include <tapestry/image/transform/conditions.hpp>
#include <vector>

namespace tapestry::image {

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

/// Uniform in ±range; draws once, whatever the range, so that one range does not change what others draw.
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
  if (conditions.contrast > 0 || conditions.noise > 0)  // which cuts to 0 … 1 what noise has left
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
