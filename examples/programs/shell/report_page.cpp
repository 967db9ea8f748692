#include "report_page.hpp"

#include <tapestry/core/parallel.hpp>

#include "base64.hpp"
#include "build_facts.hpp"
#include "command_line.hpp"
#include "formatted.hpp"
#include "inputs_table.hpp"
#include "page.hpp"
#include "protocol/drawing.hpp"
#include "report_script.hpp"

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
  const auto number = [](double value) { return formatted("%.3g", value); };
  return "<svg viewBox=\"0 0 300 150\" width=\"300\" role=\"img\" aria-label=\"" + escaped(name) +
         " over the steps\">\n<rect class=\"frame\" x=\"50\" y=\"25\" width=\"240\" height=\"105\"/>" +
         svg_text(50, 16, "", name) + svg_text(2, 34, "", number(high)) + svg_text(2, 130, "", number(low)) +
         svg_text(50, 146, "", "step 1") + svg_text(230, 146, "", std::to_string(values.size())) +
         "<polyline class=\"curve\" points=\"" + points + "\"/></svg>\n";
}

/// An atlas of at most 2^16 pixels as a PNG in letters.
std::string atlas_letters(Bitmap atlas) {
  while (atlas.size() > 3 * 65536 && std::min(atlas.shape(0), atlas.shape(1)) > 1) atlas = halved(atlas);
  return base64(io::png_file("report.html", atlas));
}

/// The pictures of one side of the pairs as JPEGs in letters.
/// \param letters  that there are; takes off those used
/// \returns nothing if there are too few
std::optional<Json> jpegs_within(std::size_t& letters, const std::vector<MarkedPicture>& pictures,
                                 int quality) {
  Json json = Json::array();
  bool all_fit = true;
  const auto make = [&](std::size_t i) {
    return all_fit ? base64(io::jpeg_file("report.html", drawn(pictures[i]), quality)) : std::string();
  };
  for_each_in_order(pictures.size(), make, [&](std::size_t, std::string jpeg) {
    all_fit = all_fit && jpeg.size() <= letters;
    if (!all_fit) return;
    letters -= jpeg.size();
    json.push_back(std::move(jpeg));
  });
  return all_fit ? std::optional<Json>(std::move(json)) : std::nullopt;
}

std::vector<MarkedPicture> halved(const std::vector<MarkedPicture>& pictures) {
  std::vector<MarkedPicture> small;
  for (const auto& picture : pictures) small.push_back(halved(picture));
  return small;
}

/// Adds the pictures in at most so many letters: as large as they fit in quality 60, then as good as they
/// fit.
void add_pictures(Json& data, const PicturePairs& pairs, std::size_t most_letters) {
  constexpr std::size_t smallest_side = 64;
  constexpr int worst_quality = 60;
  const std::vector<MarkedPicture>*below = &pairs.below, *above = &pairs.above;
  std::vector<MarkedPicture> smaller_below, smaller_above;
  for (;;) {
    const bool is_smallest = below->empty() || std::min(below->front().picture.shape(0),
                                                        below->front().picture.shape(1)) <= smallest_side;
    for (int quality = 90; quality >= worst_quality; quality -= 10) {
      std::size_t letters =
          is_smallest && quality == worst_quality ? std::numeric_limits<std::size_t>::max() : most_letters;
      auto of_below = jpegs_within(letters, *below, quality);
      auto of_above = of_below ? jpegs_within(letters, *above, quality) : std::nullopt;
      if (!of_above) continue;
      data["below"] = std::move(*of_below);
      data["above"] = std::move(*of_above);
      return;
    }
    smaller_below = halved(*below);
    smaller_above = halved(*above);
    below = &smaller_below;
    above = &smaller_above;
  }
}

/// Bytes of a car that a page holds at most.
constexpr std::size_t most_of_a_car = 1'500'000;

/// Index of a view's first picture among `shown` evenly spread ones, or −1 if none of them is there.
std::ptrdiff_t picture_of_view(std::size_t view, std::size_t draws, std::size_t pictures, std::size_t shown) {
  for (std::size_t k = view * draws; k < (view + 1) * draws; ++k)
    if (is_shown(k, shown, pictures)) return static_cast<std::ptrdiff_t>(k * shown / pictures);
  return -1;
}

/// Data for the page's script: the list, with the picture of each view, pictures and the car.
/// \param bytes  that the page has beside these
Json page_data(const ReportPage& page, std::size_t bytes) {
  constexpr std::size_t least_of_pictures = 400'000;
  Json data = list_json(page.list);
  const std::size_t shown = std::min(page.pairs.below.size(), page.pairs.above.size());
  const std::size_t pictures = page.list.views.size(), views = data["views"].size();
  for (std::size_t i = 0; i < views; ++i)
    data["views"][i]["picture"] = picture_of_view(i, pictures / views, pictures, shown);
  data["glb"] = page.glb.size() <= most_of_a_car ? base64(page.glb) : "";
  constexpr std::size_t of_punctuation = 1000;
  bytes += data.dump().size() + 3 * 2 * shown + of_punctuation;
  const std::size_t left = most_bytes_of_a_page - std::min(bytes, most_bytes_of_a_page);
  add_pictures(data, page.pairs, std::max(least_of_pictures, left));
  return data;
}

/// The car to turn, or where it is.
std::string car_html(const ReportPage& page) {
  if (page.glb.empty()) return {};
  if (page.glb.size() > most_of_a_car)
    return "<h2>The car</h2>\n<p>It is too large for this page: open its .glb file, see below, in a "
           "viewer.</p>\n";
  return "<h2>The car</h2>\n<canvas id=\"car\" tabindex=\"0\" aria-label=\"the painted car; drag it or use "
         "the arrow keys to turn it\"></canvas>\n";
}

std::string pairs_html(const PicturePairs& pairs) {
  if (pairs.below.empty() || pairs.above.empty()) return {};
  return "<h2>Two pictures of a view</h2>\n<p>Left of the line: " + escaped(pairs.above_words) +
         ". Right of it: " + escaped(pairs.below_words) +
         ". Green: the car, found. Other colours: any other box, by its class. View: <span "
         "id=\"chosen\"></span></p>\n<div class=\"pair\" id=\"pair\"><img id=\"below\" alt=\"" +
         escaped(pairs.below_words) + "\"><img class=\"over\" id=\"above\" alt=\"" +
         escaped(pairs.above_words) +
         "\"></div>\n<input class=\"hands\" id=\"cut\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" "
         "aria-label=\"how far the line is to the right\">\n";
}

std::string side_by_side_html(const Bitmap& sheet) {
  if (sheet.size() == 0) return {};
  return "<h2>Side by side</h2>\n<img class=\"sheet\" alt=\"views in several paints side by side\" "
         "src=\"data:image/jpeg;base64," +
         base64(io::jpeg_file("report.html", sheet, 85)) + "\">\n";
}

std::string atlases_html(const ReportPage& page) {
  if (page.atlases.empty()) return {};
  std::string html = "<h2>Paint</h2>\n<div class=\"atlases\">\n";
  for (const auto& [words, atlas] : page.atlases)
    html += "<figure><img alt=\"" + escaped(words) + "\" src=\"data:image/png;base64," +
            atlas_letters(atlas) + "\"><figcaption>" + escaped(words) + "</figcaption></figure>\n";
  return html + "</div>\n";
}

}  // namespace

std::string page_html(const ReportPage& page) {
  std::string html = page_begin(page.title, std::string(list_style) + report_style) + "<p class=\"muted\">" +
                     escaped(computed_by_text()) + ", seed " + std::to_string(page.seed) + ", " +
                     std::to_string(static_cast<long>(page.seconds + 0.5)) + " s. Repeated by:</p>\n<pre>" +
                     escaped(page.command) + "</pre>\n" + page.findings;
  html += side_by_side_html(page.side_by_side) + pairs_html(page.pairs) +
          list_html(page.list, ", a row shows its pictures") + car_html(page) + atlases_html(page);
  std::string curves;
  for (const Curve& curve : page.curves) curves += curve_svg(curve);
  if (!curves.empty()) html += "<h2>Loss</h2>\n<div class=\"curves\">\n" + curves + "</div>\n";
  if (!page.files.empty()) {
    html += "<h2>Files beside this page</h2>\n<p>";
    for (const auto& file : page.files)
      html += "<a href=\"" + escaped(file) + "\">" + escaped(file) + "</a> ";
    html += "</p>\n";
  }
  html += inputs_html(recorded_inputs());
  html += "<h2>Options</h2>\n<pre>" + escaped(report_text(page.options)) + "</pre>\n";
  const std::size_t of_script = page_end(Json()).size();
  return html + page_end(page_data(page, html.size() + of_script));
}

}  // namespace tapestry::shell
