#include "report_page.hpp"

#include "build_facts.hpp"
#include "command_line.hpp"
#include "inputs_table.hpp"
#include "page.hpp"
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
  const auto& [name, values, over] = curve;
  if (values.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax(values);
  if (lowest == highest) return {};
  const double low = lowest, high = highest;
  std::string points;
  const std::size_t stride = std::max<std::size_t>(1, values.size() / 300);
  for (std::size_t i = 0; i < values.size(); i += stride)
    points += detail::coordinate(60 + 230 * static_cast<double>(i) / static_cast<double>(values.size() - 1)) +
              "," + detail::coordinate(130 - 105 * (values[i] - low) / (high - low)) + " ";
  const auto number = [](double value) {
    return formatted(std::abs(value) >= 1000 && std::abs(value) < 1e6 ? "%.0f" : "%.3g", value);
  };
  return svg_begin(300, 150, "aria-label=\"" + escaped(name) + " over the " + over + "s\"") +
         "<rect class=\"frame\" x=\"60\" y=\"25\" width=\"230\" height=\"105\"/>" +
         svg_text(60, 16, "", name) + svg_text(56, 34, "end", number(high)) +
         svg_text(56, 130, "end", number(low)) + svg_text(60, 146, "", over + " 1") +
         svg_text(290, 146, "end", std::to_string(values.size())) + "<polyline class=\"curve\" points=\"" +
         points + "\"/></svg>\n";
}

/// The pictures of one side of the pairs as JPEGs in letters.
/// \param letters left; subtracts the used ones
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

/// The pictures of every other view or, of few views, halves of all.
ViewPictures fewer_or_smaller(const ViewPictures& pictures) {
  constexpr std::size_t few = 8;
  const bool is_few = pictures.places.size() <= few;
  ViewPictures less;
  for (const auto& [words, all] : pictures.ways) {
    auto& kept = less.ways.emplace_back(words, std::vector<MarkedPicture>()).second;
    for (std::size_t i = 0; i < all.size(); i += is_few ? 1 : 2)
      kept.push_back(is_few ? halved(all[i]) : all[i]);
  }
  for (std::size_t i = 0; i < pictures.places.size(); i += is_few ? 1 : 2)
    less.places.push_back(pictures.places[i]);
  return less;
}

/// Adds the pictures in at most so many letters: as many and as large as fit in quality 60, then as good as
/// they fit. \returns the places of those added
std::vector<std::size_t> add_pictures(Json& data, ViewPictures pictures, std::size_t most_letters) {
  constexpr std::size_t smallest_side = 64;
  constexpr int worst_quality = 60;
  for (;; pictures = fewer_or_smaller(pictures)) {
    const auto& first = pictures.ways.front().second.front().picture;
    const bool is_smallest = std::min(first.shape(0), first.shape(1)) <= smallest_side;
    for (int quality = 90; quality >= worst_quality; quality -= 10) {
      std::size_t letters =
          is_smallest && quality == worst_quality ? std::numeric_limits<std::size_t>::max() : most_letters;
      Json ways = Json::array();
      for (const auto& [words, all] : pictures.ways)
        if (auto jpegs = jpegs_within(letters, all, quality))
          ways.push_back(std::move(*jpegs));
        else
          break;
      if (ways.size() < pictures.ways.size()) continue;
      data["pictures"] = std::move(ways);
      return pictures.places;
    }
  }
}

constexpr std::size_t most_of_a_car = 1'500'000;

/// Data for the page's script: the list, with the picture of each view, pictures and the car.
/// \param bytes of the rest of the page
Json page_data(const ReportPage& page, std::size_t bytes) {
  constexpr std::size_t least_of_pictures = 400'000;
  Json data = list_json(page.list);
  data["glb"] = page.glb.size() <= most_of_a_car ? base64(page.glb) : "";
  if (page.pictures.places.empty()) return data;
  constexpr std::size_t of_punctuation = 2000;
  bytes += data.dump().size() + of_punctuation;
  const std::size_t left = most_bytes_of_a_page - std::min(bytes, most_bytes_of_a_page);
  const auto places = add_pictures(data, page.pictures, std::max(least_of_pictures, left));
  auto& views = data["views"];
  const std::size_t draws = page.list.views.size() / views.size();
  for (std::size_t i = 0; i < places.size(); ++i) views[places[i] / draws]["picture"] = i;
  return data;
}

std::string car_html(const ReportPage& page) {
  if (page.glb.empty()) return {};
  if (page.glb.size() > most_of_a_car)
    return "<h2>The car</h2>\n<p>It is too large for this page: open its .glb file, see below, in a "
           "viewer.</p>\n";
  return "<h2>The car</h2>\n<canvas id=\"car\" tabindex=\"0\" aria-label=\"the painted car; drag it or use "
         "the arrow keys to turn it\"></canvas>\n";
}

std::string boxes_html(const ViewPictures& pictures) {
  std::map<std::string, Colour> classes;
  for (const auto& [words, all] : pictures.ways)
    for (const auto& marked : all)
      for (const auto& [box, label, colour] : marked.boxes)
        if (colour != found_colour) classes[label.substr(0, label.rfind(' '))] = colour;
  const auto mark = [](const std::string& name, const Colour& c) {
    return formatted("<span><i style=\"background: #%02x%02x%02x\"></i>&#160;", c[0], c[1], c[2]) +
           escaped(name) + "</span> ";
  };
  std::string html =
      "<p class=\"boxes\">Boxes: " + mark("the car, found: of its class, with IoU 0.5 or more", found_colour);
  for (const auto& [name, colour] : classes) html += mark(name, colour);
  return html +
         "The others do not count; one of the car's class fits it too little, or frames another.</p>\n";
}

std::string pictures_html(const ViewPictures& pictures) {
  if (pictures.places.empty()) return {};
  std::string html =
      "<h2>The same view</h2>\n<p class=\"hands\"><button id=\"back\" aria-label=\"the view before\">&larr;"
      "</button> <button id=\"on\" aria-label=\"the next view\">&rarr;</button> <span id=\"chosen\"></span>"
      "</p>\n<div class=\"pictures\">\n";
  for (const auto& way : pictures.ways)
    html += "<figure><img alt=\"" + escaped(way.first) + "\"><figcaption>" + escaped(way.first) +
            "</figcaption></figure>\n";
  return html + "</div>\n" + boxes_html(pictures);
}

std::string atlases_html(const ReportPage& page) {
  if (page.atlases.empty()) return {};
  std::string html = "<h2>Paint</h2>\n<div class=\"atlases\">\n";
  for (const auto& [words, atlas] : page.atlases) {
    Bitmap shown = atlas;  // of at most 2^16 pixels
    while (shown.size() > 3 * 65536 && std::min(shown.shape(0), shown.shape(1)) > 1) shown = halved(shown);
    html += "<figure><img alt=\"" + escaped(words) + "\" src=\"data:image/png;base64," +
            base64(io::png_file("report.html", shown)) + "\"><figcaption>" + escaped(words) +
            "</figcaption></figure>\n";
  }
  return html + "</div>\n";
}
}  // namespace

std::string page_html(const ReportPage& page) {
  std::string html = page_begin(page.title, std::string(list_style) + report_style);
  if (!page.verdict.empty()) html += "<p class=\"verdict\">" + escaped(page.verdict) + "</p>\n";
  html +=
      pictures_html(page.pictures) + "<h2>Findings</h2>\n" + page.findings +
      list_html(page.list, page.pictures.places.empty() ? "" : ", an underlined name shows its pictures") +
      car_html(page) + atlases_html(page);
  std::string curves;
  for (const Curve& curve : page.curves) curves += curve_svg(curve);
  if (!curves.empty()) html += "<h2>Loss</h2>\n<div class=\"curves\">\n" + curves + "</div>\n";
  if (!page.files.empty()) {
    html += "<h2>Files beside this page</h2>\n<p>";
    for (const auto& file : page.files)
      html += "<a href=\"" + escaped(file) + "\">" + escaped(file) + "</a> ";
    html += "</p>\n";
  }
  html += "<h2>Made by</h2>\n<p>" + escaped(computed_by_text()) + ", seed " + std::to_string(page.seed) +
          ", " + std::to_string(static_cast<long>(page.seconds + 0.5)) + " s. Repeated by:</p>\n<pre>" +
          escaped(page.command) + "</pre>\n" + inputs_html(recorded_inputs());
  html += "<h2>Options</h2>\n<pre>" + escaped(report_text(page.options)) + "</pre>\n";
  const std::size_t of_script = page_end(Json()).size();
  return html + page_end(page_data(page, html.size() + of_script));
}
}  // namespace tapestry::shell
