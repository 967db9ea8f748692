#include "report.hpp"

#include "csv.hpp"
#include "verbosity.hpp"

namespace tapestry::shell {
Json json_of(const evaluate::FateCounts& fates) {
  Json json = Json::object();
  for (std::size_t i = 0; i < fates.pictures.size(); ++i) json[evaluate::fate_names[i]] = fates.pictures[i];
  return json;
}

Json json_of(const evaluate::Measurement& measurement) {
  const auto& renamed_to = measurement.fates.renamed_to;
  Json fates = json_of(measurement.fates), names = Json::object();
  for (const std::size_t k : measurement.fates.commonest_names(renamed_to.size()))
    names[class_name(k, measurement.class_names, "class ")] = renamed_to[k];
  fates["renamed_to"] = names;
  Json json{{"views", measurement.rate.views / measurement.draws},
            {"pictures", measurement.rate.views},
            {"detected", measurement.rate.detected},
            {"fates", fates},
            {"p_at_50", measurement.rate.p_at_50},
            {"interval", measurement.rate.interval},
            {"mean_best_confidence", measurement.mean_best_confidence}};
  add_json(json, measurement.precision);
  return json;
}

Json json_of(const evaluate::Effect& effect) {
  const auto json = [](const evaluate::PairedDifference& difference) {
    return Json{{"difference", difference.mean}, {"interval", difference.interval}};
  };
  Json all = {{"beyond", effect.control},
              {"views", effect.best_confidence.pairs},
              {"mean_best_confidence", json(effect.best_confidence)},
              {"p_at_50", json(effect.p_at_50)},
              {"odds_ratio", effect.odds_ratio.ratio},
              {"odds_ratio_interval", effect.odds_ratio.interval}};
  if (effect.draws > 1) {
    all["draws"] = effect.draws;
    all["draws_at_most"] = effect.draws_at_most;
  }
  return all;
}

Json metrics_json(const RunReport& report) {
  Json controls = Json::object();
  for (const auto& control : report.survey.controls) controls[control.name] = json_of(control);
  Json exported;
  if (report.exported)
    exported = {{"mean_difference", report.exported->mean}, {"largest_difference", report.exported->largest}};
  return {{"verdict", verdict_of(report)},
          {"photo", json_of(report.survey.photo)},
          {"clean", json_of(report.survey.clean)},
          {"adversarial", report.survey.adversarial ? json_of(*report.survey.adversarial) : Json()},
          {"controls", controls},
          {"asr", report.survey.asr.views > 0 ? Json(report.survey.asr.rate) : Json()},
          {"asr_views", report.survey.asr.views},
          {"asr_interval", report.survey.asr.interval},
          {"effect", report.survey.effect ? json_of(*report.survey.effect) : Json()},
          {"effect_beyond_other_run",
           report.survey.effect_beyond_other_run ? json_of(*report.survey.effect_beyond_other_run) : Json()},
          {"noise_in_place", report.noise_in_place ? Json(*report.noise_in_place) : Json()},
          {"exported_paint", exported},
          {"validation", report.validation},
          {"held_out", report.held_out},
          {"seconds", report.seconds},
          {"peak_mib", peak_mib()},
          {"computed_by", computed_by_json()},
          {"seed", report.options.value("seed", std::uint64_t(0))},
          {"options", report.options}};
}

std::string percent_text(double share) { return fixed(100 * share, 1) + " %"; }

std::string per_cent(const std::optional<double>& share) { return share ? fixed(100 * *share, 1) : "-"; }

std::string precision_fields(const evaluate::PrecisionSummary& precision) {
  const auto field = [](const auto& share) { return share ? csv_line(*share) : std::string(); };
  return field(precision.ap50) + "," + field(precision.ap);
}

void add_json(Json& json, const evaluate::PrecisionSummary& precision) {
  const auto value = [](const auto& share) { return share ? Json(*share) : Json(); };
  json["ap50"] = value(precision.ap50);
  json["ap"] = value(precision.ap);
}

std::string decimal_text(double value) { return fixed(value, 3); }

std::vector<const evaluate::Measurement*> rows_of(const RunReport& report) {
  std::vector<const evaluate::Measurement*> rows{&report.survey.photo, &report.survey.clean};
  if (report.survey.adversarial) rows.push_back(&*report.survey.adversarial);
  for (const auto& control : report.survey.controls) rows.push_back(&control);
  return rows;
}

std::string metrics_csv(const RunReport& report) {
  std::string text =
      "picture,views,detected,p_at_50,p_at_50_low,p_at_50_high,mean_best_confidence,found,related,renamed,"
      "misplaced,lost,ap50,ap\n";
  for (const auto* row : rows_of(report))
    text += csv_line(row->name, row->rate.views, row->rate.detected, row->rate.p_at_50, row->rate.interval,
                     row->mean_best_confidence, row->fates.pictures, precision_fields(row->precision)) +
            "\n";
  return text;
}

std::string effect_text(const evaluate::Effect& effect) {
  const auto& confidence = effect.best_confidence;
  const auto& rate = effect.p_at_50;
  return "effect beyond " + effect.control + ": mean best confidence " + fixed(confidence.mean, 3) + " " +
         interval_text(confidence.interval, 1, 3) + ", P@0.5 " + fixed(100 * rate.mean, 1) + " points " +
         interval_text(rate.interval) +
         (are_readable(effect.odds_ratio) ? ", odds of being found " + odds_text(effect.odds_ratio, " times")
                                          : std::string());
}

std::string in_place_text(double share) {
  return "of the matched noise's values " + percent_text(share) + " are the camouflage's own at their places";
}

std::string effect_note(const evaluate::Effect& effect) {
  return effect.control + " minus adversarial; 95 % by paired bootstrap (BCa, " +
         std::to_string(evaluate::BootstrapSettings{}.resamples) + " resamples, Student's t) over " +
         std::to_string(effect.best_confidence.pairs) +
         " views, of P@0.5 by Newcombe's method, of odds by Wilson's";
}

namespace {
/// A line of the table with the fates of a car that is not always found; empty if it always is.
std::string fates_line(const evaluate::Measurement& row) {
  using evaluate::Fate;
  if (row.fates.of(Fate::found) == row.fates.all()) return {};
  std::string text(16, ' ');
  text += "else related " + std::to_string(row.fates.of(Fate::related)) + ", renamed " +
          std::to_string(row.fates.of(Fate::renamed));
  if (const std::string names = new_names_text(row.fates, row.class_names); !names.empty())
    text += " (" + names + ")";
  return text + ", misplaced " + std::to_string(row.fates.of(Fate::misplaced)) + ", lost " +
         std::to_string(row.fates.of(Fate::lost)) + "\n";
}
}  // namespace

std::string verdict_of(const RunReport& report) {
  const auto& survey = report.survey;
  if (!survey.adversarial) return {};
  const auto found = [](const evaluate::Measurement& row) { return FoundCar{row.rate, row.fates}; };
  VerdictFigures figures{(survey.photo.draws > 1 ? "photographs of " : "") +
                             std::string(report.held_out ? "held-out views" : "views (those optimised on)"),
                         found(survey.clean), found(*survey.adversarial)};
  figures.class_names = survey.clean.class_names;
  for (const auto& control : survey.controls)
    if (control.name == evaluate::matched_noise_name) figures.noise = found(control);
  if (survey.effect) figures.beyond = survey.effect->p_at_50;
  return verdict_text(figures);
}

std::string summary_text(const RunReport& report) {
  std::string text = verdict_of(report);
  text += !report.survey.adversarial ? "views\n"
          : report.held_out          ? "\nheld-out views\n"
                                     : "\nthe views that were optimised on\n";
  for (const auto* row : rows_of(report)) {
    text += formatted(
        "  %-13s found in %3zu of %3zu   P@0.5 %5.1f %%  (95 %%: %.1f to %.1f)   AP50 %s, AP50:95 %s %%   "
        "mean "
        "best confidence %.3f\n",
        row->name.c_str(), row->rate.detected, row->rate.views, 100 * row->rate.p_at_50,
        100 * row->rate.interval[0], 100 * row->rate.interval[1], per_cent(row->precision.ap50).c_str(),
        per_cent(row->precision.ap).c_str(), row->mean_best_confidence);
    text += fates_line(*row);
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
  if (report.noise_in_place) text += "  " + in_place_text(*report.noise_in_place) + "\n";
  return text;
}
}  // namespace tapestry::shell
