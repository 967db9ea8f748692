#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::test {
/// ⟨weights, picture⟩ of a mesh with a colour at every position, integrated exactly along lines down the
/// picture, several in each column of pixels. Each line is cut where a face begins or ends, where two faces
/// cut through each other, and at the borders of pixels; each piece takes the nearest face's colours by
/// Gauss's rule of five points. So it is smooth in motions that keep the columns of all corners, however thin
/// faces are. It shares no code with the rasteriser.
class ColumnPicture {
 public:
  /// \param colours  [V, 3]
  /// \param weights  [H, W, 3]
  /// \param lines    in each column of pixels
  ColumnPicture(const Array<double, 2>& colours, const Array<double, 3>& weights, std::size_t lines)
      : colours_(colours), weights_(weights), lines_(lines) {}

  /// \pre the mesh lies between near and far
  [[nodiscard]] double loss(const geometry::Mesh& mesh, const geometry::Camera& camera) const {
    std::vector<std::vector<Run>> runs(weights_.shape(1) * lines_);
    for (const geometry::Corners& face : mesh.faces) add_runs(mesh, camera, face, runs);
    double sum = 0;
    for (std::size_t line = 0; line < runs.size(); ++line) sum += line_loss(runs[line], line / lines_);
    return sum / static_cast<double>(lines_);
  }

 private:
  using Vector3 = geometry::Vector3;

  /// The part of a line on a face; functions of the row are {value at row 0, slope}.
  struct Run {
    double begin = 0, end = 0;                      ///< rows
    std::array<std::array<double, 2>, 3> weight{};  ///< barycentrics over depth
    const geometry::Corners* corners = nullptr;

    [[nodiscard]] double inverse_depth(double row) const {
      double sum = 0;
      for (const auto& [constant, slope] : weight) sum += constant + slope * row;
      return sum;
    }
  };

  void add_runs(const geometry::Mesh& mesh, const geometry::Camera& camera, const geometry::Corners& corners,
                std::vector<std::vector<Run>>& runs) const {
    const auto height = static_cast<double>(weights_.shape(0));
    const double step_x = 2 * camera.tan_half_fov_x / static_cast<double>(runs.size());
    const double step_y = 2 * camera.tan_half_fov_y / height;
    std::array<Vector3, 3> q, c;
    std::array<std::array<double, 2>, 3> point;  // line, row
    for (std::size_t k = 0; k < 3; ++k) {
      q[k] = geometry::view_from_world(camera, mesh.positions[static_cast<std::size_t>(corners[k])]);
      point[k] = {(q[k][0] / q[k][2] + camera.tan_half_fov_x) / step_x - 0.5,
                  (q[k][1] / q[k][2] + camera.tan_half_fov_y) / step_y};
    }
    const double volume = geometry::dot(q[0], geometry::cross(q[1], q[2]));
    if (volume == 0) return;
    for (std::size_t k = 0; k < 3; ++k)
      c[k] = geometry::scale(geometry::cross(q[(k + 1) % 3], q[(k + 2) % 3]), 1 / volume);
    const auto [least, most] = std::minmax({point[0][0], point[1][0], point[2][0]});
    const double last = std::min(most, static_cast<double>(runs.size()) - 1);
    for (double line = std::max(std::ceil(least), 0.0); line <= last; ++line) {
      Run run{height, 0, {}, &corners};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto &a = point[k], &b = point[(k + 1) % 3];
        const double ray = (line + 0.5) * step_x - camera.tan_half_fov_x;
        run.weight[k] = {c[k][0] * ray - c[k][1] * camera.tan_half_fov_y + c[k][2], c[k][1] * step_y};
        if (a[0] == b[0] || (line - a[0]) * (line - b[0]) > 0) continue;
        const double row = a[1] + (b[1] - a[1]) * (line - a[0]) / (b[0] - a[0]);
        run.begin = std::min(run.begin, std::max(row, 0.0));
        run.end = std::max(run.end, std::min(row, height));
      }
      if (run.begin < run.end) runs[static_cast<std::size_t>(line)].push_back(run);
    }
  }

  [[nodiscard]] double line_loss(std::vector<Run>& runs, std::size_t column) const {
    if (runs.empty()) return 0;
    std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.begin < b.begin; });
    std::vector<double> cuts;
    for (std::size_t row = 0; row <= weights_.shape(0); ++row) cuts.push_back(static_cast<double>(row));
    for (const Run& run : runs) {
      cuts.push_back(run.begin);
      cuts.push_back(run.end);
    }
    std::sort(cuts.begin(), cuts.end());
    std::vector<const Run*> active;
    std::size_t next = 0;
    double sum = 0;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      const double middle = (cuts[i] + cuts[i + 1]) / 2;
      for (; next < runs.size() && runs[next].begin < middle; ++next) active.push_back(&runs[next]);
      std::erase_if(active, [&](const Run* run) { return run->end <= middle; });
      if (!active.empty() && cuts[i] < cuts[i + 1]) sum += piece_loss(active, cuts[i], cuts[i + 1], column);
    }
    return sum;
  }

  /// \param active  faces that cover the piece
  [[nodiscard]] double piece_loss(const std::vector<const Run*>& active, double begin, double end,
                                  std::size_t column) const {
    const auto nearest = [&](double row) {
      return *std::max_element(active.begin(), active.end(), [&](const Run* a, const Run* b) {
        return a->inverse_depth(row) < b->inverse_depth(row);
      });
    };
    const double inside = 1e-6 * (end - begin);
    const Run *first = nearest(begin + inside), *last = nearest(end - inside);
    const double apart_first = first->inverse_depth(begin) - last->inverse_depth(begin);
    const double apart_last = first->inverse_depth(end) - last->inverse_depth(end);
    if (first != last && apart_first > 1e-9 * first->inverse_depth(begin) &&
        apart_last < -1e-9 * first->inverse_depth(end)) {
      const double cut = begin + (end - begin) * apart_first / (apart_first - apart_last);
      return gauss(*first, begin, cut, column) + gauss(*last, cut, end, column);
    }
    return gauss(*nearest((begin + end) / 2), begin, end, column);
  }

  [[nodiscard]] double gauss(const Run& run, double begin, double end, std::size_t column) const {
    const auto row = static_cast<std::size_t>((begin + end) / 2);
    const double near = run.inverse_depth(begin), far = run.inverse_depth(end);
    if (std::max(near, far) > 1.3 * std::min(near, far) && end - begin > 1e-12)
      return gauss(run, begin, (begin + end) / 2, column) + gauss(run, (begin + end) / 2, end, column);
    constexpr std::array<double, 5> place{0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640,
                                          -0.9061798459386640};
    constexpr std::array<double, 5> weight{0.5688888888888889, 0.4786286704993665, 0.4786286704993665,
                                           0.2369268850561891, 0.2369268850561891};
    double sum = 0;
    for (std::size_t i = 0; i < place.size(); ++i) {
      const double at = begin + (end - begin) * (1 + place[i]) / 2, depth = 1 / run.inverse_depth(at);
      for (std::size_t k = 0; k < 3; ++k) {
        const double b = (run.weight[k][0] + run.weight[k][1] * at) * depth * weight[i];
        for (std::size_t c = 0; c < 3; ++c)
          sum += b * colours_(static_cast<std::size_t>((*run.corners)[k]), c) * weights_(row, column, c);
      }
    }
    return sum * (end - begin) / 2;
  }

  const Array<double, 2>& colours_;
  const Array<double, 3>& weights_;
  std::size_t lines_;
};
}  // namespace tapestry::test
