#pragma once
#include <tapestry/core/parallel.hpp>
#include <tapestry/loss/detail/box_assignment.hpp>

namespace tapestry::loss {
namespace detail {
/// The centre of a candidate's cell, pixels of the input.
template <std::floating_point T>
[[nodiscard]] detect::Box cell_box(const Predictions<T>& predictions, const Candidate& candidate) {
  const auto [x, y] =
      detect::detail::axes_of(predictions.heads[candidate.head], place_of(predictions, candidate));
  return {x.position(x.cell + 0.5), y.position(y.cell + 0.5), x.unit, y.unit};
}

/// Cost of each class for a candidate: of predicting it and denying all others.
template <std::floating_point T>
[[nodiscard]] std::vector<double> class_costs(const Predictions<T>& predictions, const Candidate& candidate) {
  const auto& head = predictions.heads[candidate.head];
  const auto logit = logits_of(predictions, candidate);
  std::optional<double> objectness;
  if (const auto channel = head.objectness_channel()) objectness = logit(*channel);
  std::vector<double> costs(head.classes);
  double all_denied = 0;
  for (std::size_t k = 0; k < head.classes; ++k) {
    const ClassCost cost(logit(head.class_channel(k)), objectness);
    all_denied += cost.if_absent;
    costs[k] = cost.if_present - cost.if_absent;
  }
  for (double& cost : costs) cost += all_denied;
  return costs;
}

/// The candidates of one image, and the truth that each has so far.
template <std::floating_point T>
class DynamicMatcher {
 public:
  DynamicMatcher(const Predictions<T>& predictions, const DynamicMatchOptions& options)
      : predictions_(predictions), options_(options) {
    for (std::size_t head = 0; head < predictions.heads.size(); ++head)
      for_each_candidate(head, predictions.heads[head], [&](const Candidate& candidate) {
        places_.push_back({candidate, cell_box(predictions, candidate), {}, {}, {}, nullptr, 0});
      });
  }

  /// Matches the truth with its cheapest candidates. Their number is the sum of its best overlaps, at
  /// least 1.
  void add(const Target& truth) {
    if (!(truth.box.w > 0 && truth.box.h > 0)) return;
    std::vector<Offer> offers;
    for (Place& place : places_)
      if (const auto offer = offer_of(place, truth)) offers.push_back(*offer);
    const std::size_t count = std::min(offers.size(), cells_for(offers));
    std::ranges::stable_sort(offers, {}, &Offer::cost);
    for (std::size_t i = 0; i < count; ++i) {
      Place& place = *offers[i].place;
      if (place.truth != nullptr && place.cost <= offers[i].cost) continue;
      place.truth = &truth;
      place.cost = offers[i].cost;
      place.iou = offers[i].iou;
    }
  }

  [[nodiscard]] std::vector<DynamicMatch> matches() const {
    std::vector<DynamicMatch> found;
    for (const Place& place : places_)
      if (place.truth != nullptr) found.push_back({place.candidate, *place.truth, place.iou});
    return found;
  }

 private:
  struct Place {
    Candidate candidate;
    detect::Box cell;
    std::optional<detect::Box> box;   ///< box that it predicts, once computed
    std::vector<double> class_costs;  ///< likewise
    double cost = 0;                  ///< cost of its current truth
    const Target* truth = nullptr;
    double iou = 0;
  };

  struct Offer {
    Place* place;
    double cost, iou;
  };

  /// Cost of a truth for a candidate that may take it: one with its cell's centre in the truth's box or near
  /// its middle.
  [[nodiscard]] std::optional<Offer> offer_of(Place& place, const Target& truth) const {
    constexpr double smallest_iou = 1e-8, outside_cost = 1e5;
    const double dx = std::abs(place.cell.cx - truth.box.cx), dy = std::abs(place.cell.cy - truth.box.cy);
    const bool is_inside = dx < truth.box.w / 2 && dy < truth.box.h / 2;
    const bool is_near = dx < options_.radius * place.cell.w && dy < options_.radius * place.cell.h;
    if (!is_inside && !is_near) return std::nullopt;
    if (!place.box) {
      place.box = decoded_box(predictions_, place.candidate);
      place.class_costs = class_costs(predictions_, place.candidate);
    }
    const double iou = detect::iou(*place.box, truth.box);
    const double cost = place.class_costs[truth.class_index] -
                        options_.overlap_cost * std::log(iou + smallest_iou) +
                        (is_inside && is_near ? 0 : outside_cost);
    return Offer{&place, cost, iou};
  }

  [[nodiscard]] std::size_t cells_for(const std::vector<Offer>& offers) const {
    std::vector<double> overlaps;
    for (const Offer& offer : offers) overlaps.push_back(offer.iou);
    std::ranges::sort(overlaps, std::greater<>());
    double sum = 0;
    for (std::size_t i = 0; i < std::min(options_.strongest, overlaps.size()); ++i) sum += overlaps[i];
    return std::max<std::size_t>(1, static_cast<std::size_t>(sum));
  }

  const Predictions<T>& predictions_;
  DynamicMatchOptions options_;
  std::vector<Place> places_;
};

/// \throws NumericError for a logit of the image that is not finite
template <std::floating_point T>
void require_finite_image(const char* operation, const Predictions<T>& predictions) {
  for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
    const auto& logits = *predictions.logits[head];
    const std::size_t count = logits.size() / logits.shape(0);
    const T* const first = logits.data() + predictions.image * count;
    for (std::size_t i = 0; i < count; ++i)
      if (!std::isfinite(first[i]))
        throw NumericError({operation, ": logit ", i, " of head ", head, ", image ", predictions.image,
                            "; expected a finite number, found ", first[i]});
  }
}
}  // namespace detail

template <std::floating_point T>
DynamicMatches dynamic_matches(const std::vector<detect::Head>& heads, const LogitsView<T>& logits,
                               const Truths& truths, std::size_t input_height, std::size_t input_width,
                               const DynamicMatchOptions& options) {
  constexpr const char* operation = "dynamic_matches";
  detail::require_truths(operation, heads, logits, truths, input_height, input_width,
                         detail::require_free_heads);
  DynamicMatches matches(truths.size());
  parallel_for(truths.size(), [&](std::size_t n) {
    const Predictions<T> predictions{heads, logits, n, input_height, input_width};
    detail::require_finite_image(operation, predictions);
    detail::DynamicMatcher<T> matcher(predictions, options);
    for (const Target& truth : truths[n]) matcher.add(truth);
    matches[n] = matcher.matches();
  });
  return matches;
}
}  // namespace tapestry::loss
