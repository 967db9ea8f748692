#pragma once
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/head.hpp>  // largest_bin_count
#include <tapestry/nn/activation.hpp>

namespace tapestry::detect {
/// Softmax of the logits of B bins, the distribution of the distance of a box's side from its cell's centre:
/// bin b stands for b cells. Finite for finite logits of any size; a NaN among them makes everything NaN.
/// Source: Li et al., "Generalized Focal Loss" (NeurIPS 2020), the general distribution of a box.
class BinDistribution {
 public:
  /// \param count  B, 1 to largest_bin_count
  /// \param logit  takes a bin and returns its logit as a double
  template <std::invocable<std::size_t> Logits>
  BinDistribution(std::size_t count, Logits logit) : count_(count) {
    for (std::size_t bin = 0; bin < count; ++bin) shares_[bin] = logit(bin);
    double largest = shares_[0];
    for (std::size_t bin = 1; bin < count; ++bin)
      if (shares_[bin] > largest) largest = shares_[bin];
    double sum = 0;
    for (std::size_t bin = 0; bin < count; ++bin) sum += shares_[bin] = std::exp(shares_[bin] - largest);
    for (std::size_t bin = 0; bin < count; ++bin) shares_[bin] /= sum;
  }

  /// d = Σ_b b·p_b, in cells.
  [[nodiscard]] double mean() const {
    double sum = 0;
    for (std::size_t bin = 0; bin < count_; ++bin) sum += static_cast<double>(bin) * shares_[bin];
    return sum;
  }

  /// ∂d/∂logit_b = p_b·(b − d), as p_b·Σ_j p_j·(b − j): where p_b is almost 1, b − d would lose its digits.
  [[nodiscard]] double mean_slope(std::size_t bin) const {
    double sum = 0;
    for (std::size_t other = 0; other < count_; ++other)
      sum += shares_[other] * (static_cast<double>(bin) - static_cast<double>(other));
    return shares_[bin] * sum;
  }

 private:
  std::size_t count_;
  std::array<double, largest_bin_count> shares_;  ///< p; those beyond count_ are not set
};

/// Bound on w and h logits before an exponential, so that a box stays finite: e^50 is 5·10²¹.
inline constexpr double largest_extent_logit = 50;

/// Offset of a centre from the upper left corner of its cell, in cells; see DecodeFamily. Not for the
/// families distance and decoded, like all functions here of one x, y, w or h.
[[nodiscard]] inline double centre_offset(const Head& head, double logit) {
  if (head.decode == DecodeFamily::yolox) return logit;
  if (head.decode == DecodeFamily::scaled) return logit * head.scale_x_y - (head.scale_x_y - 1) / 2;
  if (head.decode == DecodeFamily::ultralytics) return 2 * nn::logistic(logit) - 0.5;
  return (nn::logistic(logit) - 0.5) * head.scale_x_y + 0.5;
}

/// Width or height of a box as a multiple of its anchor's, or of a cell; see DecodeFamily. In the families
/// darknet and yolox it is bounded by largest_extent_logit; in the others it lies in [0, 4].
[[nodiscard]] inline double extent_factor(const Head& head, double logit) {
  if (head.decode == DecodeFamily::darknet || head.decode == DecodeFamily::yolox)
    return std::exp(logit > largest_extent_logit ? largest_extent_logit : logit);
  const double twice = 2 * (head.decode == DecodeFamily::scaled ? logit : nn::logistic(logit));
  return twice * twice;
}

/// Probability for an output of objectness or a class: σ of it, or the output itself in the decode family
/// scaled.
[[nodiscard]] inline double probability(const Head& head, double logit) {
  return head.decode == DecodeFamily::scaled ? logit : nn::logistic(logit);
}

/// ∂centre_offset/∂logit.
[[nodiscard]] inline double centre_offset_slope(const Head& head, double logit) {
  if (head.decode == DecodeFamily::yolox) return 1;
  if (head.decode == DecodeFamily::scaled) return head.scale_x_y;
  const double scale = head.decode == DecodeFamily::ultralytics ? 2 : head.scale_x_y;
  return nn::logistic(logit) * nn::logistic(-logit) * scale;
}

/// ∂extent/∂logit of a width or height, extent_factor() times the anchor's or cell's extent; 0
/// where the logit is bounded.
[[nodiscard]] inline double extent_slope(const Head& head, double logit, double extent) {
  if (head.decode == DecodeFamily::ultralytics)
    return 2 * extent * nn::logistic(-logit);  // 8 · σ · σ' · anchor
  if (head.decode == DecodeFamily::scaled) return logit == 0 ? 0 : 2 * extent / logit;  // 8 · t · anchor
  return logit > largest_extent_logit ? 0 : extent;
}

/// ∂probability/∂logit; keeps its digits where σ rounds to 1.
[[nodiscard]] inline double probability_slope(const Head& head, double logit) {
  return head.decode == DecodeFamily::scaled ? 1 : nn::logistic(logit) * nn::logistic(-logit);
}

/// Place of a candidate in its head, and the extents below the head's grid.
struct CandidatePlace {
  std::size_t anchor = 0, row = 0, column = 0;
  double input_width = 0, input_height = 0;  ///< of the network, pixels
};

namespace detail {
/// One axis of a head's grid, for one candidate.
struct GridAxis {
  double cell = 0, cells = 0;  ///< the candidate's, and their number
  double input = 0;            ///< extent, pixels
  double stride = 0;           ///< pixels; 0: input / cells
  double unit = 0;             ///< unit of extents, pixels

  /// Pixels of a position in cells.
  [[nodiscard]] double position(double in_cells) const {
    return stride > 0 ? in_cells * stride : in_cells / cells * input;
  }
  /// Pixels of a length or slope in cells.
  [[nodiscard]] double length(double in_cells) const {
    return stride > 0 ? in_cells * stride : in_cells * input / cells;
  }
};

/// The axes of the columns, then of the rows.
[[nodiscard]] inline std::array<GridAxis, 2> axes_of(const Head& head, const CandidatePlace& place) {
  const auto number = [](std::size_t count) { return static_cast<double>(count); };
  const double stride = number(head.stride);
  std::array<GridAxis, 2> axes{
      {{number(place.column), number(head.grid_width), place.input_width, stride, 0},
       {number(place.row), number(head.grid_height), place.input_height, stride, 0}}};
  for (std::size_t i = 0; i < 2; ++i)
    axes[i].unit = has_anchors(head.decode) ? head.anchors[place.anchor][i] : axes[i].length(1);
  return axes;
}

/// The extent, but 0 if it is below 0; NaN stays.
[[nodiscard]] inline double not_below_0(double extent) { return extent < 0 ? 0 : extent; }

/// Sides of a box: left, top, right, bottom.
inline constexpr std::size_t side_count = 4;

template <std::invocable<std::size_t> Logits>
[[nodiscard]] BinDistribution side_distribution(const Head& head, std::size_t side, Logits logit) {
  return BinDistribution(head.bins,
                         [&](std::size_t bin) { return logit(head.box_channel() + side * head.bins + bin); });
}
}  // namespace detail

/// The box of one candidate by the decode family of its head.
///
/// \param logit  takes a channel of the candidate, from 0, and returns its output as a double
/// \returns      pixels of the network's input
template <std::invocable<std::size_t> Logits>
[[nodiscard]] Box decode_box(const Head& head, const CandidatePlace& place, Logits logit) {
  const auto [x, y] = detail::axes_of(head, place);
  if (head.decode == DecodeFamily::distance) {
    std::array<double, detail::side_count> reach{};  // cells
    for (std::size_t side = 0; side < reach.size(); ++side)
      reach[side] = detail::side_distribution(head, side, logit).mean();
    const auto [left, top, right, bottom] = reach;
    return {x.position(x.cell + 0.5 + (right - left) / 2), y.position(y.cell + 0.5 + (bottom - top) / 2),
            x.length(left + right), y.length(top + bottom)};
  }
  if (head.decode == DecodeFamily::decoded)
    return {logit(x_channel), logit(y_channel), detail::not_below_0(logit(w_channel)),
            detail::not_below_0(logit(h_channel))};
  return {x.position(centre_offset(head, logit(x_channel)) + x.cell),
          y.position(centre_offset(head, logit(y_channel)) + y.cell),
          extent_factor(head, logit(w_channel)) * x.unit, extent_factor(head, logit(h_channel)) * y.unit};
}

/// The pullback of decode_box(): calls add(channel, c) with the gradient c of each channel of the candidate.
/// A component of box_adjoint that is 0 adds nothing, however large the box is.
template <std::invocable<std::size_t> Logits, std::invocable<std::size_t, double> Add>
void decode_box_adjoint(const Head& head, const CandidatePlace& place, Logits logit, const Box& box_adjoint,
                        Add add) {
  const auto axes = detail::axes_of(head, place);
  const std::array<double, 2> centre{box_adjoint.cx, box_adjoint.cy}, extent{box_adjoint.w, box_adjoint.h};
  if (head.decode == DecodeFamily::decoded) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (centre[axis] != 0) add(x_channel + axis, centre[axis]);
      if (extent[axis] != 0 && logit(w_channel + axis) > 0) add(w_channel + axis, extent[axis]);
    }
    return;
  }
  for (std::size_t side = 0; head.decode == DecodeFamily::distance && side < detail::side_count; ++side) {
    const std::size_t axis = side % 2;
    const double sign = side < 2 ? -0.5 : 0.5;  // left and top pull the centre back
    const double reach_adjoint = axes[axis].length(extent[axis] + sign * centre[axis]);
    if (reach_adjoint == 0) continue;
    const auto distribution = detail::side_distribution(head, side, logit);
    for (std::size_t bin = 0; bin < head.bins; ++bin)
      add(head.box_channel() + side * head.bins + bin, reach_adjoint * distribution.mean_slope(bin));
  }
  for (std::size_t axis = 0; head.decode != DecodeFamily::distance && axis < 2; ++axis) {
    const std::size_t centre_channel = x_channel + axis, extent_channel = w_channel + axis;
    if (centre[axis] != 0)
      add(centre_channel, centre[axis] * axes[axis].length(centre_offset_slope(head, logit(centre_channel))));
    if (extent[axis] == 0) continue;
    const double t = logit(extent_channel);
    add(extent_channel, extent[axis] * extent_slope(head, t, extent_factor(head, t) * axes[axis].unit));
  }
}

/// The channel that measures how sure a candidate is of an object: its objectness; in a head without
/// objectness the class of the largest logit, the first of several, or the first that is NaN.
template <std::invocable<std::size_t> Logits>
[[nodiscard]] std::size_t surest_channel(const Head& head, Logits logit) {
  if (const auto objectness = head.objectness_channel()) return *objectness;
  std::size_t surest = head.class_channel(0);
  for (std::size_t k = 1; k < head.classes && !std::isnan(logit(surest)); ++k)
    if (!(logit(head.class_channel(k)) <= logit(surest))) surest = head.class_channel(k);
  return surest;
}
}  // namespace tapestry::detect
