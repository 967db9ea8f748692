#pragma once
#include <tapestry/image/batch.hpp>
#include "../support/relative_distance.hpp"
#include "decisions.hpp"

namespace tapestry::benchmarks {
/// Error of a gradient against double precision.
struct GradientError {
  double relative = 0;       ///< under the decisions that the gradient was made with
  double own_decisions = 0;  ///< under those of double precision
  std::size_t changed = 0;   ///< decisions in which the two differ
};

/// A problem solved in double precision by plain sums, as far as it is needed.
class Reference {
 public:
  Reference(const Problem& problem, const std::string& weights)
      : problem_(problem),
        network_(described(problem, weights), {}, true, false),
        picture_(image::pictures_of_planes(cast<double>(problem.picture))) {
    network_.set_engine(nn::Engine::direct);
  }

  [[nodiscard]] double logits_error(const std::vector<float>& found) {
    solve();
    return relative_distance(found, logits_);
  }

  [[nodiscard]] GradientError gradient_error(const std::vector<float>& found, const Decisions& decisions) {
    solve();
    hold(problem_, network_, decisions, pass_);
    return {relative_distance(found, gradient()), relative_distance(found, own_gradient_),
            difference(decisions, own_decisions_)};
  }

 private:
  [[nodiscard]] static nn::NetworkDescription described(const Problem& problem, const std::string& weights) {
    const std::size_t height = problem.picture.shape(2), width = problem.picture.shape(3);
    return io::read_darknet_model<double>(problem.config.name, weights, height, width).model.description();
  }

  void solve() {
    if (!logits_.empty()) return;
    nn::Buffer<double> input(picture_.size());
    std::copy_n(picture_.data(), picture_.size(), input.data());
    network_.forward({input.data()}, pass_, nn::Mode::input_gradient);
    for (std::size_t i = 0; i < network_.output_count(); ++i)
      logits_.insert(logits_.end(), pass_.output(i), pass_.output(i) + nn::size_of(network_.output_shape(i)));
    for (const auto& weighting : problem_.weighting) weighting_.push_back(cast<double>(weighting));
    own_decisions_ = decisions_of(problem_, network_, pass_);
    own_gradient_ = gradient();
  }

  [[nodiscard]] std::vector<double> gradient() {
    std::vector<const double*> adjoints;
    for (const auto& weighting : weighting_) adjoints.push_back(weighting.data());
    auto gradient = zeros<double, 4>(picture_.shape());
    network_.adjoint(pass_, adjoints, {gradient.data()});
    const auto turned = image::planes_of(gradient);
    return {turned.data(), turned.data() + turned.size()};
  }

  const Problem& problem_;
  nn::Network<double> network_;
  nn::NetworkPass<double> pass_;
  Array<double, 4> picture_;
  std::vector<Array<double, 4>> weighting_;
  std::vector<double> logits_;
  Decisions own_decisions_;
  std::vector<double> own_gradient_;
};
}  // namespace tapestry::benchmarks
