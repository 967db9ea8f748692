#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/light.hpp>
#include <tapestry/raster/visibility.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster {

/// A picture of a scene whose faces have one colour each.
struct FacePicture {
  Array<float, 3> colour;          ///< [H, W, 3], lit colour times coverage
  Array<float, 2> coverage;        ///< [H, W] in [0, 1]
  std::vector<std::int32_t> face;  ///< [H · W] face at the pixel's first sample, −1 for none
  VisibilityBuffer visibility;     ///< for masks of single objects, see coverage_of()
};

/// Renders a scene without a texture and without a gradient.
///
/// \param face_colours  RGB, one entry a face
/// \throws ShapeError if face_colours does not have one entry a face; otherwise as visibility() and
///         face_light()
[[nodiscard]] inline FacePicture render_faces(const geometry::Mesh& mesh,
                                              const std::vector<std::array<float, 3>>& face_colours,
                                              const geometry::Camera& camera, std::size_t height,
                                              std::size_t width, const Light& light,
                                              std::size_t samples_per_axis = 2) {
  if (face_colours.size() != mesh.faces.size()) {
    throw ShapeError("render_faces: face_colours is [" + std::to_string(face_colours.size()) +
                     "], expected [" + std::to_string(mesh.faces.size()) + "], one entry a face");
  }
  FacePicture picture;
  picture.visibility = visibility(mesh, camera, height, width, samples_per_axis);
  std::vector<std::array<float, 3>> lit(face_colours);
  const std::vector<double> lights = face_light(mesh, camera, light);
  const std::size_t axis = samples_per_axis, columns = width * axis;
  const double share = 1.0 / static_cast<double>(axis * axis);
  for (std::size_t face = 0; face < lit.size(); ++face) {
    for (std::size_t c = 0; c < 3; ++c) {
      lit[face][c] =
          static_cast<float>(static_cast<double>(lit[face][c]) * lights[face] * light.colour[c] * share);
    }
  }
  picture.colour = zeros<float, 3>({height, width, 3});
  picture.coverage = coverage_of(picture.visibility);
  picture.face.resize(height * width);
  parallel_for(height, [&](std::size_t row) {
    for (std::size_t s = 0; s < axis * columns; ++s) {
      const std::size_t pixel = row * width + s % columns / axis;
      const std::int32_t face = picture.visibility.face[row * axis * columns + s];
      if (s < columns && s % axis == 0) picture.face[pixel] = face;
      if (face < 0) continue;
      const std::array<float, 3>& colour = lit[static_cast<std::size_t>(face)];
      for (std::size_t c = 0; c < 3; ++c) picture.colour.data()[3 * pixel + c] += colour[c];
    }
  });
  return picture;
}

}  // namespace tapestry::raster
