#pragma once
#include "mesh_views.hpp"
#include "paint_panels.hpp"
#include "pdf_file.hpp"

namespace tapestry::shell {
/// A part of a panel, metres from the panel's lower left corner.
struct PanelPart {
  double left = 0, bottom = 0, width = 0, height = 0;
};

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
    const auto on_page = [&](const PaintPanel::Place& place) {
      return PagePoint{corner[0] + (place[0] - part.left) * cm_by_m,
                       corner[1] + (place[1] - part.bottom) * cm_by_m};
    };
    const auto faces = faces_in(panel, part);
    if (faces.empty()) return;
    std::vector<std::array<PagePoint, 3>> triangles;
    for (const std::size_t i : faces) {
      const auto& [a, b, c] = panel.places_m[i];
      triangles.push_back({on_page(a), on_page(b), on_page(c)});
    }
    const PageBox box{corner[0], corner[1], part.width * cm_by_m, part.height * cm_by_m};
    page.begin_clip(triangles);
    page.picture(box, file_.add_picture(path_, picture(panel, faces, part, pixel / cm_by_m)));
    page.end_clip();
    page.begin_clip(box);
    for (const auto& edge : panel.rim) {
      const auto [from, to] = panel.ends_m(edge);
      if (std::max(from[0], to[0]) >= part.left && std::min(from[0], to[0]) <= part.left + part.width &&
          std::max(from[1], to[1]) >= part.bottom && std::min(from[1], to[1]) <= part.bottom + part.height)
        page.line(on_page(from), on_page(to), 0.3);
    }
    page.end_clip();
  }

  /// Draws the marks of a part: a stroke across the rim, and its number outside.
  void draw_marks(PdfPage& page, const PaintPanel& panel, const PanelPart& part, const PagePoint& corner,
                  double cm_by_m) const {
    constexpr double stroke = 0.25, text_pt = 6;
    for (const auto& [number, place, inwards] : panel.marks) {
      const double right = place[0] - part.left, up = place[1] - part.bottom;
      if (right < 0 || right > part.width || up < 0 || up > part.height) continue;
      const PagePoint at{corner[0] + right * cm_by_m, corner[1] + up * cm_by_m};
      page.line({at[0] - stroke * inwards[0], at[1] - stroke * inwards[1]},
                {at[0] + stroke * inwards[0], at[1] + stroke * inwards[1]}, 0.8);
      page.text({at[0] - 0.45 * inwards[0] - 0.1, at[1] - 0.45 * inwards[1] - 0.07}, text_pt,
                std::to_string(number));
    }
  }

  [[nodiscard]] bool is_painted(const PaintPanel& panel, const PanelPart& part) const {
    return !faces_in(panel, part).empty();
  }

  /// Side of a pixel, metres: a quarter of a texel on average, so that bilinear filtering shows as in a
  /// render.
  [[nodiscard]] double pixel_m(const PaintPanel& panel) const {
    const raster::TextureLayout& layout = scene_.layout;
    double texels = 0;
    for (const std::size_t face : panel.faces) {
      const auto a = detail::uv_of(scene_.mesh, face, 0), b = detail::uv_of(scene_.mesh, face, 1),
                 c = detail::uv_of(scene_.mesh, face, 2);
      texels += std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2 *
                static_cast<double>(layout.width * layout.height) / layout.u_extent;
    }
    return std::sqrt(panel.area_m2 / std::max(texels, 1.0)) / 4;
  }

 private:
  /// Faces that meet a part, by their place in the panel.
  [[nodiscard]] static std::vector<std::size_t> faces_in(const PaintPanel& panel, const PanelPart& part) {
    const raster::detail::TexelRectangle box{part.left, part.left + part.width, part.bottom,
                                             part.bottom + part.height};
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < panel.faces.size(); ++i)
      if (box.meets(panel.places_m[i])) found.push_back(i);
    return found;
  }

  /// The paint of a part. Pixels beside a face have its colours, too, since the clip cuts through them.
  [[nodiscard]] Bitmap picture(const PaintPanel& panel, const std::vector<std::size_t>& faces,
                               const PanelPart& part, double pixel) const {
    const auto count = [&](double side) {
      return static_cast<std::size_t>(std::clamp(std::ceil(side / pixel - 1e-6), 1.0, 16000.0));
    };
    const std::size_t height = count(part.height), width = count(part.width);
    auto colours = filled<float, 3>({height, width, 3}, 1.0F);
    Array<std::uint8_t, 2> is_inside = zeros<std::uint8_t, 2>({height, width});
    const double across = static_cast<double>(width) / part.width,
                 down = static_cast<double>(height) / part.height;
    for (const std::size_t i : faces) {
      std::array<PaintPanel::Place, 3> at{};  // pixels from the upper left corner
      for (std::size_t k = 0; k < 3; ++k)
        at[k] = {(panel.places_m[i][k][0] - part.left) * across,
                 (part.bottom + part.height - panel.places_m[i][k][1]) * down};
      draw_face(panel.faces[i], at, is_inside, colours);
    }
    return image::to_bytes(scene_.space == image::ColourSpace::linear ? image::encoded(colours) : colours);
  }

  void draw_face(std::size_t face, const std::array<PaintPanel::Place, 3>& at,
                 Array<std::uint8_t, 2>& is_inside, Array<float, 3>& colours) const {
    constexpr double reach = 1.5;  // pixels
    const auto range = [&](std::size_t axis, std::size_t count) {
      const auto [low, high] = std::minmax({at[0][axis], at[1][axis], at[2][axis]});
      const auto clamped = [&](double value) {
        return static_cast<std::size_t>(std::clamp(value, 0.0, static_cast<double>(count)));
      };
      return std::pair(clamped(std::floor(low - reach)), clamped(std::ceil(high + reach)));
    };
    const auto [left, right] = range(0, colours.shape(1));
    const auto [top, bottom] = range(1, colours.shape(0));
    std::array<std::array<double, 2>, 3> slopes{};  // of the barycentrics
    for (std::size_t k = 0; k < 3; ++k)
      slopes[k] = detail::slope_of(at, {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0});
    for (std::size_t row = top; row < bottom; ++row)
      for (std::size_t column = left; column < right; ++column) {
        const double x = static_cast<double>(column) + 0.5 - at[0][0],
                     y = static_cast<double>(row) + 0.5 - at[0][1];
        double outside = 0;  // pixels
        std::array<double, 2> uv{};
        for (std::size_t k = 0; k < 3; ++k) {
          const double share = (k == 0 ? 1 : 0) + slopes[k][0] * x + slopes[k][1] * y;
          outside = std::max(outside, -share / std::hypot(slopes[k][0], slopes[k][1]));
          const auto corner = detail::uv_of(scene_.mesh, face, k);
          uv = {uv[0] + share * corner[0], uv[1] + share * corner[1]};
        }
        if (!(outside <= reach) || (outside > 0 && is_inside(row, column) != 0)) continue;
        is_inside(row, column) = outside > 0 ? 0 : 1;
        std::array<float, 3> colour{};
        raster::visit_atlas_taps(scene_.layout, uv, [&](const raster::Tap& tap) {
          for (std::size_t c = 0; c < 3; ++c)
            colour[c] += static_cast<float>(tap.weight) * texels_(tap.texel, c);
        });
        for (std::size_t c = 0; c < 3; ++c) colours(row, column, c) = colour[c];
      }
  }

  const PaintedScene& scene_;
  Array<float, 2> texels_;
  PdfFile& file_;
  std::string path_;
};
}  // namespace tapestry::shell
