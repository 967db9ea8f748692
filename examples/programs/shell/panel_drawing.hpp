#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <tapestry/raster/used_texels.hpp>
#include <utility>
#include <vector>

#include "mesh_views.hpp"
#include "paint_panels.hpp"
#include "pdf_file.hpp"

namespace tapestry::shell {

/// A part of a panel, metres from the panel's lower left corner.
struct PanelPart {
  double left = 0, bottom = 0, width = 0, height = 0;
};

/// Draws panels of a scene with an atlas into a file.
class PanelDrawing {
 public:
  /// \param path  of the file, for messages
  PanelDrawing(const PaintedScene& scene, PdfFile& file, std::string path)
      : scene_(scene),
        texels_(image::in_space(scene.space, scene.texels)),
        file_(file),
        path_(std::move(path)) {}

  /// Draws the paint of a part and its rim; white where there is none.
  /// \param corner   lower left corner of the part on the page
  /// \param cm_by_m  centimetres on the page by metres on the car
  /// \param pixel    longest side of a pixel, centimetres
  void draw(PdfPage& page, const PaintPanel& panel, const PanelPart& part, const PagePoint& corner,
            double cm_by_m, double pixel) {
    const auto on_page = [&](const std::array<double, 2>& uv) {
      const auto [x, y] = panel.place_m(uv);
      return PagePoint{corner[0] + (x - part.left) * cm_by_m, corner[1] + (y - part.bottom) * cm_by_m};
    };
    std::vector<std::array<PagePoint, 3>> triangles;
    for (const auto& uvs : triangles_in(panel, part))
      triangles.push_back({on_page(uvs[0]), on_page(uvs[1]), on_page(uvs[2])});
    if (triangles.empty()) return;
    const PageBox box{corner[0], corner[1], part.width * cm_by_m, part.height * cm_by_m};
    page.begin_clip(triangles);
    page.picture(box, file_.add_picture(path_, picture(panel, part, pixel / cm_by_m)));
    page.end_clip();
    page.begin_clip(box);
    for (const auto& [from, to] : panel.rim) {
      const auto a = panel.place_m(from), b = panel.place_m(to);
      if (std::max(a[0], b[0]) >= part.left && std::min(a[0], b[0]) <= part.left + part.width &&
          std::max(a[1], b[1]) >= part.bottom && std::min(a[1], b[1]) <= part.bottom + part.height)
        page.line(on_page(from), on_page(to), 0.3);
    }
    page.end_clip();
  }

  /// Whether a part shows any paint.
  [[nodiscard]] bool is_painted(const PaintPanel& panel, const PanelPart& part) const {
    return !triangles_in(panel, part).empty();
  }

  /// Side of a pixel, metres: a quarter of a texel, so that bilinear filtering shows as in a render.
  [[nodiscard]] double pixel_m(const PaintPanel& panel) const {
    const raster::TextureLayout& layout = scene_.layout;
    return std::min(std::abs(panel.right) * layout.u_extent / static_cast<double>(layout.width),
                    panel.up / static_cast<double>(layout.height)) /
           4;
  }

 private:
  /// Faces that meet a part, by their uv.
  [[nodiscard]] std::vector<std::array<std::array<double, 2>, 3>> triangles_in(const PaintPanel& panel,
                                                                               const PanelPart& part) const {
    const raster::detail::TexelRectangle box{part.left, part.left + part.width, part.bottom,
                                             part.bottom + part.height};
    std::vector<std::array<std::array<double, 2>, 3>> found;
    for (const std::size_t face : panel.faces) {
      const std::array<std::array<double, 2>, 3> uvs{detail::uv_of(scene_.mesh, face, 0),
                                                     detail::uv_of(scene_.mesh, face, 1),
                                                     detail::uv_of(scene_.mesh, face, 2)};
      if (box.meets({panel.place_m(uvs[0]), panel.place_m(uvs[1]), panel.place_m(uvs[2])}))
        found.push_back(uvs);
    }
    return found;
  }

  /// The texture in a part, also where the panel has no face.
  [[nodiscard]] Bitmap picture(const PaintPanel& panel, const PanelPart& part, double pixel) const {
    const auto count = [&](double side) {
      return static_cast<std::size_t>(std::clamp(std::ceil(side / pixel - 1e-6), 1.0, 16000.0));
    };
    const std::size_t height = count(part.height), width = count(part.width);
    auto colours = zeros<float, 3>({height, width, 3});
    for (std::size_t row = 0; row < height; ++row)
      for (std::size_t column = 0; column < width; ++column) {
        const double right = (static_cast<double>(column) + 0.5) / static_cast<double>(width);
        const double down = (static_cast<double>(row) + 0.5) / static_cast<double>(height);
        const auto uv = panel.uv({part.left + right * part.width, part.bottom + (1 - down) * part.height});
        raster::visit_atlas_taps(scene_.layout, uv, [&](const raster::Tap& tap) {
          for (std::size_t c = 0; c < 3; ++c)
            colours(row, column, c) += static_cast<float>(tap.weight) * texels_(tap.texel, c);
        });
      }
    return image::to_bytes(scene_.space == image::ColourSpace::linear ? image::encoded(colours) : colours);
  }

  const PaintedScene& scene_;
  Array<float, 2> texels_;
  PdfFile& file_;
  std::string path_;
};

}  // namespace tapestry::shell
