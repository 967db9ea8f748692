#pragma once
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include "formatted.hpp"
#include "run_folder.hpp"

namespace tapestry::shell {
// The result of a measurement in words.

/// Odds to three digits, or "above 100" or "below 0.01".
inline std::string odds_number(double odds) {
  return odds > 100 ? "> 100" : odds < 0.01 ? "< 0.01" : formatted("%.3g", odds);
}

/// Whether odds are known to be above a tenth or below ten; else their number means nothing.
inline bool are_readable(const evaluate::PairedRatio& odds) {
  return odds.interval[0] > 0.1 || odds.interval[1] < 10;
}

/// "3.1 [1.9, 5.2]", with a unit behind the first number; "-" for odds that are not readable.
inline std::string odds_text(const evaluate::PairedRatio& odds, const std::string& unit = "") {
  if (!are_readable(odds)) return "-";
  return odds_number(odds.ratio) + unit + " [" + odds_number(odds.interval[0]) + ", " +
         odds_number(odds.interval[1]) + "]";
}

/// The commonest names of the renamed with their pictures: "umbrella 45, kite 12, truck 4".
inline std::string new_names_text(const evaluate::FateCounts& fates, const std::vector<std::string>& names) {
  return listed(fates.commonest_names(3), [&](std::size_t k) {
    return class_name(k, names, "class ") + " " + std::to_string(fates.renamed_to[k]);
  });
}

struct FoundCar {
  evaluate::DetectionRate rate{};
  evaluate::FateCounts fates{};
};

/// Figures that a verdict is made of, all over the same views.
struct VerdictFigures {
  std::string views;  ///< what they are: "held-out views"
  FoundCar plain{}, paint{};
  std::optional<FoundCar> noise{};                     ///< matched to the paint
  std::optional<evaluate::PairedDifference> beyond{};  ///< P@0.5 with this noise minus that with the paint
  std::vector<std::string> class_names{};
};

namespace detail {
/// Fates of the pictures without a found car, each with its count: "lost in 29, misplaced in 35".
inline std::string lost_text(const FoundCar& car, const std::vector<std::string>& names) {
  using evaluate::Fate;
  std::string text;
  const auto add = [&](Fate fate, const std::string& words) {
    if (const std::size_t count = car.fates.of(fate); count > 0)
      text += (text.empty() ? "" : ", ") + words + " in " + std::to_string(count);
  };
  const std::string renamed = new_names_text(car.fates, names);
  add(Fate::lost, "lost");
  add(Fate::misplaced, "misplaced");
  add(Fate::related, "called another vehicle");
  add(Fate::renamed, "called something else");
  if (!renamed.empty()) text += " (" + renamed + ")";
  return text;
}

inline bool is_below(const evaluate::DetectionRate& one, const evaluate::DetectionRate& other) {
  return one.interval[1] < other.interval[0];
}

/// The effect of a paint by its counts, in words.
inline std::string effect_words(const VerdictFigures& figures) {
  const bool hides = is_below(figures.paint.rate, figures.plain.rate);
  if (!figures.noise || !figures.beyond)
    return hides ? "the paint hides the car; whether its design does was not measured, for want of noise of "
                   "the same colours"
                 : "no effect on how often it is found is shown";
  const auto& [low, high] = figures.beyond->interval;
  if (high < 0) return "noise of the same colours hides the car better than the design";
  if (low > 0) {
    std::string words = "the design hides the car";
    if (2 * figures.paint.rate.p_at_50 > figures.plain.rate.p_at_50) words += " in some views";
    return is_below(figures.noise->rate, figures.plain.rate) ? words + ", beyond what its colours do" : words;
  }
  const std::string nothing_shown = "no effect on how often it is found is shown";
  return hides ? "the paint hides the car, and so does noise of the same colours: " + nothing_shown
               : nothing_shown;
}
}  // namespace detail

/// One sentence: the number of views with a found car under the paint, under noise of its colours and plain,
/// and the conclusion. Without a verdict if the plain car is found in less than half of the views; states the
/// reason. Empty where nothing was measured.
inline std::string verdict_text(const VerdictFigures& figures) {
  const auto& [views, plain, paint, noise, beyond, names] = figures;
  if (plain.rate.views == 0) return {};
  const std::string of = " of " + std::to_string(plain.rate.views) + " " + views;
  const std::string lost = detail::lost_text(plain, names);
  using evaluate::Fate;
  const bool is_renamed = plain.fates.of(Fate::related) + plain.fates.of(Fate::renamed) > plain.rate.detected;
  if (2 * plain.rate.detected < plain.rate.views)
    return "No verdict: the plain car itself is found in " + std::to_string(plain.rate.detected) + of +
           " only: " + lost +
           (is_renamed ? ". Is --class right? Is --detector right?" : ". It needs no paint to be missed.");
  std::string text = "Found in " + std::to_string(paint.rate.detected) + of + " with the paint, ";
  if (noise)
    text += std::to_string(noise->rate.detected) +
            (noise->rate.views == plain.rate.views ? "" : " of " + std::to_string(noise->rate.views)) +
            " with noise of the same colours, ";
  text += std::to_string(plain.rate.detected) + " plain: " + detail::effect_words(figures);
  const std::string fates = detail::lost_text(paint, names);
  return text + (fates.empty() ? "" : "; " + fates) + ".";
}

/// Difference between two pictures of a car, over the pixels that show it: of a colour channel, in [0, 1].
struct PictureDifference {
  double mean = 0, largest = 0;
};

struct RunReport {
  evaluate::Survey survey;
  double seconds = 0;
  bool held_out = false;
  std::vector<camouflage::ObjectiveTerms> history;
  Json options;
  std::optional<PictureDifference> exported{};  ///< of the paint in the exported files, if any
  std::optional<double> noise_in_place{};       ///< see evaluate::noise_in_place()
  Json validation{};                            ///< see Validation; null without
};

Json json_of(const evaluate::Measurement& measurement);

Json json_of(const evaluate::FateCounts& fates);

/// An effect; ends of intervals that are infinite become null.
Json json_of(const evaluate::Effect& effect);

Json metrics_json(const RunReport& report);

std::string percent_text(double share);

/// A share in per cent without a sign; "-" for none.
std::string per_cent(const std::optional<double>& share);

/// AP50 and AP50:95 for a CSV; empty for none.
std::string precision_fields(const evaluate::PrecisionSummary& precision);

/// Adds AP50 and AP50:95; null for none.
void add_json(Json& json, const evaluate::PrecisionSummary& precision);

std::string decimal_text(double value);

std::vector<const evaluate::Measurement*> rows_of(const RunReport& report);

/// The rows of the table for other programs: shares and confidences in 0 to 1.
std::string metrics_csv(const RunReport& report);

std::string effect_text(const evaluate::Effect& effect);

/// How much of the camouflage its control still holds. \param share  see evaluate::noise_in_place()
std::string in_place_text(double share);

/// Explanation of the brackets in effect_text().
std::string effect_note(const evaluate::Effect& effect);

/// The verdict on a run, see verdict_text(); empty without a paint.
std::string verdict_of(const RunReport& report);

/// The verdict and the table that a run prints at its end.
std::string summary_text(const RunReport& report);
}  // namespace tapestry::shell
