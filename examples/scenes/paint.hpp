#pragma once
#include <tapestry/core/random.hpp>
#include "scene.hpp"

namespace tapestry::scenes {
/// Any colour of the RGB cube.
[[nodiscard]] inline Colour any_colour(Random& random) {
  const auto channel = [&] { return static_cast<float>(random.uniform(0.02, 0.98)); };
  const float red = channel(), green = channel();
  return {red, green, channel()};
}

/// `colour` with every channel moved by up to ± amount, kept in [0, 1].
[[nodiscard]] inline Colour varied(Random& random, Colour colour, double amount) {
  for (float& channel : colour)
    channel = std::clamp(channel + static_cast<float>(random.uniform(-amount, amount)), 0.0F, 1.0F);
  return colour;
}

[[nodiscard]] inline Colour scaled(Colour colour, double factor) {
  for (float& channel : colour) channel = std::clamp(channel * static_cast<float>(factor), 0.0F, 1.0F);
  return colour;
}

[[nodiscard]] inline Colour mixed(const Colour& a, const Colour& b, double share_of_b) {
  const auto t = static_cast<float>(share_of_b);
  return {a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t};
}

[[nodiscard]] inline Colour car_colour(Random& random) {
  static constexpr Colour sold[] = {{0.88F, 0.88F, 0.87F}, {0.80F, 0.80F, 0.78F}, {0.07F, 0.07F, 0.08F},
                                    {0.14F, 0.15F, 0.16F}, {0.36F, 0.37F, 0.39F}, {0.52F, 0.53F, 0.55F},
                                    {0.68F, 0.69F, 0.71F}, {0.55F, 0.06F, 0.06F}, {0.75F, 0.10F, 0.08F},
                                    {0.10F, 0.18F, 0.42F}, {0.22F, 0.38F, 0.62F}, {0.10F, 0.26F, 0.18F},
                                    {0.62F, 0.54F, 0.40F}, {0.86F, 0.66F, 0.12F}};
  return varied(random, sold[random.index(std::size(sold))], 0.05);
}

[[nodiscard]] inline PaintKind any_paint(Random& random) {
  static constexpr std::pair<PaintKind, double> shares[] = {
      {PaintKind::realistic, 0.40}, {PaintKind::solid, 0.30},   {PaintKind::two_tone, 0.10},
      {PaintKind::stripes, 0.04},   {PaintKind::patches, 0.04}, {PaintKind::texel_noise, 0.12}};
  double draw = random.uniform();
  for (const auto& [kind, share] : shares)
    if ((draw -= share) < 0) return kind;
  return PaintKind::solid;
}

namespace detail {
/// A function of a point of the car to a colour, for the paints that are one.
class PaintPattern {
 public:
  PaintPattern(Random& random, PaintKind kind) : kind_(kind) {
    const auto colour_count = 2 + random.index(5);
    for (std::size_t i = 0; i < colour_count; ++i) colours_.push_back(any_colour(random));
    const double yaw = random.uniform(0, 2 * std::numbers::pi);
    const double pitch = random.chance(0.4) ? 0 : random.uniform(-0.5, 0.5) * std::numbers::pi;
    axis_ = {std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch)};
    if (kind == PaintKind::two_tone && random.chance(0.5)) axis_ = {0, 0, 1};
    offset_ = kind == PaintKind::two_tone ? geometry::dot(axis_, {0, 0, random.uniform(0.5, 1.1)})
                                          : random.uniform();
    scale_ = std::exp(random.uniform(std::log(0.08), std::log(0.9)));
    if (kind != PaintKind::patches) return;
    const std::size_t centre_count = 24 + random.index(60);
    for (std::size_t i = 0; i < centre_count; ++i)
      centres_.push_back({random.uniform(-2.5, 2.5), random.uniform(-1, 1), random.uniform(0.2, 1.9)});
  }

  [[nodiscard]] Colour operator()(const Point& point) const {
    const double along = geometry::dot(axis_, point);
    if (kind_ == PaintKind::two_tone) return colours_[along > offset_ ? 1 : 0];
    if (kind_ != PaintKind::stripes) return colours_[nearest_centre(point) % colours_.size()];
    return colours_[static_cast<std::size_t>(std::floor(along / scale_ + offset_ + 1000)) % colours_.size()];
  }

 private:
  [[nodiscard]] std::size_t nearest_centre(const Point& point) const {
    const auto distance = [&](const Point& centre) {
      const Point gap = geometry::subtract(point, centre);
      return geometry::dot(gap, gap);
    };
    return static_cast<std::size_t>(std::ranges::min_element(centres_, {}, distance) - centres_.begin());
  }

  PaintKind kind_;
  std::vector<Colour> colours_;
  std::vector<Point> centres_;
  Point axis_{};
  double offset_ = 0, scale_ = 1;
};
}  // namespace detail

/// Paint for the faces of material `body`; the other faces keep their material's colour.
/// Texel noise is painted in its mean colour here.
[[nodiscard]] inline std::vector<Colour> paint_faces(Random& random, const geometry::Mesh& car,
                                                     PaintKind kind) {
  std::vector<Colour> colours;
  colours.reserve(car.faces.size());
  const Colour solid = kind == PaintKind::realistic ? car_colour(random) : any_colour(random);
  const detail::PaintPattern pattern(random, kind);
  const bool is_plain =
      kind == PaintKind::realistic || kind == PaintKind::solid || kind == PaintKind::texel_noise;
  for (std::size_t face = 0; face < car.faces.size(); ++face) {
    const auto material = static_cast<std::size_t>(car.face_materials[face]);
    if (material != 0 || is_plain) {
      colours.push_back(material != 0 ? car.materials[material].colour : solid);
    } else {
      Point centre{};
      for (const std::int32_t corner : car.faces[face])
        centre =
            geometry::add(centre, geometry::scale(car.positions[static_cast<std::size_t>(corner)], 1.0 / 3));
      colours.push_back(pattern(centre));
    }
  }
  return colours;
}

/// A random atlas: independent blocks of 1 to 16 texels, of full or reduced contrast around a colour.
/// \returns  [height · width, 3]
[[nodiscard]] inline Array<float, 2> random_texels(Random& random, std::size_t height, std::size_t width) {
  const std::size_t block = std::size_t{1} << random.index(5);
  const double contrast = random.chance(0.5) ? 1 : random.uniform(0.3, 1);
  const Colour base = any_colour(random);
  const std::size_t blocks_across = (width + block - 1) / block;
  std::vector<Colour> blocks(blocks_across * ((height + block - 1) / block));
  for (Colour& colour : blocks) colour = mixed(base, any_colour(random), contrast);
  Array<float, 2> texels(Extents<2>{height * width, 3});
  for (std::size_t row = 0; row < height; ++row)
    for (std::size_t column = 0; column < width; ++column)
      for (std::size_t c = 0; c < 3; ++c)
        texels(row * width + column, c) = blocks[row / block * blocks_across + column / block][c];
  return texels;
}
}  // namespace tapestry::scenes
