#pragma once
#include <numbers>
#include <tapestry/image/transform/chain.hpp>

namespace tapestry::image {
namespace detail {
/// Uniform in ±range; draws once, whatever the range, so that one range does not change other draws.
inline double either_way(Random& random, double range) { return random.uniform(-1, 1) * range; }

inline SensorNoise drawn_noise(const Conditions& conditions, Random& random) {
  const double deviation = random.uniform() * conditions.noise;  // at mid grey: half of its variance is shot
  return {deviation * deviation, std::max(deviation * std::numbers::sqrt2 / 2, 1e-9), random.bits()};
}

void require_sound(const SensorNoise& noise) {
  if (!(noise.shot >= 0 && noise.read > 0))
    throw DomainError("sensor noise: shot must be at least 0 and read above 0");
}

/// Rotation about an axis from the next axis towards the one after it.
inline Matrix3<double> rotation(std::size_t axis, double angle_rad) {
  const std::size_t next = (axis + 1) % 3, other = (axis + 2) % 3;
  Matrix3<double> turned = identity3;
  turned[next][next] = turned[other][other] = std::cos(angle_rad);
  turned[other][next] = std::sin(angle_rad);
  turned[next][other] = -std::sin(angle_rad);
  return turned;
}

void require_sound(const JpegCompression& jpeg) {
  if (jpeg.quality < 1 || jpeg.quality > 100)
    throw DomainError({"JPEG: quality ", jpeg.quality, " is not 1 to 100"});
}
}  // namespace detail

ColourChange contrast_and_saturation(double contrast, double saturation) {
  constexpr std::array<double, 3> luma{0.299, 0.587, 0.114};
  Matrix3<double> saturated{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      saturated[i][j] = saturation * identity3[i][j] + (1 - saturation) * luma[j];
  const double offset = (1 - contrast) / 2;
  return {scaled<double>(saturated, contrast), {offset, offset, offset}};
}

Warp warp_of(const CameraMotion& motion) {
  if (!(motion.zoom > 0 && motion.focal > 0))
    throw DomainError({"warp_of: a zoom of ", motion.zoom, " of a focal length of ", motion.focal,
                       "; both must be above 0"});
  using detail::rotation;
  auto source_from_target = composed(composed(rotation(1, motion.pan_rad), rotation(0, -motion.tilt_rad)),
                                     rotation(2, motion.roll_rad));
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      if (i < 2) source_from_target[i][j] *= motion.focal;
      if (j < 2) source_from_target[i][j] /= motion.focal * motion.zoom;
    }
  return {source_from_target};
}

WarpedPoint::WarpedPoint(const Warp& warp, std::size_t height, std::size_t width)
    : target_from_source_(inverse(warp.source_from_target)),
      middle_x_(static_cast<double>(width) / 2),
      middle_y_(static_cast<double>(height) / 2) {}

std::optional<std::array<double, 2>> WarpedPoint::operator()(double x, double y) const {
  const auto target =
      product(target_from_source_, {(x - middle_x_) / middle_x_, (y - middle_y_) / middle_x_, 1.0});
  if (!(target[2] > 0)) return {};
  return std::array{middle_x_ + middle_x_ * target[0] / target[2],
                    middle_y_ + middle_x_ * target[1] / target[2]};
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
    if (!is_known) throw DomainError({"conditions: '", name, "' is none of ", condition_names});
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
  for (auto& row : print.matrix)
    for (double& element : row) element += detail::either_way(random, conditions.printed_error);
  print.matrix = scaled<double>(print.matrix, white - black);
  print.offset.fill(black);
  return print;
}
}  // namespace tapestry::image
