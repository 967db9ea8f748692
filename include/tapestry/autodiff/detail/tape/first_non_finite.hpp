#pragma once
#include <tapestry/autodiff/detail/tape/formula.hpp>
#include <tapestry/autodiff/detail/tape/tape_state.hpp>

namespace tapestry {
/// Names, while it lives, statements of the tape that made it for Tape::first_non_finite().
template <class T>
class LabelScope {
 public:
  LabelScope(detail::Shared<detail::TapeState<T>> state, std::string name)
      : state_(std::move(state)), number_(state_->begin_label(std::move(name))) {}
  LabelScope(const LabelScope&) = delete;
  LabelScope& operator=(const LabelScope&) = delete;
  ~LabelScope() { state_->end_label(number_); }

 private:
  detail::Shared<detail::TapeState<T>> state_;
  std::size_t number_;
};

namespace detail {
/// The first statement with a watched value or a partial derivative that is not finite.
template <class T>
[[nodiscard]] std::optional<NonFinite> first_non_finite(const TapeState<T>& state) {
  std::optional<NonFinite> first = state.first_value();
  visit_operands<T>(state, [&](std::size_t i, const T& partial) {
    const auto number = static_cast<double>(value_of<Base<T>>(partial));
    if (!std::isfinite(number) && (!first || i < first->statement)) first = NonFinite{i, false, number};
  });
  if (first) first->label = state.label_of(first->statement);
  return first;
}

/// Products 0 · ∞ and 0 · NaN of adjoints and partial derivatives that the last reverse sweep took as 0.
template <class T>
[[nodiscard]] ZeroProducts zero_products(const TapeState<T>& state) {
  ZeroProducts found;
  const std::span<const T> adjoints = state.adjoints();
  visit_operands<T>(state, [&](std::size_t i, const T& partial) {
    if (!hides_infinity(i < adjoints.size() ? adjoints[i] : T(1), partial)) return;
    ++found.count;
    found.statement = i;
  });
  if (found.count > 0) found.label = state.label_of(found.statement);
  return found;
}
}  // namespace detail
}  // namespace tapestry
