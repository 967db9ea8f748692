#pragma once
#include <tapestry/camouflage/objective.hpp>

#include "run_folder.hpp"
#include "verdict.hpp"

namespace tapestry::shell {

/// Difference between two pictures of a car, over the pixels that show it: of a colour channel, in [0, 1].
struct PictureDifference {
  double mean = 0, largest = 0;
};

/// Results of a run.
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

/// Pictures of each fate.
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

/// Effect of the camouflage beyond a control, for the table and the page.
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
