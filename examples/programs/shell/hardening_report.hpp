#pragma once
#include "csv.hpp"
#include "hardening_state.hpp"
#include "report.hpp"
#include "report_page.hpp"
#include "verbosity.hpp"
#include "word_table.hpp"

namespace tapestry::shell {
/// The detector's classes of objects in drawn scenes, in the order car, van, clutter; none for
/// one that it does not know.
using SceneClasses = std::array<std::optional<std::size_t>, 3>;

/// Quality of a detector on drawn scenes.
struct ScenePrecision {
  std::optional<double> ap50;  ///< AP at IoU ≥ 0.5, mean over the classes that occur and are known
  double false_alarms = 0;     ///< a picture: boxes of the car's class above the confidence, on no vehicle
};

/// Measures a detector on labelled scenes of its input's size. A van may be called a car by a detector that
/// knows no vans.
/// \param confidence  of a false alarm
inline ScenePrecision scene_precision(const detect::Detector<float>& network, double nms, double confidence,
                                      const SceneClasses& classes,
                                      const std::vector<scenes::LabelledScene>& drawn) {
  constexpr double least_confidence = 0.001;  // low, because precision counts weak detections, too
  const std::size_t size = network.input_width();
  const std::size_t car = classes[scenes::class_car].value();
  std::vector<evaluate::TruthBox> truths;
  std::vector<evaluate::ScoredBox> found;
  std::size_t alarms = 0;
  detect::Pass<float> pass;
  Array<float, 4> batch(Extents<4>{1, size, size, 3});
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    StopSignal::throw_if_arrived();
    scenes::put_into_batch(drawn[i].colours, 0, {}, batch);
    network.forward(batch, pass);
    detect::require_finite_logits(pass.logits, "test scene " + std::to_string(i));
    for (const auto& [class_index, box] : drawn[i].truths) {
      const bool is_unknown_van = class_index == scenes::class_van && !classes[class_index];
      if (classes[class_index] || is_unknown_van)
        truths.push_back({i, classes[class_index].value_or(car), box, box.w * box.h, false, is_unknown_van});
    }
    const auto is_on_vehicle = [&](const detect::Box& box) {
      return std::ranges::any_of(drawn[i].truths, [&](const auto& truth) {
        return truth.class_index != scenes::class_clutter && detect::iou(truth.box, box) >= 0.1;
      });
    };
    for (const auto& one : network.detections(pass.logits, 0, least_confidence, nms)) {
      if (std::ranges::find(classes, std::optional(one.class_index)) == classes.end()) continue;
      found.push_back({i, one.class_index, one.box, one.confidence});
      alarms += one.class_index == car && one.confidence > confidence && !is_on_vehicle(one.box) ? 1U : 0U;
    }
  }
  return {evaluate::average_precision(truths, found, network.heads().front().classes).mean.ap50,
          static_cast<double>(alarms) / static_cast<double>(drawn.size())};
}

struct DetectorFindings {
  std::string name;                           ///< undefended or hardened
  std::vector<evaluate::Measurement> rows;    ///< by picture, see hardening_rows
  std::optional<ScenePrecision> precision{};  ///< on clean drawn scenes
};

struct HardeningReport {
  DetectorFindings undefended, hardened;
  std::size_t views = 0;
  std::size_t test_scenes = 0;
  bool held_out = false;
  std::size_t attacked_views = 0;  ///< that each measured attack was optimised on, repeats counted
  double seconds = 0;
  Json options;
};

/// The rows of a detector's table, in order, each with a description of its pictures.
inline const std::vector<std::pair<std::string, std::string>> hardening_rows{
    {"photo", "the untouched frame"},
    {"clean", "the car in its own colours, rendered"},
    {"transfer", "a paint optimised against the undefended detector"},
    {"transfer noise", "noise matched to that paint"},
    {"adaptive", "a fresh paint optimised against this very detector, with one seed and budget for both"},
    {"adaptive noise", "noise matched to that paint"},
    {"random", "random noise"}};

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

/// Views that an attack should be optimised on, repeats counted: those of the default budget over frames.
inline constexpr std::size_t enough_attacked_views = 2400;

/// One sentence: in how many views each detector finds the car under the attack made for it, and plain, and
/// what that shows.
inline std::string hardening_verdict(const HardeningReport& report) {
  const auto count = [&](const DetectorFindings& detector, const char* row) {
    return std::to_string(row_of(detector, row).rate.detected);
  };
  const auto& [undefended, hardened] = std::tie(report.undefended, report.hardened);
  const HardeningGain gain = gain_of(report);
  const std::string plain =
      count(undefended, "clean") + " undefended and " + count(hardened, "clean") + " hardened";
  if (!gain.adaptive) return "Of " + views_text(report) + ", the plain car is found in " + plain + ".";
  const auto& [low, high] = gain.adaptive->p_at_50.interval;
  const bool hides = detail::is_below(row_of(undefended, "adaptive").rate, row_of(undefended, "clean").rate);
  return "Under an attack on each, the undefended detector finds the car in " +
         count(undefended, "adaptive") + " of " + views_text(report) + ", the hardened one in " +
         count(hardened, "adaptive") + "; plain " + plain + ": " +
         (!hides     ? "no verdict, for the attack does not hide the car from the undefended one"
          : low > 0  ? "hardening withstands it better"
          : high < 0 ? "hardening withstands it worse"
                     : "no gain is shown") +
         (gain.clean.p_at_50.interval[1] < 0 ? ", and the plain car is found less often." : ".");
}

/// The table for Markdown and the page, or with the names of its rows alone.
inline WordTable hardening_table(const HardeningReport& report, bool is_explained = true) {
  WordTable table{"P@0.5 with its 95 % interval (Wilson), and the mean best confidence",
                  {"picture", "undefended", "confidence", "hardened", "confidence"}};
  for (const auto& [name, what] : hardening_rows) {
    if (std::ranges::count(report.hardened.rows, name, &evaluate::Measurement::name) == 0) continue;
    std::vector<std::string> words{is_explained ? name + ": " + what : name};
    for (const auto* detector : {&report.undefended, &report.hardened}) {
      const auto& row = row_of(*detector, name);
      words.push_back(percent_text(row.rate.p_at_50) + " " + interval_text(row.rate.interval));
      words.push_back(decimal_text(row.mean_best_confidence));
    }
    table.rows.push_back(std::move(words));
  }
  return table;
}

/// Sentences that explain the table, and what a small budget leaves open.
inline std::vector<std::string> hardening_findings(const HardeningReport& report) {
  std::vector<std::string> sentences{gain_text(report) + " (Newcombe's interval over the views)."};
  if (const auto precision = precision_text(report); !precision.empty()) sentences.push_back(precision + ".");
  const std::size_t views = report.attacked_views;
  if (views == 0 || views >= enough_attacked_views) return sentences;
  sentences.push_back("The attacks may be too short to show an effect: " + std::to_string(views) +
                      " views each, where the default takes " + std::to_string(enough_attacked_views) +
                      " or more; leave out --quick, or raise --epochs.");
  const auto &before = report.undefended.precision, &after = report.hardened.precision;
  if (before && after && before->ap50 && after->ap50 && *after->ap50 < *before->ap50)
    sentences.push_back(
        "AP can fall in a short run, whose first steps move the weights off what they had learnt while too "
        "few follow to settle them: --rounds and --steps give more, --clean-scenes more to learn from.");
  return sentences;
}

inline std::string hardening_text(const HardeningReport& report) {
  std::string text =
      hardening_verdict(report) + "\n" + views_text(report) + "; " + text_of(hardening_table(report, false));
  for (const auto& sentence : hardening_findings(report)) text += "  " + sentence + "\n";
  return text;
}

inline std::string hardening_markdown(const HardeningReport& report) {
  std::string text = "# Hardening a detector\n\n**" + hardening_verdict(report) + "**\n\nMeasured on " +
                     views_text(report) + ".\n\n" + markdown_of(hardening_table(report));
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
  page.verdict = hardening_verdict(report);
  page.findings = "<p>Measured on " + views_text(report) + ".</p>\n" + html_of(hardening_table(report));
  for (const auto& sentence : hardening_findings(report))
    page.findings += "<p>" + escaped(sentence) + "</p>\n";
  page.list = std::move(list);
  page.curves = curves_of(history);
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
      {"verdict", hardening_verdict(report)},
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
