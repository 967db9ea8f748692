#pragma once

#include "csv.hpp"
#include "hardening_state.hpp"
#include "report.hpp"
#include "report_page.hpp"
#include "scene_precision.hpp"
#include "verbosity.hpp"
#include "word_table.hpp"

namespace tapestry::shell {

/// One detector in the same held-out views.
struct DetectorFindings {
  std::string name;                           ///< undefended or hardened
  std::vector<evaluate::Measurement> rows;    ///< by picture, see hardening_rows()
  std::optional<ScenePrecision> precision{};  ///< on clean drawn scenes
};

/// Results of a hardening.
struct HardeningReport {
  DetectorFindings undefended, hardened;
  std::size_t views = 0;
  std::size_t test_scenes = 0;
  bool held_out = false;
  double seconds = 0;
  Json options;
};

/// The rows of a detector's table, in order, each with a description of its pictures.
inline const std::vector<std::pair<std::string, std::string>>& hardening_rows() {
  static const std::vector<std::pair<std::string, std::string>> rows{
      {"photo", "the untouched frame"},
      {"clean", "the car in its own colours, rendered"},
      {"transfer", "a paint optimised against the undefended detector"},
      {"transfer noise", "noise matched to that paint"},
      {"adaptive", "a fresh paint optimised against this very detector, with one seed and budget for both"},
      {"adaptive noise", "noise matched to that paint"},
      {"random", "random noise"}};
  return rows;
}

/// The rows that were measured.
inline std::vector<std::pair<std::string, std::string>> rows_of(const HardeningReport& report) {
  auto rows = hardening_rows();
  std::erase_if(rows, [&](const auto& row) {
    return std::ranges::find(report.hardened.rows, row.first, &evaluate::Measurement::name) ==
           report.hardened.rows.end();
  });
  return rows;
}

inline const evaluate::Measurement& row_of(const DetectorFindings& detector, const std::string& name) {
  for (const auto& row : detector.rows)
    if (row.name == name) return row;
  throw DomainError("hardening report: no row " + name);
}

/// Points of P@0.5 that the hardened detector finds more under its adaptive attack than the undefended one
/// under its own, and the same of clean renders; intervals of the views, see evaluate::effect_beyond().
struct HardeningGain {
  std::optional<evaluate::Effect> adaptive;  ///< if attacks were measured
  evaluate::Effect clean;
};

inline HardeningGain gain_of(const HardeningReport& report) {
  const auto gain = [&](const char* row) {
    return evaluate::effect_beyond(row_of(report.hardened, row), row_of(report.undefended, row));
  };
  HardeningGain both{std::nullopt, gain("clean")};
  for (const auto& row : report.hardened.rows)
    if (row.name == "adaptive") both.adaptive = gain("adaptive");
  return both;
}

inline std::string gain_text(const HardeningReport& report) {
  const auto text = [](const evaluate::Effect& effect) {
    return formatted("%+.1f points ", 100 * effect.p_at_50.mean) + interval_text(effect.p_at_50.interval);
  };
  const HardeningGain gain = gain_of(report);
  return "hardened minus undefended: P@0.5 " +
         (gain.adaptive ? "under the adaptive attack " + text(*gain.adaptive) + ", " : std::string()) +
         "clean " + text(gain.clean);
}

inline std::string precision_text(const HardeningReport& report) {
  const auto &before = report.undefended.precision, &after = report.hardened.precision;
  if (!before || !after) return {};
  std::string text = formatted("on %zu clean drawn scenes: ", report.test_scenes);
  if (before->ap50 && after->ap50)
    text += formatted("AP at IoU 0.5 undefended %.3f, hardened %.3f; ", *before->ap50, *after->ap50);
  return text + formatted("false alarms a picture undefended %.2f, hardened %.2f", before->false_alarms,
                          after->false_alarms);
}

inline std::string views_text(const HardeningReport& report) {
  return std::to_string(report.views) +
         (report.held_out ? " held-out views" : " views, the same that were trained on");
}

/// The table as it is printed.
inline std::string hardening_text(const HardeningReport& report) {
  std::string text = views_text(report) + "; P@0.5 (95 %), mean best confidence\n";
  const char* const line = "  %-15s %-32s %s\n";
  text += formatted(line, "", "undefended", "hardened");
  for (const auto& named : rows_of(report)) {
    const auto cell = [&](const DetectorFindings& detector) {
      const auto& row = row_of(detector, named.first);
      return formatted("%5.1f %% (%.1f to %.1f)  %.3f", 100 * row.rate.p_at_50, 100 * row.rate.interval[0],
                       100 * row.rate.interval[1], row.mean_best_confidence);
    };
    text +=
        formatted(line, named.first.c_str(), cell(report.undefended).c_str(), cell(report.hardened).c_str());
  }
  text += "  " + gain_text(report) + "\n";
  if (const auto precision = precision_text(report); !precision.empty()) text += "  " + precision + "\n";
  return text;
}

/// The table for Markdown and the page.
inline WordTable hardening_table(const HardeningReport& report) {
  WordTable table{"P@0.5 with its 95 % interval (Wilson), and the mean best confidence",
                  {"picture", "undefended", "confidence", "hardened", "confidence"}};
  for (const auto& [name, what] : rows_of(report)) {
    std::vector<std::string> words{name + ": " + what};
    for (const auto* detector : {&report.undefended, &report.hardened}) {
      const auto& row = row_of(*detector, name);
      words.push_back(percent_text(row.rate.p_at_50) + " " + interval_text(row.rate.interval));
      words.push_back(decimal_text(row.mean_best_confidence));
    }
    table.rows.push_back(std::move(words));
  }
  return table;
}

/// Sentences that explain the table.
inline std::vector<std::string> hardening_findings(const HardeningReport& report) {
  std::vector<std::string> sentences{gain_text(report) + " (Newcombe's interval over the views)."};
  if (const auto precision = precision_text(report); !precision.empty()) sentences.push_back(precision + ".");
  return sentences;
}

inline std::string hardening_markdown(const HardeningReport& report) {
  std::string text = "# Hardening a detector\n\nMeasured on " + views_text(report) + ".\n\n" +
                     markdown_of(hardening_table(report));
  for (const auto& sentence : hardening_findings(report)) text += sentence + "\n\n";
  text.pop_back();
  return text;
}

/// All rows of both detectors, each named with its detector.
/// \param report  must outlive the list
inline ViewList list_of(const HardeningReport& report, std::vector<ViewFacts> views) {
  ViewList list{std::move(views), {}, "hardened: adaptive"};
  for (const auto* detector : {&report.undefended, &report.hardened})
    for (const auto& row : detector->rows)
      list.measurements.emplace_back(detector->name + ": " + row.name, &row);
  return list;
}

/// The page of a hardening, without its pictures, paint, car and files.
/// \param report  must outlive the page
inline ReportPage page_of(const HardeningReport& report, std::string command, ViewList list,
                          const std::vector<HardeningStep>& history) {
  ReportPage page{"Hardening a detector", std::move(command), report.options.value("seed", std::uint64_t(0)),
                  report.seconds};
  page.findings = "<p>Measured on " + views_text(report) + ".</p>\n" + html_of(hardening_table(report));
  for (const auto& sentence : hardening_findings(report))
    page.findings += "<p>" + escaped(sentence) + "</p>\n";
  page.list = std::move(list);
  for (const auto& number : HardeningStep::all) {
    page.curves.push_back({number.name, {}});
    for (const auto& step : history) page.curves.back().values.push_back(step.*number.value);
  }
  page.options = report.options;
  return page;
}

/// One line for each detector and picture, for other programs: shares and confidences in 0 to 1.
inline std::string hardening_csv(const HardeningReport& report) {
  std::string text =
      "detector,picture,views,detected,p_at_50,p_at_50_low,p_at_50_high,mean_best_confidence\n";
  for (const auto* detector : {&report.undefended, &report.hardened})
    for (const auto& row : detector->rows)
      text += csv_line(detector->name, row.name, row.rate.views, row.rate.detected, row.rate.p_at_50,
                       row.rate.interval, row.mean_best_confidence) +
              "\n";
  return text;
}

inline Json json_of(const DetectorFindings& detector) {
  Json rows = Json::object();
  for (const auto& row : detector.rows) rows[row.name] = json_of(row);
  Json json{{"pictures", rows}, {"ap50", nullptr}, {"false_alarms_a_picture", nullptr}};
  if (!detector.precision) return json;
  if (detector.precision->ap50) json["ap50"] = *detector.precision->ap50;
  json["false_alarms_a_picture"] = detector.precision->false_alarms;
  return json;
}

inline Json hardening_json(const HardeningReport& report) {
  const HardeningGain gain = gain_of(report);
  const auto json = [](const evaluate::Effect& effect) {
    Json differences = json_of(effect);
    differences.erase("beyond");
    return differences;
  };
  return {
      {"undefended", json_of(report.undefended)},
      {"hardened", json_of(report.hardened)},
      {"gain", {{"adaptive", gain.adaptive ? json(*gain.adaptive) : Json()}, {"clean", json(gain.clean)}}},
      {"held_out", report.held_out},
      {"test_scenes", report.test_scenes},
      {"seconds", report.seconds},
      {"peak_mib", peak_mib()},
      {"computed_by", computed_by_json()},
      {"options", report.options}};
}

}  // namespace tapestry::shell
