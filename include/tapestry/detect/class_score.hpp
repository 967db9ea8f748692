#pragma once
#include <limits>
#include <tapestry/detect/box_formula.hpp>

namespace tapestry::detect {
/// The probabilities of all classes of one candidate. The head decides: each class by itself, see
/// probability(), or exclusive classes with their softmax e^t_k / Σ_j e^t_j. A NaN logit of exclusive classes
/// makes all of them NaN.
///
/// Logits is a function that takes a channel of the candidate and returns its output as a double.
template <std::invocable<std::size_t> Logits>
class ClassScores {
 public:
  ClassScores(const Head& head, Logits logit) : head_(head), logit_(logit) {
    if (!head.exclusive_classes) return;
    largest_ = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < head.classes; ++k) largest_ = std::max(largest_, logit_of(k));
    for (std::size_t k = 0; k < head.classes; ++k) sum_ += std::exp(logit_of(k) - largest_);
  }

  /// The score of class k.
  [[nodiscard]] double operator()(std::size_t k) const {
    return head_.exclusive_classes ? std::exp(logit_of(k) - largest_) / sum_
                                   : probability(head_, logit_of(k));
  }

  /// The pullback: calls add(channel, c) with the gradient c of each class's channel.
  /// \param score_adjoint  takes a class
  template <std::invocable<std::size_t> Adjoint, std::invocable<std::size_t, double> Add>
  void adjoint(Adjoint score_adjoint, Add add) const {
    double mean = 0;  // mean of the adjoints, weighted by the scores
    for (std::size_t k = 0; head_.exclusive_classes && k < head_.classes; ++k)
      mean += score_adjoint(k) * (*this)(k);
    for (std::size_t k = 0; k < head_.classes; ++k) {
      const double adjoint_of_score = score_adjoint(k);
      if (head_.exclusive_classes)
        add(head_.class_channel(k), (*this)(k) * (adjoint_of_score - mean));
      else if (adjoint_of_score != 0)
        add(head_.class_channel(k), adjoint_of_score * probability_slope(head_, logit_of(k)));
    }
  }

 private:
  [[nodiscard]] double logit_of(std::size_t k) const { return logit_(head_.class_channel(k)); }

  const Head& head_;
  Logits logit_;
  double largest_ = 0;
  double sum_ = 0;
};

namespace detail {
/// log Σ e^t_j over the classes j other than k, and the pieces it is computed from; −∞ for a single class.
struct OtherClasses {
  double largest = -std::numeric_limits<double>::infinity();
  double sum = 0;  ///< Σ e^(t_j − largest)

  template <std::invocable<std::size_t> Logits>
  OtherClasses(const Head& head, std::size_t k, Logits logit) {
    for (std::size_t j = 0; j < head.classes; ++j)
      if (j != k) largest = std::max(largest, logit(head.class_channel(j)));
    for (std::size_t j = 0; j < head.classes; ++j)
      if (j != k) sum += std::exp(logit(head.class_channel(j)) - largest);
  }
};
}  // namespace detail

/// The number whose σ is the probability of class k, in a family with raw logits: its logit, or for exclusive
/// classes its lead over the others, t_k − log Σ_{j≠k} e^t_j. For softmax is 1 / (1 + Σ_{j≠k} e^(t_j − t_k)),
/// and formulas in σ keep their digits at either end. A single exclusive class is sure: ∞.
template <std::invocable<std::size_t> Logits>
[[nodiscard]] double class_logit(const Head& head, std::size_t k, Logits logit) {
  const double own = logit(head.class_channel(k));
  if (!head.exclusive_classes) return own;
  const detail::OtherClasses others(head, k, logit);
  return own - (others.largest + std::log(others.sum));
}

/// The pullback of class_logit(): calls add(channel, c) with the gradient c of each class's channel.
template <std::invocable<std::size_t> Logits, std::invocable<std::size_t, double> Add>
void class_logit_adjoint(const Head& head, std::size_t k, Logits logit, double adjoint, Add add) {
  add(head.class_channel(k), adjoint);
  if (!head.exclusive_classes) return;
  const detail::OtherClasses others(head, k, logit);
  for (std::size_t j = 0; j < head.classes; ++j)
    if (j != k)
      add(head.class_channel(j),
          -adjoint * (std::exp(logit(head.class_channel(j)) - others.largest) / others.sum));
}
}  // namespace tapestry::detect
