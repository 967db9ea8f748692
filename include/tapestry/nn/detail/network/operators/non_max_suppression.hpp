#pragma once
#include <tapestry/nn/detail/network/operators/generators.hpp>

namespace tapestry::nn {
/// The settings of NonMaxSuppression.
struct SuppressionSettings {
  bool has_centres = false;  ///< boxes are cx, cy, w, h; else y, x of two opposite corners
  std::size_t most = 0;      ///< boxes of a class of an image
  double overlap = 0;        ///< boxes that overlap a chosen one by more than this are left out
  double score = -std::numeric_limits<double>::infinity();  ///< boxes with a score up to this are left out
};

/// The boxes that ONNX's NonMaxSuppression chooses, as rows of image, class and box: of each class of each
/// image those with the largest scores, of equal ones the first.
/// \param boxes   [images, count, 4]
/// \param scores  [images, classes, count]
template <class Value>
[[nodiscard]] std::vector<std::array<std::size_t, 3>> chosen_boxes(const SuppressionSettings& settings,
                                                                   std::size_t images, std::size_t classes,
                                                                   std::size_t count, const Value& box_value,
                                                                   const Value& score_value) {
  struct Corners {
    double top, left, bottom, right;
  };
  const auto corners = [&](std::size_t box) {
    const auto at = [&](std::size_t i) { return box_value(4 * box + i); };
    if (settings.has_centres)
      return Corners{at(1) - at(3) / 2, at(0) - at(2) / 2, at(1) + at(3) / 2, at(0) + at(2) / 2};
    return Corners{std::min(at(0), at(2)), std::min(at(1), at(3)), std::max(at(0), at(2)),
                   std::max(at(1), at(3))};
  };
  const auto overlap = [](const Corners& a, const Corners& b) {
    const double height = std::min(a.bottom, b.bottom) - std::max(a.top, b.top);
    const double width = std::min(a.right, b.right) - std::max(a.left, b.left);
    if (!(height > 0 && width > 0)) return 0.0;
    const double both = height * width;
    return both / ((a.bottom - a.top) * (a.right - a.left) + (b.bottom - b.top) * (b.right - b.left) - both);
  };
  std::vector<std::array<std::size_t, 3>> rows;
  for (std::size_t row = 0; row < images * classes && count > 0; ++row) {
    const std::size_t image = row / classes;
    std::vector<std::size_t> order;
    for (std::size_t box = 0; box < count; ++box)
      if (score_value(row * count + box) > settings.score) order.push_back(box);
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
      return score_value(row * count + a) > score_value(row * count + b);
    });
    std::vector<Corners> chosen;
    for (const std::size_t box : order) {
      if (chosen.size() == settings.most) break;
      const Corners here = corners(image * count + box);
      const bool is_free = std::ranges::all_of(
          chosen, [&](const Corners& other) { return overlap(here, other) <= settings.overlap; });
      if (!is_free) continue;
      chosen.push_back(here);
      rows.push_back({image, row % classes, box});
    }
  }
  return rows;
}

/// NonMaxSuppression of boxes and scores that are known beforehand. The number of rows depends on their
/// values: results of computed values have no extents.
template <std::floating_point T>
class NonMaxSuppression : public Operation<T> {
 public:
  explicit NonMaxSuppression(std::vector<std::array<std::size_t, 3>> rows)
      : Operation<T>({{{rows.size(), 3}, ElementType::integer}}), rows_(std::move(rows)) {}

  void forward(const ForwardCall<T>& call) const override {
    T* to = call.outputs[0].values;
    for (const auto& row : rows_)
      for (const std::size_t index : row) *to++ = static_cast<T>(index);
  }
  [[nodiscard]] bool is_differentiable(std::size_t) const override { return false; }

 private:
  std::vector<std::array<std::size_t, 3>> rows_;
};

namespace detail {
/// The constant operand that bounds the boxes or their scores; `otherwise` if it is left out.
/// \throws DomainError for NaN, which every comparison would pass by
[[nodiscard]] inline double suppression_bound(const OperatorContext& context, std::size_t input,
                                              double otherwise) {
  if (!context.has_input(input)) return otherwise;
  const double bound = scalar_of(context, input);
  if (std::isnan(bound)) throw DomainError({"input ", input, " is NaN"});
  return bound;
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_non_max_suppression(OperatorContext& context) {
  const Operand &boxes = context.input(0), &scores = context.input(1);
  SuppressionSettings settings;
  settings.has_centres = context.flag("center_point_box", 0);
  const double most = suppression_bound(context, 2, 0);
  settings.overlap = suppression_bound(context, 3, settings.overlap);
  settings.score = suppression_bound(context, 4, settings.score);
  const Shape &a = boxes.shape, &b = scores.shape;
  if (a.size() != 3 || a[2] != 4 || b.size() != 3 || a[0] != b[0] || a[1] != b[2])
    throw ShapeError({"boxes and scores are ", a, " and ", b, ", expected [N, B, 4] and [N, K, B]"});
  // Exporters write the largest integer for no limit.
  settings.most = static_cast<std::size_t>(std::clamp(most, 0.0, static_cast<double>(a[1])));
  if (boxes.constant == nullptr || scores.constant == nullptr)
    throw DomainError(
        "the number of boxes left depends on the picture, which is not supported; choose outputs before this "
        "node");
  if (a[1] > (std::size_t(1) << 16U))  // each box is compared with all others
    throw ShapeError({a[1], " constant boxes are too many"});
  const auto value = [](const Constant* constant) {
    return [constant](std::size_t i) { return static_cast<double>(static_cast<T>(constant->at(i))); };
  };
  return std::make_unique<NonMaxSuppression<T>>(
      chosen_boxes(settings, a[0], b[1], a[1], value(boxes.constant), value(scores.constant)));
}
}  // namespace detail

template <std::floating_point T>
void add_non_max_suppression(OperatorTable<T>& table) {
  table["NonMaxSuppression"] = {LayoutRule::plain, 2, false, {{2, 5}}, detail::make_non_max_suppression<T>};
}
}  // namespace tapestry::nn
