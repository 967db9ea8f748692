#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <tapestry/camouflage/objective_terms.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/evaluate/survey.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/version.hpp>
#include <utility>
#include <vector>

#include "base64.hpp"
#include "command_line.hpp"
#include "contact_sheet.hpp"
#include "protocol/drawing.hpp"
#include "report.hpp"
#include "report_script.hpp"

namespace tapestry::shell {

/// What the page of a run shows beside its figures. What is empty is left out.
struct ReportPage {
  std::string title;
  std::string command;                  ///< that repeats the run
  std::vector<std::string> view_names;  ///< of all views
  std::vector<Bitmap> before, after;    ///< clean and camouflaged, of evenly spread views
  std::vector<std::pair<std::string, Array<std::uint8_t, 3>>> atlases{};  ///< each with its words
  std::string glb{};                                                      ///< the bytes of a painted.glb
  std::vector<std::string> files{};                                       ///< beside the page, to link
};

/// The command line with what settings differ from those left out.
/// \param left_out  of a run without options
inline std::string repeating_line(const std::string& program, const Json& settings, const Json& left_out) {
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

namespace detail {

inline std::string html_of(const RunReport& report) {
  std::string rows;
  for (const auto* row : rows_of(report))
    rows += "<tr><td>" + escaped(row->name) + "</td><td>" + std::to_string(row->rate.detected) + " of " +
            std::to_string(row->rate.views) + "</td><td>" + percent_text(row->rate.p_at_50) + "</td><td>" +
            percent_text(row->rate.interval[0]) + " to " + percent_text(row->rate.interval[1]) + "</td><td>" +
            decimal_text(row->mean_best_confidence) + "</td></tr>\n";
  return "<div class=\"wide\"><table>\n<caption>A view counts as found when a box of the car's class "
         "overlaps "
         "the car by IoU at least 0.5; the best confidence is that of the surest such box, however "
         "low.</caption>\n<thead><tr><th scope=\"col\">picture</th><th scope=\"col\">found</th>"
         "<th scope=\"col\">P@0.5</th><th scope=\"col\">95 % interval (Wilson)</th>"
         "<th scope=\"col\">mean best confidence</th></tr></thead>\n<tbody>\n" +
         rows + "</tbody></table></div>\n";
}

/// One curve over the steps, with its least and greatest value.
inline std::string curve_svg(const std::string& name, const std::vector<camouflage::ObjectiveTerms>& history,
                             double camouflage::ObjectiveTerms::*term) {
  double low = history.front().*term, high = low;
  for (const auto& terms : history) {
    low = std::min(low, terms.*term);
    high = std::max(high, terms.*term);
  }
  if (low == high) return {};
  std::string points;
  const std::size_t stride = std::max<std::size_t>(1, history.size() / 300);
  for (std::size_t i = 0; i < history.size(); i += stride)
    points += coordinate(50 + 240 * static_cast<double>(i) / static_cast<double>(history.size() - 1)) + "," +
              coordinate(130 - 105 * (history[i].*term - low) / (high - low)) + " ";
  const auto number = [](double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return std::string(text.data());
  };
  return "<svg viewBox=\"0 0 300 150\" width=\"300\" role=\"img\" aria-label=\"" + escaped(name) +
         " over the steps\">\n<rect class=\"frame\" x=\"50\" y=\"25\" width=\"240\" height=\"105\"/>" +
         svg_text(50, 16, "", name) + svg_text(2, 34, "", number(high)) + svg_text(2, 130, "", number(low)) +
         svg_text(50, 146, "", "step 1") + svg_text(230, 146, "", std::to_string(history.size())) +
         "<polyline class=\"curve\" points=\"" + points + "\"/></svg>\n";
}

/// The mean of every 2 × 2 pixels.
inline Bitmap halved(const Bitmap& picture) {
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

inline std::string png_letters(const Bitmap& picture) { return base64(io::png_file("report.html", picture)); }

/// Pictures as letters, halved until all of them have at most `most` pixels.
inline Json pictures_json(const std::vector<Bitmap>& pictures, std::size_t most) {
  Json json = Json::array();
  for (Bitmap picture : pictures) {
    while (picture.shape(0) > 64 && pictures.size() * picture.shape(0) * picture.shape(1) > most)
      picture = halved(picture);
    json.push_back(png_letters(picture));
  }
  return json;
}

/// What the page's script reads: of each view its name, its picture and how it fared in each texture.
inline Json page_data(const RunReport& report, const ReportPage& page) {
  const auto rows = rows_of(report);
  Json data = {{"textures", Json::array()}, {"views", Json::array()}};
  for (const auto* row : rows) data["textures"].push_back(row->name);
  const std::size_t draws = report.survey.photo.draws;
  const std::size_t count = report.survey.photo.found.size() / std::max<std::size_t>(1, draws);
  const std::size_t shown = std::min(page.before.size(), page.after.size());
  for (std::size_t i = 0; i < count; ++i) {
    const bool has_picture = (i + 1) * shown / count > i * shown / count;
    Json view = {
        {"index", i},
        {"name", i * draws < page.view_names.size() ? page.view_names[i * draws] : std::to_string(i)},
        {"picture", has_picture ? Json(i * shown / count) : Json(-1)},
        {"scores", Json::array()}};
    for (const auto* row : rows) {
      double best = 0, found = 0;
      for (std::size_t k = i * draws; k < (i + 1) * draws; ++k) {
        best += row->best_confidence[k] / static_cast<double>(draws);
        found += row->found[k] ? 1 / static_cast<double>(draws) : 0;
      }
      view["scores"].push_back({best, found});
    }
    data["views"].push_back(view);
  }
  constexpr std::size_t most_pixels = 6'000'000;
  data["before"] = pictures_json(page.before, most_pixels);
  data["after"] = pictures_json(page.after, most_pixels);
  data["glb"] = base64(page.glb);
  return data;
}

/// Text that ends no script, whatever it holds.
inline std::string within_script(std::string text) {
  std::string safe;
  for (const char c : text) safe += c == '<' ? "\\u003c" : std::string(1, c);
  return safe;
}

}  // namespace detail

/// A page that shows a run and needs nothing else, no file and no network: rates, what is the design's, each
/// view in a list that sorts and filters, two pictures of a view over each other, the car to turn, the paint,
/// the loss over time, the options, the command that repeats the run, and links to the files beside it.
inline std::string report_html(const RunReport& report, const ReportPage& page) {
  const auto& survey = report.survey;
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>" +
      escaped(page.title) + "</title>\n<style>\n" + report_style + "</style></head><body>\n<h1>" +
      escaped(page.title) + "</h1>\n<p class=\"muted\">Tapestry " TAPESTRY_VERSION_TEXT ", seed " +
      std::to_string(report.options.value("seed", std::uint64_t(0))) + ", " +
      std::to_string(static_cast<long>(report.seconds + 0.5)) + " s. Repeated by:</p>\n<pre>" +
      escaped(page.command) + "</pre>\n<p>Measured on " +
      (report.held_out ? "held-out views with held-out backgrounds."
                       : "the same views that the texture was optimised on; it says nothing about others.") +
      "</p>\n" + detail::html_of(report);
  if (survey.adversarial)
    html += "<p>Attack success rate: " +
            (survey.asr.views > 0 ? percent_text(survey.asr.rate) + " of the " +
                                        std::to_string(survey.asr.views) + " views found"
                                  : std::string("not defined: no view is found")) +
            " in <i>clean</i>.</p>\n";
  for (const auto& effect : {survey.effect, survey.effect_beyond_other_run})
    if (effect)
      html +=
          "<p><b>" + escaped(effect_text(*effect)) + "</b> (" + escaped(effect_note(*effect)) + ").</p>\n";
  html +=
      "<p><i>photo</i> is the untouched frame, <i>clean</i> the car in its own colours rendered and "
      "composited "
      "like every other row, so that what rendering alone does is not credited to the attack. <i>matched "
      "noise</i> has the colours and the spectrum of the optimised texture with its phases shuffled, "
      "<i>shuffled</i> its patches in other places: what they do as well, the design does not do.</p>\n";
  if (!page.before.empty() && !page.after.empty())
    html +=
        "<h2>Clean and camouflaged</h2>\n<p>The camouflaged picture lies over the clean one, up to the line. "
        "Green: the car, found. Orange: any other box. View: <span id=\"chosen\"></span></p>\n"
        "<div class=\"pair\" id=\"pair\"><img id=\"below\" alt=\"the view with the car in its own colours\">"
        "<img class=\"over\" id=\"above\" alt=\"the same view with the camouflage\"></div>\n"
        "<input class=\"hands\" id=\"cut\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" "
        "aria-label=\"how much of the camouflaged picture is shown\">\n";
  html +=
      "<h2>Views</h2>\n<p class=\"hands\"><label>name <input id=\"search\" type=\"search\"></label> "
      "<label>show <select id=\"only\"><option value=\"\">all</option></select></label> "
      "<span id=\"count\"></span></p>\n<div class=\"wide list\"><table id=\"views\"><caption>Best confidence "
      "of "
      "each view; a heading sorts, a row shows its pictures.</caption></table></div>\n";
  if (!page.glb.empty())
    html +=
        "<h2>The car</h2>\n<canvas id=\"car\" tabindex=\"0\" aria-label=\"the painted car; drag it or use "
        "the arrow keys to turn it\"></canvas>\n";
  if (!page.atlases.empty()) {
    html += "<h2>Paint</h2>\n<div class=\"atlases\">\n";
    for (const auto& [words, atlas] : page.atlases)
      html += "<figure><img alt=\"" + escaped(words) + "\" src=\"data:image/png;base64," +
              detail::png_letters(atlas) + "\"><figcaption>" + escaped(words) + "</figcaption></figure>\n";
    html += "</div>\n";
  }
  if (report.history.size() > 1) {
    html += "<h2>Loss</h2>\n<div class=\"curves\">\n";
    for (const auto& [name, term] : camouflage::ObjectiveTerms::all)
      html += detail::curve_svg(name, report.history, term);
    html += "</div>\n";
  }
  if (!page.files.empty()) {
    html += "<h2>Files beside this page</h2>\n<p>";
    for (const auto& file : page.files)
      html += "<a href=\"" + escaped(file) + "\">" + escaped(file) + "</a> ";
    html += "</p>\n";
  }
  return html + "<h2>Options</h2>\n<pre>" + escaped(report_text(report.options)) +
         "</pre>\n<script type=\"application/json\" id=\"data\">" +
         detail::within_script(detail::page_data(report, page).dump()) + "</script>\n<script>\n" +
         report_script + "</script>\n</body></html>\n";
}

}  // namespace tapestry::shell
