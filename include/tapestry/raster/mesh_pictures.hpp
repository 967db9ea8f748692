#pragma once
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::raster {
/// Puts a picture on faces of a mesh, besides those that `pictures` holds; the last one of a face shows.
///
/// \param picture  [H, W, 3], RGB, encoded, row 0 at v = 1; uvs outside [0, 1] repeat it
/// \param faces    one entry a face, 1 for those that it shows on
/// \param filter   its lookup; functions with gradients by positions require bilinear
/// \param space    of the body
/// \throws ShapeError unless `faces` has an entry a face; DomainError for an empty picture; Error (mismatch)
///         if one of the faces has no texture coordinates
inline void add_picture(MeshPictures& pictures, const geometry::Mesh& mesh,
                        const Array<std::uint8_t, 3>& picture, const std::vector<std::uint8_t>& faces,
                        TextureFilter filter, image::ColourSpace space) {
  MeshPicture added{atlas_layout(picture.shape(0), picture.shape(1), 1, filter), {}};
  const PaintedMesh body{mesh, faces, added.layout, space};
  detail::require_layout("add_picture", body);
  const auto colours = image::from_bytes<float>(picture);
  added.texels = Array<float, 2>(Extents<2>{picture.shape(0) * picture.shape(1), 3});
  std::copy_n(colours.data(), colours.size(), added.texels.data());
  added.texels = stored_texels(pyramid_of(body), std::move(added.texels), space);
  if (is_filtered(added.layout)) added.filter.emplace(body);
  const auto index = static_cast<std::int32_t>(pictures.pictures.size());
  pictures.pictures.push_back(std::move(added));
  pictures.of_face.resize(mesh.faces.size(), -1);
  for (std::size_t face = 0; face < faces.size(); ++face)
    if (faces[face] != 0) pictures.of_face[face] = index;
}

/// Mean colour of a picture over a parallelogram in uv, from bilinear lookups that lie at most about a texel
/// apart, at most 64 along a side; encoded.
///
/// \param space   of the texels
/// \param middle  of the parallelogram, uv
/// \param sides   its two sides
[[nodiscard]] inline std::array<float, 3> mean_colour(const MeshPicture& picture, image::ColourSpace space,
                                                      const std::array<double, 2>& middle,
                                                      const std::array<std::array<double, 2>, 2>& sides) {
  const auto& layout = picture.layout;
  const auto count = [&](const std::array<double, 2>& side) {
    return std::clamp(std::ceil(std::hypot(side[0] * static_cast<double>(layout.width),
                                           side[1] * static_cast<double>(layout.height))),
                      1.0, 64.0);
  };
  const double columns = count(sides[0]), rows = count(sides[1]);
  std::array<double, 3> sum{0, 0, 0};
  for (double i = 0.5 / columns; i < 1; i += 1 / columns)
    for (double j = 0.5 / rows; j < 1; j += 1 / rows) {
      std::array<double, 2> uv = middle;
      for (std::size_t axis = 0; axis < 2; ++axis)
        uv[axis] += (i - 0.5) * sides[0][axis] + (j - 0.5) * sides[1][axis];
      visit_atlas_taps(layout, uv, [&](const Tap& tap) {
        for (std::size_t c = 0; c < 3; ++c)
          sum[c] += tap.weight * static_cast<double>(picture.texels(tap.texel, c));
      });
    }
  std::array<float, 3> mean{};
  for (std::size_t c = 0; c < 3; ++c) {
    mean[c] = static_cast<float>(sum[c] / (columns * rows));
    if (space == image::ColourSpace::linear) mean[c] = image::encoded(mean[c]);
  }
  return mean;
}
}  // namespace tapestry::raster
