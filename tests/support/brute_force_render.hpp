#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::test {
/// Every sample of every pixel against every face near it, in double, without snapping; shares no code with
/// the rasteriser.
///
/// \param colour_of(face, barycentric)  RGB
/// \returns  [height, width, 3], the mean of the samples, 0 where nothing is seen
template <class ColourOf>
Array<double, 3> brute_force_render(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                    std::size_t height, std::size_t width, std::size_t samples,
                                    ColourOf colour_of) {
  using geometry::Vector3;
  struct Seen {
    double inverse_depth = 0;
    std::size_t face = 0;
  };
  const std::size_t rows = height * samples, columns = width * samples;
  const double step_x = 2 * camera.tan_half_fov_x / static_cast<double>(columns);
  const double step_y = 2 * camera.tan_half_fov_y / static_cast<double>(rows);
  std::vector<Seen> seen(rows * columns);
  std::vector<std::array<Vector3, 3>> weights(mesh.faces.size());  // barycentrics over depth, by the ray
  const auto ray_at = [&](std::size_t row, std::size_t column) {
    return Vector3{(static_cast<double>(column) + 0.5) * step_x - camera.tan_half_fov_x,
                   (static_cast<double>(row) + 0.5) * step_y - camera.tan_half_fov_y, 1};
  };
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    std::array<Vector3, 3> corner;
    std::array<Vector3, 3>& inverse = weights[face];
    std::array<double, 2> low{0, 0}, high{static_cast<double>(columns), static_cast<double>(rows)};
    bool is_in_front = true;
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = view_from_world(camera, mesh.positions[static_cast<std::size_t>(mesh.faces[face][k])]);
      is_in_front = is_in_front && corner[k][2] > camera.near;
    }
    const double volume = geometry::dot(corner[0], geometry::cross(corner[1], corner[2]));
    if (volume == 0) continue;
    for (std::size_t k = 0; k < 3; ++k)
      inverse[k] = geometry::scale(geometry::cross(corner[(k + 1) % 3], corner[(k + 2) % 3]), 1 / volume);
    for (std::size_t axis = 0; is_in_front && axis < 2; ++axis) {
      const double tangent = axis == 0 ? camera.tan_half_fov_x : camera.tan_half_fov_y;
      const auto at = [&](std::size_t k) {
        return (corner[k][axis] / corner[k][2] + tangent) / (axis == 0 ? step_x : step_y);
      };
      const auto [least, most] = std::minmax({at(0), at(1), at(2)});
      low[axis] = std::clamp(least - 1, 0.0, high[axis]);
      high[axis] = std::clamp(most + 1, 0.0, high[axis]);
    }
    for (auto row = static_cast<std::size_t>(low[1]); row < static_cast<std::size_t>(high[1]); ++row) {
      for (auto column = static_cast<std::size_t>(low[0]); column < static_cast<std::size_t>(high[0]);
           ++column) {
        const Vector3 ray = ray_at(row, column);
        const std::array<double, 3> w{geometry::dot(inverse[0], ray), geometry::dot(inverse[1], ray),
                                      geometry::dot(inverse[2], ray)};
        const double inverse_depth = w[0] + w[1] + w[2];
        Seen& sample = seen[row * columns + column];
        if (std::min({w[0], w[1], w[2]}) < 0 || inverse_depth <= sample.inverse_depth ||
            inverse_depth > 1 / camera.near || inverse_depth < 1 / camera.far)
          continue;
        sample = {inverse_depth, face};
      }
    }
  }
  auto image = zeros<double, 3>({height, width, 3});
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].inverse_depth == 0) continue;
    const Vector3 ray = ray_at(i / columns, i % columns);
    std::array<double, 3> b{};
    for (std::size_t k = 0; k < 3; ++k)
      b[k] = geometry::dot(weights[seen[i].face][k], ray) / seen[i].inverse_depth;
    const std::array<double, 3> colour = colour_of(seen[i].face, b);
    for (std::size_t c = 0; c < 3; ++c)
      image(i / columns / samples, i % columns / samples, c) +=
          colour[c] / static_cast<double>(samples * samples);
  }
  return image;
}
}  // namespace tapestry::test
