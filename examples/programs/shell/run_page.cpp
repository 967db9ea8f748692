#include "run_page.hpp"

#include "verbosity.hpp"
#include "word_table.hpp"

namespace tapestry::shell {
namespace {
WordTable table_of(const RunReport& report) {
  WordTable table{
      "A view counts as found when a box of the car's class overlaps the car by IoU at least 0.5; the best "
      "confidence is that of the surest such box, however low, before suppression. Else it is related (such "
      "a box is of a truck, bus, train or van), renamed (of any other class), misplaced (a box of the car's "
      "class overlaps it by 0.1 to 0.5) or lost: none of these; other classes may still overlap it by less "
      "than 0.5.",
      {"picture", "found", "P@0.5", "95 % interval (Wilson)", "AP50, AP50:95, %", "mean best confidence",
       "related", "renamed", "misplaced", "lost"}};
  for (const auto* row : rows_of(report)) {
    const auto pictures = [&](evaluate::Fate fate) { return std::to_string(row->fates.of(fate)); };
    const std::string names = new_names_text(row->fates, row->class_names);
    table.rows.push_back({row->name,
                          std::to_string(row->rate.detected) + " of " + std::to_string(row->rate.views),
                          percent_text(row->rate.p_at_50),
                          percent_text(row->rate.interval[0]) + " to " + percent_text(row->rate.interval[1]),
                          per_cent(row->precision.ap50) + ", " + per_cent(row->precision.ap),
                          decimal_text(row->mean_best_confidence), pictures(evaluate::Fate::related),
                          pictures(evaluate::Fate::renamed) + (names.empty() ? "" : " (" + names + ")"),
                          pictures(evaluate::Fate::misplaced), pictures(evaluate::Fate::lost)});
  }
  return table;
}

std::string findings_html(const RunReport& report) {
  const auto& survey = report.survey;
  std::string html = "<p>Measured on ";
  html += report.held_out ? "held-out views with held-out backgrounds."
                          : "the same views that the texture was optimised on; it holds for no others.";
  html += "</p>\n" + html_of(table_of(report));
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
      "composited like every other row, so that what rendering alone does is not credited to the attack.";
  if (survey.effect)
    html +=
        " <i>matched noise</i> has the colours and the spectrum of the optimised texture with its phases "
        "shuffled, <i>shuffled</i> its patches in other places: what they do as well, the design does not "
        "do.";
  return html + "</p>\n";
}
}  // namespace

ViewList list_of(const RunReport& report, std::vector<ViewFacts> views) {
  ViewList list{std::move(views), {}, report.survey.adversarial ? "adversarial" : "clean"};
  for (const auto* row : rows_of(report)) list.measurements.emplace_back(row->name, row);
  return list;
}

ReportPage page_of(const RunReport& report, std::string title, std::string command, ViewList list) {
  ReportPage page{std::move(title), std::move(command), report.options.value("seed", std::uint64_t(0)),
                  report.seconds};
  page.verdict = verdict_of(report);
  page.findings = findings_html(report);
  page.list = std::move(list);
  page.curves = curves_of(report.history);
  page.options = report.options;
  return page;
}

void remark_on_photographs(ReportPage& page) {
  for (const auto& words : words_on_photographs(page.list)) {
    remark(words);
    page.findings += "<p>" + escaped(words) + ".</p>\n";
  }
}
}  // namespace tapestry::shell
