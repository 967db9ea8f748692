#pragma once
#include <cstddef>
#include <fstream>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/network.hpp>
#include <tapestry/image/planes.hpp>
#include <tapestry/io/network_file.hpp>
#include <vector>

#include "../support/relative_distance.hpp"
#include "decisions.hpp"
#include "problem.hpp"

namespace tapestry::benchmarks {

/// Error of a gradient against double precision.
struct GradientError {
  double relative = 0;       ///< under the decisions that the gradient was made with
  double own_decisions = 0;  ///< under those of double precision
  std::size_t changed = 0;   ///< decisions in which the two differ
};

/// A problem solved in double precision by plain sums, as far as it is asked for.
class Reference {
 public:
  Reference(const Problem& problem, const std::string& weights)
      : problem_(problem),
        network_(io::read_network<double>(problem.config.name, weights, problem.picture.shape(2),
                                          problem.picture.shape(3))
                     .network) {
    network_.set_engine(nn::Engine::direct);
  }

  [[nodiscard]] double logits_error(const std::vector<float>& found) {
    solve();
    return relative_distance(found, logits_);
  }

  [[nodiscard]] GradientError gradient_error(const std::vector<float>& found, const Decisions& decisions) {
    solve();
    hold(decisions, pass_);
    return {relative_distance(found, gradient()), relative_distance(found, own_gradient_),
            difference(decisions, own_decisions_)};
  }

 private:
  void solve() {
    if (!logits_.empty()) return;
    network_.forward(image::pictures_of_planes(cast<double>(problem_.picture)), pass_,
                     detect::Mode::input_gradient);
    for (const auto& logits : pass_.logits)
      logits_.insert(logits_.end(), logits.data(), logits.data() + logits.size());
    for (const auto& weighting : problem_.weighting) weighting_.push_back(cast<double>(weighting));
    own_decisions_ = decisions_of(problem_, pass_);
    own_gradient_ = gradient();
  }

  [[nodiscard]] std::vector<double> gradient() {
    const auto& planes = problem_.picture.shape();
    auto gradient = zeros<double, 4>({planes[0], planes[2], planes[3], planes[1]});
    network_.input_adjoint(pass_, weighting_, gradient);
    const auto turned = image::planes_of(gradient);
    return {turned.data(), turned.data() + turned.size()};
  }

  const Problem& problem_;
  detect::Network<double> network_;
  detect::Pass<double> pass_;
  std::vector<Array<double, 4>> weighting_;
  std::vector<double> logits_;
  Decisions own_decisions_;
  std::vector<double> own_gradient_;
};

}  // namespace tapestry::benchmarks
