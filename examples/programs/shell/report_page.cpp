#include "report_page.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/io/image_file.hpp>
#include <utility>
#include <vector>

#include "base64.hpp"
#include "build_facts.hpp"
#include "command_line.hpp"
#include "contact_sheet.hpp"
#include "page.hpp"
#include "protocol/drawing.hpp"
#include "report_script.hpp"
#include "run_folder.hpp"
#include "view_list.hpp"

namespace tapestry::shell {

std::string repeating_line(const std::string& program, const Json& settings, const Json& left_out) {
  std::vector<std::string> words{program};
  for (const auto& [name, value] : settings.items()) {
    if (left_out.contains(name) && left_out[name] == value) continue;
    if (value.is_boolean() && !value.get<bool>()) continue;
    words.push_back("--" + name);
    const auto add = [&](const Json& word) {
      words.push_back(word.is_string() ? word.get<std::string>() : word.dump());
    };
    if (value.is_array())
      for (const Json& word : value) add(word);
    else if (!value.is_boolean())
      add(value);
  }
  return shell_line(words);
}

namespace {

/// A curve with its least and greatest value; empty for a constant one.
std::string curve_svg(const Curve& curve) {
  const auto& [name, values] = curve;
  if (values.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax(values);
  if (lowest == highest) return {};
  const double low = lowest, high = highest;
  std::string points;
  const std::size_t stride = std::max<std::size_t>(1, values.size() / 300);
  for (std::size_t i = 0; i < values.size(); i += stride)
    points += detail::coordinate(50 + 240 * static_cast<double>(i) / static_cast<double>(values.size() - 1)) +
              "," + detail::coordinate(130 - 105 * (values[i] - low) / (high - low)) + " ";
  const auto number = [](double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return std::string(text.data());
  };
  return "<svg viewBox=\"0 0 300 150\" width=\"300\" role=\"img\" aria-label=\"" + escaped(name) +
         " over the steps\">\n<rect class=\"frame\" x=\"50\" y=\"25\" width=\"240\" height=\"105\"/>" +
         svg_text(50, 16, "", name) + svg_text(2, 34, "", number(high)) + svg_text(2, 130, "", number(low)) +
         svg_text(50, 146, "", "step 1") + svg_text(230, 146, "", std::to_string(values.size())) +
         "<polyline class=\"curve\" points=\"" + points + "\"/></svg>\n";
}

/// The mean of every 2 × 2 pixels.
Bitmap halved(const Bitmap& picture) {
  Bitmap small(Extents<3>{picture.shape(0) / 2, picture.shape(1) / 2, 3});
  for (std::size_t y = 0; y < small.shape(0); ++y)
    for (std::size_t x = 0; x < small.shape(1); ++x)
      for (std::size_t c = 0; c < 3; ++c)
        small(y, x, c) =
            static_cast<std::uint8_t>((picture(2 * y, 2 * x, c) + picture(2 * y + 1, 2 * x, c) +
                                       picture(2 * y, 2 * x + 1, c) + picture(2 * y + 1, 2 * x + 1, c) + 2) /
                                      4);
  return small;
}

std::string png_letters(const Bitmap& picture) { return base64(io::png_file("report.html", picture)); }

/// Pictures as base64 text, halved until each has at most `most` pixels.
Json pictures_json(const std::vector<Bitmap>& pictures, std::size_t most) {
  Json json = Json::array();
  for (Bitmap picture : pictures) {
    while (picture.shape(0) > 64 && pictures.size() * picture.shape(0) * picture.shape(1) > most)
      picture = halved(picture);
    json.push_back(png_letters(picture));
  }
  return json;
}

/// Index of a view's first picture among `shown` evenly spread ones, or −1 if none of them is shown.
std::ptrdiff_t picture_of_view(std::size_t view, std::size_t draws, std::size_t pictures, std::size_t shown) {
  for (std::size_t k = view * draws; k < (view + 1) * draws; ++k)
    if ((k + 1) * shown / pictures > k * shown / pictures)
      return static_cast<std::ptrdiff_t>(k * shown / pictures);
  return -1;
}

/// Data for the page's script: the list, with the picture of each view, pictures and the car.
Json page_data(const ReportPage& page) {
  Json data = list_json(page.list);
  const std::size_t shown = std::min(page.pairs.below.size(), page.pairs.above.size());
  const std::size_t pictures = page.list.views.size(), views = data["views"].size();
  for (std::size_t i = 0; i < views; ++i)
    data["views"][i]["picture"] = picture_of_view(i, pictures / views, pictures, shown);
  constexpr std::size_t most_pixels = 6'000'000;
  data["below"] = pictures_json(page.pairs.below, most_pixels);
  data["above"] = pictures_json(page.pairs.above, most_pixels);
  data["glb"] = base64(page.glb);
  return data;
}

}  // namespace

std::string page_html(const ReportPage& page) {
  std::string html = page_begin(page.title, std::string(list_style) + report_style) + "<p class=\"muted\">" +
                     escaped(computed_by_text()) + ", seed " + std::to_string(page.seed) + ", " +
                     std::to_string(static_cast<long>(page.seconds + 0.5)) + " s. Repeated by:</p>\n<pre>" +
                     escaped(page.command) + "</pre>\n" + page.findings;
  if (!page.pairs.below.empty() && !page.pairs.above.empty())
    html += "<h2>Two pictures of a view</h2>\n<p>Left of the line: " + escaped(page.pairs.above_words) +
            ". Right of it: " + escaped(page.pairs.below_words) +
            ". Green: the car, found. Orange: any other box. View: <span id=\"chosen\"></span></p>\n"
            "<div class=\"pair\" id=\"pair\"><img id=\"below\" alt=\"" +
            escaped(page.pairs.below_words) + "\"><img class=\"over\" id=\"above\" alt=\"" +
            escaped(page.pairs.above_words) +
            "\"></div>\n<input class=\"hands\" id=\"cut\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" "
            "aria-label=\"how far the line is to the right\">\n";
  html += list_html(page.list, ", a row shows its pictures");
  if (!page.glb.empty())
    html +=
        "<h2>The car</h2>\n<canvas id=\"car\" tabindex=\"0\" aria-label=\"the painted car; drag it or use "
        "the arrow keys to turn it\"></canvas>\n";
  if (!page.atlases.empty()) {
    html += "<h2>Paint</h2>\n<div class=\"atlases\">\n";
    for (const auto& [words, atlas] : page.atlases)
      html += "<figure><img alt=\"" + escaped(words) + "\" src=\"data:image/png;base64," +
              png_letters(atlas) + "\"><figcaption>" + escaped(words) + "</figcaption></figure>\n";
    html += "</div>\n";
  }
  std::string curves;
  for (const Curve& curve : page.curves) curves += curve_svg(curve);
  if (!curves.empty()) html += "<h2>Loss</h2>\n<div class=\"curves\">\n" + curves + "</div>\n";
  if (!page.files.empty()) {
    html += "<h2>Files beside this page</h2>\n<p>";
    for (const auto& file : page.files)
      html += "<a href=\"" + escaped(file) + "\">" + escaped(file) + "</a> ";
    html += "</p>\n";
  }
  return html + "<h2>Options</h2>\n<pre>" + escaped(report_text(page.options)) + "</pre>\n" +
         page_end(page_data(page));
}

}  // namespace tapestry::shell
