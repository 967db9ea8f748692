#pragma once
#include "panel_drawing.hpp"
#include "print_sheet.hpp"

/// \file
/// The paint of a car as sheets to print: an index, and each panel at true size in tiles that fit the paper.

namespace tapestry::shell {
struct PanelSettings {
  std::string path;  ///< of the file
  std::string car;   ///< its name
  Paper paper = papers[0];
  double scale = 1;  ///< 1: full size
  double metres_per_unit = 1;
};

/// A picture of the car for the index, and the panels' places in it.
struct CarView {
  struct Label {
    std::size_t panel;   ///< from 0
    double right, down;  ///< shares of the picture
    std::size_t pixels;  ///< of the panel
  };
  Bitmap picture;
  std::vector<Label> labels{};
};

namespace detail {
inline constexpr double least_panel_cm = 2;

/// A panel, and where it is printed: as tiles that show paint, by row and column from 0, or whole beside
/// others.
struct PlannedPanel {
  const PaintPanel* panel;
  double width_cm, height_cm;
  TileGrid grid;
  std::vector<std::array<std::size_t, 2>> tiles{};
};

/// Panels on one sheet, with their lower left corners.
using SharedSheet = std::vector<std::pair<std::size_t, PagePoint>>;

inline bool meet(const PageBox& one, const PageBox& other) {
  return one.left < other.left + other.width && other.left < one.left + one.width &&
         one.bottom < other.bottom + other.height && other.bottom < one.bottom + one.height;
}

/// An arrow along a direction of the car on a panel, with its name; none where it points away from the panel.
inline void draw_arrow(PdfPage& page, const PagePoint& from, const std::array<double, 2>& direction,
                       const char* name, double length) {
  const double least = 0.3, head = length / 4;
  const double shown = std::hypot(direction[0], direction[1]);
  if (shown < least) return;
  const double x = direction[0] / shown, y = direction[1] / shown;
  const PagePoint to{from[0] + length * x, from[1] + length * y};
  page.line(from, to);
  for (const double side : {-0.5, 0.5})
    page.line(to, {to[0] - head * (x + side * y), to[1] - head * (y - side * x)});
  page.text({to[0] + 0.08, to[1] + 0.04}, 5, name);
}

inline void draw_arrows(PdfPage& page, const PagePoint& from, const PaintPanel& panel, double length = 0.7) {
  draw_arrow(page, from, panel.to_front, "front", length);
  draw_arrow(page, from, panel.to_top, "top", length);
}
}  // namespace detail

class PanelSheets {
 public:
  /// \param scene  with an atlas
  /// \throws Error (limit) for more than 5000 sheets, (mismatch) if no panel is as large as 2 cm
  PanelSheets(const PaintedScene& scene, const PanelSettings& settings)
      : settings_(settings),
        cm_by_m_(100 * settings.scale),
        found_(paint_panels(scene, settings.metres_per_unit)),
        drawing_(scene, file_, settings.path) {
    for (const PaintPanel& panel : found_.panels) plan(panel);
    share_sheets();
    if (planned_.empty())
      throw Error(ErrorKind::mismatch,
                  "--panels: no painted part is as large as 2 cm; --length sets the metres of the mesh, "
                  "--panel-scale those of the print");
  }

  /// The panel of each face of the mesh from 0, −1 for none.
  [[nodiscard]] std::vector<std::int32_t> panel_of_faces(std::size_t face_count) const {
    std::vector<std::int32_t> panels(face_count, -1);
    for (std::size_t i = 0; i < planned_.size(); ++i)
      for (const std::size_t face : planned_[i].panel->faces) panels[face] = static_cast<std::int32_t>(i);
    return panels;
  }

  /// The bytes of the file; called once.
  std::string drawn(const std::vector<CarView>& views) {
    add_index(views);
    for (std::size_t i = 0; i < planned_.size(); ++i)
      for (std::size_t tile = 0; tile < planned_[i].tiles.size(); ++tile) add_tile(i, tile);
    for (const detail::SharedSheet& sheet : shared_) add_shared(sheet);
    return file_.bytes();
  }

  [[nodiscard]] std::string summary() const {
    std::string text = formatted("%zu panel%s on %zu sheet%s", planned_.size(),
                                 planned_.size() == 1 ? "" : "s", sheets_, sheets_ == 1 ? "" : "s");
    if (index_pages_ > 0)
      text += formatted(" after an index of %zu page%s", index_pages_, index_pages_ == 1 ? "" : "s");
    if (small_ > 0) text += formatted(", %zu smaller than 2 cm left out", small_);
    if (found_.flat_faces > 0) text += formatted(", %zu faces without area left out", found_.flat_faces);
    return text;
  }

 private:
  void plan(const PaintPanel& panel) {
    detail::PlannedPanel planned{&panel, panel.width_m * cm_by_m_, panel.height_m * cm_by_m_, {}};
    if (planned.width_cm < detail::least_panel_cm && planned.height_cm < detail::least_panel_cm)
      return void(++small_);
    const Paper& paper = settings_.paper;
    if (planned.width_cm + 2 * around_cm <= window().width &&
        planned.height_cm + 2 * around_cm + label_cm <= window().height)
      return planned_.push_back(std::move(planned));
    planned.grid = tile_grid(planned.width_cm, planned.height_cm, paper.width, paper.height);
    const auto lying = tile_grid(planned.width_cm, planned.height_cm, paper.height, paper.width);
    if (lying.columns * lying.rows < planned.grid.columns * planned.grid.rows) planned.grid = lying;
    constexpr double most = 5000;
    if (planned.grid.columns * planned.grid.rows + static_cast<double>(sheets_) > most)
      throw Error(ErrorKind::limit,
                  formatted("--panels takes more than %.0f sheets; a panel is %.0f x %.0f cm", most,
                            planned.width_cm, planned.height_cm));
    for (std::size_t row = 0; row < static_cast<std::size_t>(planned.grid.rows); ++row)
      for (std::size_t column = 0; column < static_cast<std::size_t>(planned.grid.columns); ++column)
        if (drawing_.is_painted(panel, part_of(planned, {row, column})))
          planned.tiles.push_back({row, column});
    sheets_ += planned.tiles.size();
    planned_.push_back(std::move(planned));
  }

  [[nodiscard]] PageBox window() const {
    return TileGrid{settings_.paper.width, settings_.paper.height}.window();
  }

  /// Puts panels that fit on one sheet in rows, the highest first.
  void share_sheets() {
    std::vector<std::size_t> whole;
    for (std::size_t i = 0; i < planned_.size(); ++i)
      if (planned_[i].tiles.empty()) whole.push_back(i);
    std::ranges::stable_sort(whole, std::ranges::greater{},
                             [&](std::size_t i) { return planned_[i].height_cm; });
    const PageBox box = window();
    double left = 0, top = 0, row = 0;
    for (const std::size_t i : whole) {
      const double width = std::max(planned_[i].width_cm + 2 * around_cm, least_width_cm);
      const double height = planned_[i].height_cm + 2 * around_cm + label_cm;
      if (left + width > box.width) {  // the next row
        top += row;
        left = row = 0;
      }
      if (shared_.empty() || top + height > box.height) {
        shared_.emplace_back();
        left = top = row = 0;
      }
      shared_.back().push_back(
          {i,
           {box.left + left + around_cm, box.bottom + box.height - top - around_cm - planned_[i].height_cm}});
      left += width;
      row = std::max(row, height);
    }
    sheets_ += shared_.size();
  }

  void add_shared(const detail::SharedSheet& sheet) {
    PdfPage page(settings_.paper.width, settings_.paper.height);
    for (const auto& [i, corner] : sheet) {
      const PaintPanel& panel = *planned_[i].panel;
      const PanelPart all{0, 0, panel.width_m, panel.height_m};
      drawing_.draw(page, panel, all, corner, cm_by_m_, pixel_cm(panel));
      drawing_.draw_marks(page, panel, all, corner, cm_by_m_);
      const double baseline = corner[1] - around_cm;
      page.text({corner[0], baseline}, 8, formatted("%zu", i + 1));
      detail::draw_arrows(page, {corner[0] + 1.3, baseline}, panel);
    }
    page.text(
        {window().left + 0.3, 2.0}, 9,
        formatted("%zu panel%s, scale %.4g", sheet.size(), sheet.size() == 1 ? "" : "s", settings_.scale));
    draw_ruler(page);
    draw_colours(page);
    file_.add(std::move(page));
  }

  /// Between 200 dots an inch and steps that the eye overlooks.
  [[nodiscard]] double pixel_cm(const PaintPanel& panel) const {
    return std::clamp(drawing_.pixel_m(panel) * cm_by_m_, 0.0127, 0.1);
  }

  /// The part of a panel on a tile: the tile's window, without the area beyond the panel.
  [[nodiscard]] PanelPart part_of(const detail::PlannedPanel& planned,
                                  const std::array<std::size_t, 2>& tile) const {
    const PageBox window = planned.grid.window();
    const double left = static_cast<double>(tile[1]) * (window.width - overlap_cm);
    const double top = planned.height_cm - static_cast<double>(tile[0]) * (window.height - overlap_cm);
    const double right = std::min(left + window.width, planned.width_cm);
    const double bottom = std::max(top - window.height, 0.0);
    return {left / cm_by_m_, bottom / cm_by_m_, (right - left) / cm_by_m_, (top - bottom) / cm_by_m_};
  }

  void add_tile(std::size_t index, std::size_t number) {
    const detail::PlannedPanel& planned = planned_[index];
    const auto& tile = planned.tiles[number];
    PdfPage page(planned.grid.paper_width, planned.grid.paper_height);
    const PageBox window = planned.grid.window();
    const PanelPart part = part_of(planned, tile);
    const double bottom = window.bottom + window.height - part.height * cm_by_m_;
    drawing_.draw(page, *planned.panel, part, {window.left, bottom}, cm_by_m_, pixel_cm(*planned.panel));
    drawing_.draw_marks(page, *planned.panel, part, {window.left, bottom}, cm_by_m_);
    draw_marks(page, planned.grid, tile);
    page.text({window.left + 0.3, 2.0}, 9,
              formatted("panel %zu, tile %zu of %zu, row %zu column %zu, scale %.4g", index + 1, number + 1,
                        planned.tiles.size(), tile[0] + 1, tile[1] + 1, settings_.scale));
    detail::draw_arrows(page, {window.left + window.width - 1.2, 2.0}, *planned.panel);
    draw_ruler(page);
    draw_colours(page);
    file_.add(std::move(page));
  }

  void add_index(const std::vector<CarView>& views) {
    constexpr double margin = margin_cm;
    const Paper& paper = settings_.paper;
    PdfPage page(paper.width, paper.height);
    double top = paper.height - margin - 0.4;
    page.text({margin, top}, 12, settings_.car);
    page.text(
        {margin, top -= 0.6}, 9,
        summary() + formatted("; sheets follow this index; scale %.4g, seen from outside", settings_.scale));
    page.text({margin, top -= 0.5}, 7,
              "Print at 100 %, and check that the ruler of a sheet is 5 cm long. Cut tiles at the outer "
              "marks; the edge of the next tile lies at the inner marks.");
    page.text(
        {margin, top -= 0.35}, 7,
        "Stretch: lengths on the car over lengths on the panel, for 90 % of its area. Equal numbers beside "
        "two panels mark the same point of the car.");
    top -= 0.3;
    top -= draw_views(page, views, top);
    std::size_t pages = 1;
    double left = margin;
    for (std::size_t i = 0; i < planned_.size(); ++i) {
      const double cell_width = cell_width_of(i);
      if (left + cell_width > paper.width - margin) left = margin, top -= cell_height_cm;
      if (top - cell_height_cm < margin) {
        file_.add(std::exchange(page, PdfPage(paper.width, paper.height)));
        top = paper.height - margin;
        left = margin;
        ++pages;
      }
      draw_cell(page, i, {left, top - cell_height_cm});
      left += cell_width;
    }
    file_.add(std::move(page));
    index_pages_ = pages;
  }

  /// Centimetres of the index by metres of a panel: 2 cm high, or 5.5 cm wide.
  [[nodiscard]] double index_scale_of(std::size_t index) const {
    const PaintPanel& panel = *planned_[index].panel;
    return std::min(5.5 / panel.width_m, 2.0 / panel.height_m);
  }
  [[nodiscard]] double cell_width_of(std::size_t index) const {
    constexpr double of_words = 3, gap = 0.35;
    return std::max(of_words, planned_[index].panel->width_m * index_scale_of(index)) + gap;
  }

  void draw_cell(PdfPage& page, std::size_t index, const PagePoint& corner) {
    const auto& [panel, width_cm, height_cm, grid, tiles] = planned_[index];
    const std::size_t sheets = std::max<std::size_t>(tiles.size(), 1);
    drawing_.draw(page, *panel, {0, 0, panel->width_m, panel->height_m}, {corner[0], corner[1] + 1.8},
                  index_scale_of(index), 4.3 / 300);
    page.text({corner[0], corner[1] + 0.8}, 8, formatted("%zu", index + 1));
    page.text({corner[0], corner[1] + 0.5}, 6,
              formatted("%.1f x %.1f cm, %zu sheet%s", width_cm, height_cm, sheets, sheets == 1 ? "" : "s"));
    page.text({corner[0], corner[1] + 0.25}, 6,
              formatted("stretch %.3f to %.3f", panel->stretch[0], panel->stretch[1]));
    detail::draw_arrows(page, {corner[0] + 1.7, corner[1] + 1.1}, *panel, 0.45);
  }

  /// \returns the height that the views take
  double draw_views(PdfPage& page, const std::vector<CarView>& views, double top) {
    constexpr std::size_t columns = 2;
    const double width = (page.box().width - 2 * margin_cm) / columns, most_height = width / 2;
    double taken = 0;
    for (std::size_t i = 0; i < views.size(); i += columns) {
      double highest = 0;
      for (std::size_t k = i; k < std::min(i + columns, views.size()); ++k) {
        const Bitmap& picture = views[k].picture;
        const double shape = static_cast<double>(picture.shape(0)) / static_cast<double>(picture.shape(1));
        const double across = std::min(0.96 * width, most_height / shape), down = across * shape;
        const PageBox box{margin_cm + width * static_cast<double>(k - i), top - taken - down, across, down};
        page.picture(box, file_.add_picture(settings_.path, picture));
        draw_labels(page, views[k].labels, box);
        highest = std::max(highest, down);
      }
      taken += highest + 0.3;
    }
    return taken;
  }

  /// Draws the numbers of panels in a view: on the panel or, if another number is there, beside it
  /// with a line to the panel.
  static void draw_labels(PdfPage& page, std::vector<CarView::Label> labels, const PageBox& box) {
    std::ranges::stable_sort(labels, std::greater{}, &CarView::Label::pixels);
    std::vector<PageBox> taken;
    for (const auto& label : labels) {
      const std::string number = std::to_string(label.panel + 1);
      const double width = 0.12 * static_cast<double>(number.size()) + 0.08, height = 0.24;
      const PagePoint at{box.left + label.right * box.width, box.bottom + (1 - label.down) * box.height};
      for (int ring = 0; ring <= 24; ++ring) {  // 8 places at each of three distances
        const double angle = 0.785 * ring, far = ring == 0 ? 0 : 0.32 * (1 + (ring - 1) / 8);
        const PagePoint middle{at[0] + 1.2 * far * std::cos(angle), at[1] + far * std::sin(angle)};
        const PageBox place{middle[0] - width / 2, middle[1] - height / 2, width, height};
        if (std::ranges::any_of(taken, [&](const PageBox& other) { return detail::meet(place, other); }))
          continue;
        if (ring > 0) page.line(at, middle, 0.25);
        page.area(place, {1, 1, 1});
        page.text({place.left + 0.04, place.bottom + 0.05}, 6, number);
        taken.push_back(place);
        break;
      }
    }
  }

  PanelSettings settings_;
  double cm_by_m_;
  PaintPanels found_;
  PdfFile file_;
  PanelDrawing drawing_;
  std::vector<detail::PlannedPanel> planned_;
  std::vector<detail::SharedSheet> shared_{};
  std::size_t sheets_ = 0, small_ = 0, index_pages_ = 0;

  /// Room around panels that share a sheet, for marks, for a label, and for its arrows.
  static constexpr double around_cm = 0.9, label_cm = 0.7, least_width_cm = 4;
  static constexpr double cell_height_cm = 3.9;  ///< of the index
};
}  // namespace tapestry::shell
