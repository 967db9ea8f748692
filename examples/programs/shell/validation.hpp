#pragma once
#include <tapestry/camouflage/training.hpp>
#include <tapestry/io/npy.hpp>
#include "run_folder.hpp"

namespace tapestry::shell {
/// Views that a run does not optimise on. Each epoch's paint is tried on them, and the run ends with the best
/// epoch's paint. The measure is the mean of the loss max_score over the views, whatever the run minimises:
/// so runs of several losses and methods can be compared.
class Validation {
 public:
  /// Moves this number of usable views to a validation, evenly spread. Without views
  /// the last paint is the best.
  /// \param path  file of the best paint so far
  /// \throws Error (usage) unless views to optimise on are left
  Validation(std::vector<std::size_t>& usable, std::size_t count, std::string path) : path_(std::move(path)) {
    if (count == 0) return;
    if (count >= usable.size())
      throw Error(ErrorKind::usage, "--validation " + std::to_string(count) + ": of " +
                                        std::to_string(usable.size()) +
                                        " views that show the car none are left to optimise on");
    std::vector<std::size_t> rest;
    for (std::size_t i = 0; i < usable.size(); ++i) {
      const bool is_taken = i * count / usable.size() != (i + 1) * count / usable.size();
      (is_taken ? views_ : rest).push_back(usable[i]);
    }
    usable = std::move(rest);
  }

  /// Reads the state of an interrupted run.
  /// \throws FileError (malformed) if an epoch has ended and nothing was kept; mismatch
  void restore(const camouflage::Training<float>& training) {
    if (views_.empty() || training.steps_taken() < training.steps_per_epoch()) return;
    if (!is_there(path_, ErrorKind::malformed))
      throw malformed_file({path_, "", "the best paint so far is missing"});
    const auto file = io::NpzFile::read(path_);
    best_ = file.array<float, 2>("parameter");
    const auto scores = file.array<double, 1>("scores");
    scores_.assign(scores.begin(), scores.end());
    if (best_.shape() != training.parameter().shape() ||
        scores_.size() < training.steps_taken() / training.steps_per_epoch())
      throw file_mismatch({path_, "", "the best paint of another run"});
  }

  /// Tries the paint if an epoch has just ended.
  /// \param objective  of the loss max_score alone, with the run's detectors and method
  void follow(const camouflage::Training<float>& training, camouflage::Objective<float>& objective,
              camouflage::ViewStore<float>& store) {
    if (views_.empty() || training.steps_taken() % training.steps_per_epoch() != 0) return;
    const std::size_t epoch = training.steps_taken() / training.steps_per_epoch();
    const double score = score_of(training.parameter(), objective, store);
    // An interrupted run may have tried this epoch already, with the same score.
    scores_.resize(epoch - 1);
    scores_.push_back(score);
    if (best_epoch() == epoch) best_ = training.parameter();
    io::NpzWriter file;
    file.add("parameter", best_);
    Array<double, 1> scores(Extents<1>{scores_.size()});
    std::ranges::copy(scores_, scores.begin());
    file.add("scores", scores);
    file.write(path_);
  }

  /// Whether an epoch has just ended, and so many up to it were no better than the best one.
  /// \param patience  0: never
  [[nodiscard]] bool is_stale(const camouflage::Training<float>& training, std::size_t patience) const {
    const std::size_t epoch = training.steps_taken() / training.steps_per_epoch();
    if (patience == 0 || epoch == 0 || training.steps_taken() % training.steps_per_epoch() != 0) return false;
    // A killed run may have tried more.
    const auto end = scores_.begin() + static_cast<std::ptrdiff_t>(epoch);
    return end - std::min_element(scores_.begin(), end) > static_cast<std::ptrdiff_t>(patience);
  }

  /// The parameter of the best epoch; without validation the last one.
  [[nodiscard]] const Array<float, 2>& chosen(const camouflage::Training<float>& training) const {
    return scores_.empty() ? training.parameter() : best_;
  }

  /// For metrics.json; null without validation.
  [[nodiscard]] Json json() const {
    if (scores_.empty()) return {};
    return {{"views", views_.size()},
            {"max_score_by_epoch", scores_},
            {"best_epoch", best_epoch()},
            {"best_max_score", std::ranges::min(scores_)}};
  }

  /// Sentence for the end of a run; empty without validation.
  [[nodiscard]] std::string text() const {
    if (scores_.empty()) return {};
    return "paint of epoch " + std::to_string(best_epoch()) + " of " + std::to_string(scores_.size()) +
           ", the best on " + std::to_string(views_.size()) + " further views";
  }

 private:
  /// From 1; the first of equal ones.
  [[nodiscard]] std::size_t best_epoch() const {
    return static_cast<std::size_t>(std::ranges::min_element(scores_) - scores_.begin()) + 1;
  }

  [[nodiscard]] double score_of(const Array<float, 2>& parameter, camouflage::Objective<float>& objective,
                                camouflage::ViewStore<float>& store) const {
    const auto first = store.view(views_.front());
    const auto paint = objective.paint_of(ArrayVariable<float, 2>(parameter), std::span(&first, 1)).first;
    std::vector<double> scores(views_.size());
    const auto try_on = [&](std::size_t i) {
      const auto view = store.view(views_[i]);
      scores[i] = objective.evaluate(paint, std::span(&view, 1)).terms.max_score;
    };
    if (objective.prefers_views_side_by_side())
      parallel_for(views_.size(), try_on);
    else
      for (std::size_t i = 0; i < views_.size(); ++i) try_on(i);
    return std::accumulate(scores.begin(), scores.end(), 0.0) / static_cast<double>(scores.size());
  }

  std::string path_;
  std::vector<std::size_t> views_{};  ///< their numbers in the store
  std::vector<double> scores_{};      ///< after each epoch
  Array<float, 2> best_{};            ///< parameter of the best epoch
};
}  // namespace tapestry::shell
