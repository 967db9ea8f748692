#pragma once
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/evaluate/average_precision.hpp>
#include "csv.hpp"
#include "run_folder.hpp"

namespace tapestry::shell {
inline std::vector<std::pair<const char*, std::optional<double>>> named_measures(
    const evaluate::PrecisionSummary& s) {
  return {{"ap", s.ap},
          {"ap50", s.ap50},
          {"ap75", s.ap75},
          {"ap_small", s.ap_small},
          {"ap_medium", s.ap_medium},
          {"ap_large", s.ap_large},
          {"recall", s.recall}};
}

inline evaluate::ClassPrecision all_classes(const evaluate::AveragePrecision& result) {
  evaluate::ClassPrecision all{0, 0, result.mean};
  for (const auto& one : result.classes) {
    all.truths += one.truths;
    all.detections += one.detections;
  }
  return all;
}

/// The table that evaluate prints: the means, then a row for each class with objects.
inline std::string precision_text(const evaluate::AveragePrecision& result,
                                  const std::vector<std::string>& names) {
  const auto measures = [](const evaluate::PrecisionSummary& s) {
    std::string text;
    for (const auto& [name, value] : named_measures(s))
      text += value ? formatted(" %6.2f", 100 * *value) : "      -";
    return text;
  };
  std::string text =
      "  class             objects  found    AP50:95   AP50   AP75  small medium  large recall  (per cent)\n";
  const auto add = [&](const std::string& name, const evaluate::ClassPrecision& row) {
    text +=
        formatted("  %-16s %8zu %8zu   ", printable(name).substr(0, 64).c_str(), row.truths, row.detections) +
        measures(row.summary) + "\n";
  };
  add("all", all_classes(result));
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (result.classes[k].truths > 0) add(names[k], result.classes[k]);
  }
  return text;
}

/// The result as CSV: shares in 0 to 1, empty without a value; the first row is the mean over classes.
inline std::string precision_csv(const evaluate::AveragePrecision& result,
                                 const std::vector<std::string>& names) {
  std::string text = "class,objects,detections";
  for (const auto& [name, value] : named_measures({})) text += std::string(",") + name;
  const auto add = [&](const std::string& name, const evaluate::ClassPrecision& row) {
    text.append("\n").append(csv_line(name, row.truths, row.detections));
    for (const auto& [measure, value] : named_measures(row.summary))
      text.append(",").append(value ? csv_line(*value) : "");
  };
  add("all", all_classes(result));
  for (std::size_t k = 0; k < names.size(); ++k) add(csv_quoted(names[k]), result.classes[k]);
  return text + "\n";
}

/// The result as JSON; null without a value.
inline Json precision_json(const evaluate::AveragePrecision& result, const std::vector<std::string>& names) {
  const auto measures = [](const evaluate::PrecisionSummary& s) {
    Json json = Json::object();
    for (const auto& [name, value] : named_measures(s)) json[name] = value ? Json(*value) : Json();
    return json;
  };
  Json classes = Json::array();
  for (std::size_t k = 0; k < names.size(); ++k) {
    Json row = {{"name", names[k]},
                {"objects", result.classes[k].truths},
                {"detections", result.classes[k].detections}};
    row.update(measures(result.classes[k].summary));
    classes.push_back(row);
  }
  Json json = measures(result.mean);
  json["classes"] = classes;
  return json;
}
}  // namespace tapestry::shell
