#pragma once
#include "car_section.hpp"
#include "mesh_builder.hpp"

namespace tapestry::scenes {
/// Indices of a car's materials in its mesh, in this order.
struct CarMaterials {
  std::int32_t body, glass, tyre, light, tail_light, trim, rim, plate;
};

/// Place of a chart in the 2×1 atlas: metres [s_low, s_high] × [t_low, t_high] fill the rectangle.
struct Chart {
  double u_low, u_high, v_low, v_high;
  double s_low = 0, s_high = 1, t_low = 0, t_high = 1;

  [[nodiscard]] Uv operator()(double s, double t) const {
    return {u_low + (u_high - u_low) * (s - s_low) / (s_high - s_low),
            v_low + (v_high - v_low) * (t - t_low) / (t_high - t_low)};
  }
};

/// Lofts the shell of a car from its sections: sides, top, both ends and the underside.
/// Painted faces have uv coordinates, one to one on a 2×1 atlas of five charts: right side, left
/// side and top on the left, front and rear on the right; left, front and rear are not mirrored.
class CarBody {
 public:
  CarBody(MeshBuilder& builder, const CarShape& shape, const CarMaterials& materials, double spacing)
      : builder_(builder), shape_(shape), materials_(materials) {
    for (const double x : section_positions(shape, spacing)) sections_.push_back(car_section(shape, x));
    place_charts();
  }

  void build() {
    make_vertices();
    for (std::size_t side = 0; side < 2; ++side)
      for (std::size_t station = 0; station + 1 < sections_.size(); ++station) {
        for (std::size_t row = 0; row < section_rows; ++row) loft_quad(side, station, row);
        underside(side, station);
      }
    make_end(0);
    make_end(sections_.size() - 1);
  }

 private:
  /// Rounds the ends in plan view and lets them lean back; leaves the middle of the car alone.
  [[nodiscard]] Point place(double x, double y, double z) const {
    const bool front = x > 0;
    const double end = front ? shape_.front : shape_.rear;
    const double t = std::clamp(1 - std::abs(end - x) / 0.6, 0.0, 1.0);
    const double width = shape_.half_width(end);
    const double bulge = (front ? 0.13 : 0.07) * std::max(0.0, 1 - y * y / (width * width));
    const double upper = std::clamp((z - 0.5) / (shape_.top(end) - 0.5), 0.0, 1.0);
    const double lower = std::clamp((0.42 - z) / 0.25, 0.0, 1.0);
    const double rake = (front ? shape_.front_rake : shape_.rear_rake) * upper * upper + 0.09 * lower * lower;
    return {x + (front ? 1 : -1) * t * t * (3 - 2 * t) * (bulge - rake), y, z};
  }

  void place_charts() {
    double height = 0;
    double lateral = 0;
    arc_ = {0};
    for (std::size_t i = 0; i < sections_.size(); ++i) {
      height = std::max(height, sections_[i].points[roof_row].height);
      lateral = std::max(lateral, sections_[i].points[roof_row].lateral);
      if (i > 0)
        arc_.push_back(arc_.back() + std::hypot(sections_[i].x - sections_[i - 1].x,
                                                shape_.top(sections_[i].x) - shape_.top(sections_[i - 1].x)));
    }
    side_charts_[0] = {1.46, 0.01, 0.32, 0.61, shape_.rear, shape_.front, shape_.underside, height};
    side_charts_[1] = {0.01, 1.46, 0.01, 0.30, shape_.rear, shape_.front, shape_.underside, height};
    top_chart_ = {0.01, 1.46, 0.63, 0.99, 0, arc_.back(), -lateral, lateral};
    const double front_width = shape_.half_width(shape_.front);
    const double rear_width = shape_.half_width(shape_.rear);
    front_chart_ = {
        1.49, 1.99, 0.01, 0.49, -front_width, front_width, shape_.underside, shape_.top(shape_.front)};
    rear_chart_ = {
        1.99, 1.49, 0.51, 0.99, -rear_width, rear_width, shape_.underside, shape_.top(shape_.rear)};
  }

  void make_vertices() {
    for (std::size_t side = 0; side < 2; ++side) {
      const double sign = side == 0 ? 1 : -1;
      for (std::size_t station = 0; station < sections_.size(); ++station) {
        const CarSection& section = sections_[station];
        Ring ring{};
        for (std::size_t i = 0; i <= section_rows; ++i) {
          const auto& point = section.points[i];
          ring.position[i] = builder_.vertex(place(section.x, sign * point.y, point.z));
          ring.side_uv[i] = i <= roof_row ? builder_.uv(side_charts_[side](section.x, point.height)) : -1;
          ring.top_uv[i] = i >= roof_row ? builder_.uv(top_chart_(arc_[station], sign * point.lateral)) : -1;
        }
        rings_[side].push_back(ring);
      }
    }
  }

  void loft_quad(std::size_t side, std::size_t station, std::size_t row) {
    const Ring& near = rings_[side][station];
    const Ring& far = rings_[side][station + 1];
    const std::int32_t material = loft_material(station, row);
    std::array<std::int32_t, 4> uvs{-1, -1, -1, -1};
    if (material == materials_.body) {
      const auto list = row < roof_row ? &Ring::side_uv : &Ring::top_uv;
      uvs = {(near.*list)[row], (far.*list)[row], (far.*list)[row + 1], (near.*list)[row + 1]};
    }
    oriented_quad(side == 1,
                  {near.position[row], far.position[row], far.position[row + 1], near.position[row + 1]},
                  material, uvs);
  }

  void oriented_quad(bool as_given, const std::array<std::int32_t, 4>& corners, std::int32_t material,
                     const std::array<std::int32_t, 4>& uvs = {-1, -1, -1, -1}) {
    if (as_given) return builder_.quad(corners, material, uvs);
    builder_.quad({corners[0], corners[3], corners[2], corners[1]}, material,
                  {uvs[0], uvs[3], uvs[2], uvs[1]});
  }

  [[nodiscard]] std::int32_t loft_material(std::size_t station, std::size_t row) const {
    const double x = (sections_[station].x + sections_[station + 1].x) / 2;
    const auto inside = [x](const std::pair<double, double>& range) {
      return x > range.first && x < range.second;
    };
    if (row >= roof_row)
      return row > roof_row && (inside(shape_.windscreen) || inside(shape_.rear_window)) ? materials_.glass
                                                                                         : materials_.body;
    if (row >= shoulder_row) return window_material(x, row);
    const auto& points = sections_[station].points;
    const double z = (points[row].z + points[row + 1].z) / 2;
    if (x > shape_.front - 0.24 && is_headlight(z)) return materials_.light;
    return x < shape_.rear + 0.20 && is_tail_light(z) ? materials_.tail_light : materials_.body;
  }

  [[nodiscard]] std::int32_t window_material(double x, std::size_t row) const {
    const auto& windows = shape_.side_windows;
    if (row == shoulder_row || row + 1 == roof_row || x < windows.front().first || x > windows.back().second)
      return materials_.body;
    for (const auto& [begin, end] : windows)
      if (x > begin && x < end) return materials_.glass;
    return materials_.trim;  // pillar between two windows
  }

  [[nodiscard]] bool is_headlight(double z) const {
    const double belt = shape_.belt(shape_.front);
    return z > belt - 0.19 && z < belt - 0.02;
  }

  [[nodiscard]] bool is_tail_light(double z) const {
    return z > shape_.tail_lights.first && z < shape_.tail_lights.second;
  }

  /// Flat floor, and the lining of the wheel arches.
  void underside(std::size_t side, std::size_t station) {
    const double sign = side == 0 ? 1 : -1;
    std::array<std::array<std::int32_t, 4>, 2> strip{};
    for (std::size_t i = 0; i < 2; ++i) {
      const CarSection& section = sections_[station + i];
      const auto& edge = section.points[0];
      const double inner = sign * (edge.y - 0.3);
      strip[i] = {rings_[side][station + i].position[0], builder_.vertex(place(section.x, inner, edge.z)),
                  builder_.vertex(place(section.x, inner, shape_.underside)),
                  builder_.vertex(place(section.x, 0, shape_.underside))};
    }
    for (std::size_t i = 0; i < 3; ++i)
      oriented_quad(side == 0, {strip[0][i], strip[1][i], strip[1][i + 1], strip[0][i + 1]}, materials_.trim);
  }

  /// Closes the first or last section by strips across the car.
  void make_end(std::size_t station) {
    const bool front = station > 0;
    const CarSection& section = sections_[station];
    const Chart& chart = front ? front_chart_ : rear_chart_;
    std::vector<std::array<std::int32_t, end_columns.size()>> positions(section_rows + 1);
    std::vector<std::array<std::int32_t, end_columns.size()>> uvs(section_rows + 1);
    for (std::size_t row = 0; row <= section_rows; ++row)
      for (std::size_t column = 0; column < end_columns.size(); ++column) {
        const auto& point = section.points[row];
        const double y = end_columns[column] * point.y;
        positions[row][column] = builder_.vertex(place(section.x, y, point.z));
        uvs[row][column] = builder_.uv(chart(y, point.z));
      }
    for (std::size_t row = 0; row < section_rows; ++row)
      for (std::size_t column = 0; column + 1 < end_columns.size(); ++column) {
        const double z = (section.points[row].z + section.points[row + 1].z) / 2;
        const double across = std::abs(end_columns[column] + end_columns[column + 1]) / 2;
        const std::int32_t material = front ? front_material(z, across) : rear_material(z, across, row);
        std::array<std::int32_t, 4> corner_uvs{-1, -1, -1, -1};
        if (material == materials_.body)
          corner_uvs = {uvs[row][column], uvs[row][column + 1], uvs[row + 1][column + 1],
                        uvs[row + 1][column]};
        oriented_quad(front,
                      {positions[row][column], positions[row][column + 1], positions[row + 1][column + 1],
                       positions[row + 1][column]},
                      material, corner_uvs);
      }
  }

  /// \param across  distance from the centre line, 1 at the corner
  [[nodiscard]] std::int32_t front_material(double z, double across) const {
    const double belt = shape_.belt(shape_.front);
    if (is_headlight(z)) return across > 0.6 ? materials_.light : materials_.trim;
    if (across < 0.3 && z > shape_.underside + 0.15 && z < shape_.underside + 0.26) return materials_.plate;
    return z < shape_.underside + 0.14 || (across < 0.5 && z < belt && z > belt - 0.3) ? materials_.trim
                                                                                       : materials_.body;
  }

  [[nodiscard]] std::int32_t rear_material(double z, double across, std::size_t row) const {
    const bool van = shape_.top(shape_.rear) > 1.8;
    if (van && row > shoulder_row && row + 1 < roof_row && across > 0.1 && across < 0.7)
      return materials_.glass;
    if (is_tail_light(z) && across > (van ? 0.85 : 0.6)) return materials_.tail_light;
    if (across < 0.3 && z > shape_.tail_lights.first - 0.16 && z < shape_.tail_lights.first)
      return materials_.plate;
    return z < shape_.underside + 0.09 ? materials_.trim : materials_.body;
  }

  static constexpr std::array<double, 10> end_columns{-1,   -0.88, -0.72, -0.5, -0.22,
                                                      0.22, 0.5,   0.72,  0.88, 1};
  struct Ring {
    std::array<std::int32_t, section_rows + 1> position, side_uv, top_uv;
  };

  MeshBuilder& builder_;
  const CarShape& shape_;
  CarMaterials materials_;
  std::vector<CarSection> sections_;
  std::vector<double> arc_;  ///< of the centre line, one entry a section; metres
  std::array<Chart, 2> side_charts_{};
  Chart top_chart_{}, front_chart_{}, rear_chart_{};
  std::array<std::vector<Ring>, 2> rings_;
};
}  // namespace tapestry::scenes
