#pragma once
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/evaluate/survey.hpp>
#include <vector>

#include "run_folder.hpp"
#include "verbosity.hpp"

namespace tapestry::shell {

/// What a run found out.
struct RunReport {
  evaluate::Survey survey;
  double seconds = 0;
  bool held_out = false;
  std::vector<camouflage::ObjectiveTerms> history;
  Json options;
};

inline Json json_of(const evaluate::Measurement& measurement) {
  return {{"views", measurement.rate.views / measurement.draws},
          {"pictures", measurement.rate.views},
          {"detected", measurement.rate.detected},
          {"p_at_50", measurement.rate.p_at_50},
          {"interval", measurement.rate.interval},
          {"mean_best_confidence", measurement.mean_best_confidence}};
}

/// Of an interval, what is infinite becomes null.
inline Json json_of(const evaluate::Effect& effect) {
  const auto json = [](const evaluate::PairedDifference& difference) {
    return Json{{"difference", difference.mean}, {"interval", difference.interval}};
  };
  return {{"beyond", effect.control},
          {"views", effect.best_confidence.pairs},
          {"mean_best_confidence", json(effect.best_confidence)},
          {"p_at_50", json(effect.p_at_50)}};
}

inline Json metrics_json(const RunReport& report) {
  Json controls = Json::object();
  for (const auto& control : report.survey.controls) controls[control.name] = json_of(control);
  return {{"photo", json_of(report.survey.photo)},
          {"clean", json_of(report.survey.clean)},
          {"adversarial", report.survey.adversarial ? json_of(*report.survey.adversarial) : Json()},
          {"controls", controls},
          {"asr", report.survey.asr.views > 0 ? Json(report.survey.asr.rate) : Json()},
          {"asr_views", report.survey.asr.views},
          {"asr_interval", report.survey.asr.interval},
          {"effect", report.survey.effect ? json_of(*report.survey.effect) : Json()},
          {"effect_beyond_other_run",
           report.survey.effect_beyond_other_run ? json_of(*report.survey.effect_beyond_other_run) : Json()},
          {"held_out", report.held_out},
          {"seconds", report.seconds},
          {"peak_mib", peak_mib()},
          {"seed", report.options.value("seed", std::uint64_t(0))},
          {"options", report.options}};
}

inline std::string percent_text(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", 100 * share);
  return text;
}

inline std::string decimal_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", value);
  return text;
}

inline std::vector<const evaluate::Measurement*> rows_of(const RunReport& report) {
  std::vector<const evaluate::Measurement*> rows{&report.survey.photo, &report.survey.clean};
  if (report.survey.adversarial) rows.push_back(&*report.survey.adversarial);
  for (const auto& control : report.survey.controls) rows.push_back(&control);
  return rows;
}

/// The rows of the table for other programs: shares and confidences in 0 to 1.
inline std::string metrics_csv(const RunReport& report) {
  std::string text = "picture,views,detected,p_at_50,p_at_50_low,p_at_50_high,mean_best_confidence\n";
  char line[160];
  for (const auto* row : rows_of(report)) {
    std::snprintf(line, sizeof line, "%s,%zu,%zu,%.9g,%.9g,%.9g,%.9g\n", row->name.c_str(), row->rate.views,
                  row->rate.detected, row->rate.p_at_50, row->rate.interval[0], row->rate.interval[1],
                  row->mean_best_confidence);
    text += line;
  }
  return text;
}

/// What the camouflage does beyond a control, for the table and the page.
inline std::string effect_text(const evaluate::Effect& effect) {
  char text[256];
  const auto& confidence = effect.best_confidence;
  const auto& rate = effect.p_at_50;
  std::snprintf(text, sizeof text,
                "effect beyond %s: mean best confidence %.3f [%.3f, %.3f], P@0.5 %.1f points [%.1f, %.1f]",
                effect.control.c_str(), confidence.mean, confidence.interval[0], confidence.interval[1],
                100 * rate.mean, 100 * rate.interval[0], 100 * rate.interval[1]);
  return text;
}

/// What its brackets hold.
inline std::string effect_note(const evaluate::Effect& effect) {
  return effect.control + " minus adversarial; 95 % by paired bootstrap (BCa, " +
         std::to_string(evaluate::BootstrapSettings{}.resamples) + " resamples) over " +
         std::to_string(effect.best_confidence.pairs) + " views";
}

/// The table that a run prints when it is done.
inline std::string summary_text(const RunReport& report) {
  std::string text = !report.survey.adversarial ? "views\n"
                     : report.held_out          ? "held-out views\n"
                                                : "the views that were optimised on\n";
  char line[160];
  for (const auto* row : rows_of(report)) {
    std::snprintf(
        line, sizeof line,
        "  %-13s found in %3zu of %3zu   P@0.5 %5.1f %%  (95 %%: %.1f to %.1f)   mean best confidence "
        "%.3f\n",
        row->name.c_str(), row->rate.detected, row->rate.views, 100 * row->rate.p_at_50,
        100 * row->rate.interval[0], 100 * row->rate.interval[1], row->mean_best_confidence);
    text += line;
  }
  if (const std::size_t draws = report.survey.photo.draws; draws > 1)
    text += "  (" + std::to_string(draws) + " photographs of each view; intervals count a view once)\n";
  if (!report.survey.adversarial) return text;
  if (report.survey.asr.views > 0)
    text += "  attack success " + percent_text(report.survey.asr.rate) + " of the " +
            std::to_string(report.survey.asr.views) + " views found in clean\n";
  else
    text += "  attack success is not defined: no view is found in clean\n";
  for (const auto& effect : {report.survey.effect, report.survey.effect_beyond_other_run})
    if (effect) text += "  " + effect_text(*effect) + "\n  (" + effect_note(*effect) + ")\n";
  return text;
}

inline std::string html_text(const std::string& text) {
  std::string html;
  for (const char c : text) html += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return html;
}

inline std::string html_row(const evaluate::Measurement& row) {
  return "<tr><td>" + row.name + "</td><td>" + std::to_string(row.rate.detected) + " of " +
         std::to_string(row.rate.views) + "</td><td>" + percent_text(row.rate.p_at_50) + "</td><td>" +
         percent_text(row.rate.interval[0]) + " to " + percent_text(row.rate.interval[1]) + "</td><td>" +
         decimal_text(row.mean_best_confidence) + "</td></tr>\n";
}

/// The total loss over the steps as an SVG line.
inline std::string loss_curve_svg(const std::vector<camouflage::ObjectiveTerms>& history) {
  if (history.size() < 2) return {};
  double low = history.front().total;
  double high = low;
  for (const auto& terms : history) {
    low = std::min(low, terms.total);
    high = std::max(high, terms.total);
  }
  const double range = high > low ? high - low : 1;
  std::string points;
  char point[64];
  const std::size_t stride = std::max<std::size_t>(1, history.size() / 700);
  for (std::size_t i = 0; i < history.size(); i += stride) {
    const double x = 40 + 700 * static_cast<double>(i) / static_cast<double>(history.size() - 1);
    std::snprintf(point, sizeof point, "%.1f,%.1f ", x, 170 - 160 * (history[i].total - low) / range);
    points += point;
  }
  char labels[256];
  std::snprintf(
      labels, sizeof labels,
      "<text x='2' y='14'>%.2f</text><text x='2' y='174'>%.2f</text><text x='640' y='190'>step %zu</text>",
      high, low, history.size());
  return "<svg viewBox='0 0 760 200' width='760' font-family='sans-serif' font-size='11'>" +
         std::string(labels) + "<polyline fill='none' stroke='#2060a0' points='" + points + "'/></svg>\n";
}

/// A page that shows the run: rates, pictures, the loss over time, the options.
inline std::string report_html(const RunReport& report) {
  std::string rows;
  for (const auto* row : rows_of(report)) rows += html_row(*row);
  const std::string asr = report.survey.asr.views > 0
                              ? percent_text(report.survey.asr.rate) + " of the " +
                                    std::to_string(report.survey.asr.views) + " views found in <i>clean</i>"
                              : "not defined: no view is found in <i>clean</i>";
  const std::string effect = report.survey.effect
                                 ? "<p>" + html_text(effect_text(*report.survey.effect)) + " (" +
                                       html_text(effect_note(*report.survey.effect)) + ").</p>\n"
                                 : "";
  return "<!doctype html><html lang='en'><meta charset='utf-8'><title>Camouflage run</title>\n"
         "<style>body{font:15px/1.45 sans-serif;max-width:72em;margin:2em auto;padding:0 1em}"
         "td,th{padding:.2em 1em .2em 0;text-align:left}img{max-width:100%;image-rendering:auto}"
         "pre{background:#f4f4f4;padding:1em;overflow:auto}</style>\n"
         "<h1>Camouflage run</h1>\n<p>Measured on " +
         std::string(
             report.held_out
                 ? "held-out views with held-out backgrounds."
                 : "the same views that the texture was optimised on; it says nothing about others.") +
         " A view counts as found when a box of the car's class overlaps the car by IoU &ge; 0.5; the best "
         "confidence is that of the surest such box, however low.</p>\n"
         "<table><tr><th>picture</th><th>found</th><th>P@0.5</th><th>95 % interval (Wilson)</th>"
         "<th>mean best confidence</th></tr>\n" +
         rows + "</table>\n<p>Attack success rate: " + asr + ".</p>\n" + effect +
         "<p><i>photo</i> is the untouched frame, <i>clean</i> the car in its own colours rendered "
         "and composited "
         "like every other row, so that what rendering alone does is not credited to the attack. "
         "<i>matched noise</i> has the colours and the spectrum of the optimised texture with its phases "
         "shuffled, <i>shuffled</i> its patches in other places: what they do as well, the design does "
         "not do.</p>\n"
         "<h2>Clean above, camouflaged below</h2>\n<p>Green: the car, found. Orange: any other box.</p>"
         "<img src='result.png' alt='clean and camouflaged views'>\n"
         "<h2>Clean views</h2>\n<img src='before.png' "
         "alt='clean views'>\n"
         "<h2>Camouflaged views</h2>\n<img src='after.png' alt='camouflaged views'>\n"
         "<h2>Texture, matched noise and shuffled patches</h2>\n<img src='texture.png' alt='texture atlas'>\n"
         "<img src='matched_noise.png' alt='matched noise'>\n<img src='shuffled.png' alt='shuffled "
         "patches'>\n"
         "<h2>Loss</h2>\n" +
         loss_curve_svg(report.history) + "<h2>Options</h2>\n<pre>" + html_text(report_text(report.options)) +
         "</pre></html>\n";
}

}  // namespace tapestry::shell
