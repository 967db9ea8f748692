#pragma once
#include <tapestry/evaluate/detail/fate.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/implementation/two_level_difference.hpp>

namespace tapestry::evaluate {
ViewOutcome outcome_of(const std::vector<detect::Detection>& detections, const loss::Target& target,
                       const std::vector<std::size_t>& related) {
  ViewOutcome outcome;
  for (const detect::Detection& detection : detections) {
    const double overlap = detect::iou(detection.box, target.box);
    const bool is_own = detection.class_index == target.class_index;
    Fate fate = Fate::lost;
    if (overlap >= 0.5)
      fate = is_own                                                   ? Fate::found
             : std::ranges::count(related, detection.class_index) > 0 ? Fate::related
                                                                      : Fate::renamed;
    else if (overlap >= 0.1 && is_own)
      fate = Fate::misplaced;
    if (fate == Fate::lost || fate > outcome.fate) continue;
    if (fate == outcome.fate && detection.confidence <= outcome.confidence) continue;
    outcome = {fate, detection.class_index, detection.confidence};
  }
  return outcome;
}

std::vector<std::size_t> related_classes(const std::vector<std::string>& names, std::size_t class_index) {
  constexpr std::array road_users{"car", "truck", "bus", "train", "van"};
  const auto is_road_user = [&](const std::string& name) { return std::ranges::count(road_users, name) > 0; };
  std::vector<std::size_t> related;
  if (class_index >= names.size() || !is_road_user(names[class_index])) return related;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (k != class_index && is_road_user(names[k])) related.push_back(k);
  return related;
}

std::size_t FateCounts::all() const {
  return std::accumulate(pictures.begin(), pictures.end(), std::size_t{0});
}

std::vector<std::size_t> FateCounts::commonest_names(std::size_t most) const {
  std::vector<std::size_t> classes;
  for (std::size_t k = 0; k < renamed_to.size(); ++k)
    if (renamed_to[k] > 0) classes.push_back(k);
  std::ranges::stable_sort(classes,
                           [&](std::size_t a, std::size_t b) { return renamed_to[a] > renamed_to[b]; });
  if (classes.size() > most) classes.resize(most);
  return classes;
}

FateCounts fate_counts(const std::vector<ViewOutcome>& outcomes) {
  FateCounts counts;
  for (const ViewOutcome& outcome : outcomes) {
    ++counts.pictures[static_cast<std::size_t>(outcome.fate)];
    if (outcome.fate != Fate::renamed) continue;
    if (counts.renamed_to.size() <= outcome.class_index) counts.renamed_to.resize(outcome.class_index + 1);
    ++counts.renamed_to[outcome.class_index];
  }
  return counts;
}

std::array<double, 2> wilson_interval(std::size_t hits, std::size_t trials, std::size_t pictures_a_trial) {
  if (trials == 0) return {0.0, 1.0};
  return detail::wilson_interval_of(static_cast<double>(hits) / static_cast<double>(trials),
                                    static_cast<double>(trials) / static_cast<double>(pictures_a_trial),
                                    1.959963984540054);
}

namespace detail {
/// Shares of each view's pictures, [seed, view], of one seed [draw, view].
/// \throws ShapeError where pictures are not as many of each view
inline Array<double, 2> shares_of_views(const std::vector<bool>& hits, const PictureOrder& order) {
  const std::size_t of_seed = hits.size() / order.seeds, of_view = order.photographs * order.draws;
  if (of_seed * order.seeds != hits.size() || of_seed % of_view != 0)
    throw ShapeError(
        {"detection_rate: ", hits.size(), " pictures are not ", order.pictures_a_view(), " of each view"});
  const std::size_t rows = order.seeds > 1 ? order.seeds : order.draws;
  const double weight = static_cast<double>(rows) / static_cast<double>(order.pictures_a_view());
  auto shares = zeros<double, 2>({rows, of_seed / of_view});
  for (std::size_t i = 0; i < hits.size(); ++i)
    if (hits[i]) shares(order.seeds > 1 ? i / of_seed : i % order.draws, i % of_seed / of_view) += weight;
  return shares;
}

/// The values of the views that have a trial, [seed or draw, view].
inline Array<double, 2> of_tried_views(const Array<double, 2>& values, const Array<double, 2>& trials) {
  const auto tried = means_over_draws(trials);
  auto kept = zeros<double, 2>(
      {values.shape(0), tried.size() - static_cast<std::size_t>(std::ranges::count(tried, 0.0))});
  for (std::size_t row = 0; row < values.shape(0); ++row)
    for (std::size_t view = 0, to = 0; view < tried.size(); ++view)
      if (tried[view] > 0) kept(row, to++) = values(row, view);
  return kept;
}

/// The interval of a share over seeds or draws and views, see detection_rate(); over views alone if
/// seeds or draws do not differ.
inline std::array<double, 2> two_level_interval(const std::vector<bool>& hits,
                                                const std::vector<bool>& trials, const PictureOrder& order) {
  const auto hit_count = static_cast<std::size_t>(std::ranges::count(hits, true)),
             trial_count = static_cast<std::size_t>(std::ranges::count(trials, true));
  const auto of_views = wilson_interval(hit_count, trial_count, order.pictures_a_view());
  if (order.seeds * order.draws < 2 || trial_count == 0) return of_views;
  const double share = static_cast<double>(hit_count) / static_cast<double>(trial_count);
  const auto all = shares_of_views(trials, order);
  const auto terms =
      linear_terms(of_tried_views(shares_of_views(hits, order), all), of_tried_views(all, all), share);
  if (terms.shape(1) < 2 || are_rows_equal(terms)) return of_views;
  const auto variance = two_level_variance(terms);
  return wilson_interval_of(share, share * (1 - share) / variance.sum(),
                            student_quantile(0.975, variance.degrees));
}
}  // namespace detail

DetectionRate detection_rate(const std::vector<bool>& found, const PictureOrder& order) {
  if (found.empty()) return {};
  const auto detected = static_cast<std::size_t>(std::ranges::count(found, true));
  return {found.size(), detected, static_cast<double>(detected) / static_cast<double>(found.size()),
          detail::two_level_interval(found, std::vector<bool>(found.size(), true), order)};
}

std::vector<DetectionRate> rates_above(const std::vector<double>& thresholds,
                                       const std::vector<double>& found_confidence,
                                       const PictureOrder& order) {
  std::vector<DetectionRate> rates;
  for (const double threshold : thresholds) {
    std::vector<bool> found;
    for (const double confidence : found_confidence) found.push_back(confidence > threshold);
    rates.push_back(detection_rate(found, order));
  }
  return rates;
}

AttackSuccess attack_success_rate(const std::vector<bool>& clean_found,
                                  const std::vector<bool>& adversarial_found, const PictureOrder& order) {
  if (clean_found.size() != adversarial_found.size())
    throw ShapeError({"attack_success_rate: adversarial_found has ", adversarial_found.size(),
                      " views, expected ", clean_found.size()});
  AttackSuccess success;
  std::vector<bool> hidden(clean_found.size());
  for (std::size_t i = 0; i < clean_found.size(); ++i) {
    hidden[i] = clean_found[i] && !adversarial_found[i];
    success.views += clean_found[i] ? 1U : 0U;
    success.hidden += hidden[i] ? 1U : 0U;
  }
  if (success.views == 0) return success;
  success.rate = static_cast<double>(success.hidden) / static_cast<double>(success.views);
  success.interval = detail::two_level_interval(hidden, clean_found, order);
  return success;
}
}  // namespace tapestry::evaluate
