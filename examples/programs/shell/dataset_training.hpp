#pragma once
#include "checkpoint_file.hpp"
#include "dataset_pictures.hpp"
#include "learner.hpp"

namespace tapestry::shell {
/// Settings of a detector that learns, from random weights where it has none.
struct StartSettings : DetectorSettings {};

inline void require_sound(StartSettings s, ProblemList& list) {
  if (s.weights.empty()) s.weights = "random";
  require_sound(static_cast<const DetectorSettings&>(s), list);
  list.require(s.precision == "float", "--precision has no part in training, which is in float");
}

struct DatasetTraining : LabelSettings {
  static constexpr const char* group = "Own labelled pictures";
  std::string validation;
  double held_out = 0.2;
  std::size_t patience = 5;
  std::size_t steps = 1000, batch = 16, validate_every = 100;
  double learning_rate = 0;
  std::uint64_t seed = 1;
};

template <class Visit>
void visit_settings(DatasetTraining& s, Visit visit) {
  visit("dataset", s.dataset,
        std::string("labelled pictures to learn from instead of drawn scenes, for any detector with raw "
                    "heads: ") +
            dataset_help +
            ". The other options of training are then 1000 steps of 16 pictures, validated every 100, at "
            "0.0005, or 0.002 from random weights, where they are left out, and --output is a folder");
  visit("images", s.images, images_help);
  visit("dataset-names", s.class_names, dataset_names_help);
  visit("classes", s.classes, classes_help);
  visit("validation", s.validation, "labelled pictures to validate on, in any of these forms");
  visit("held-out", s.held_out,
        "share of the pictures to validate on instead, drawn by --seed; they should not be neighbours of a "
        "video's");
  visit("patience", s.patience, "validations without a better AP50 after which training ends; 0: never",
        at_most_a_million);
  visit("steps", s.steps, "", Numbers{0, 1e8});
  visit("batch", s.batch, "");
  visit("learning-rate", s.learning_rate, "");
  visit("validate-every", s.validate_every, "");
  visit("seed", s.seed, "");
}

inline void require_sound(const DatasetTraining& s, ProblemList& list) {
  require_values(s, list);
  list.require(!s.dataset.empty(), "--dataset is missing");
  list.require(s.held_out > 0 && s.held_out < 1, "--held-out lies between 0 and 1");
}

/// Trains a detector on labelled pictures, and keeps its state at the best validation. Two trainings with
/// equal settings and checkpoints continue with the same bits.
class DatasetTrainer {
 public:
  using Validate = std::function<double(const detect::Detector<float>&)>;

  /// \param detector  is changed; the other arguments must outlive this
  /// \param validate  returns AP50 on the held-out pictures; may throw Stopped
  DatasetTrainer(LearningDetector& detector, const DatasetTraining& settings, const DatasetPictures& pictures,
                 Validate validate)
      : detector_(detector),
        settings_(settings),
        pictures_(pictures),
        validate_(std::move(validate)),
        learner_(detector, "train_detector"),
        batch_(Extents<4>{settings.batch, detector.detector().input_height(),
                          detector.detector().input_width(), 3}),
        best_(detector.state()) {}

  [[nodiscard]] std::size_t step_count() const { return settings_.steps; }
  [[nodiscard]] std::uint64_t steps_taken() const { return history_.size(); }
  [[nodiscard]] bool finished() const {
    return scores_.size() == validations_due() && (history_.size() >= settings_.steps || is_stale());
  }
  [[nodiscard]] const std::vector<double>& scores() const { return scores_; }
  [[nodiscard]] const std::vector<LossTerms>& history() const { return history_; }
  /// Steps before the first of the best validations.
  [[nodiscard]] std::size_t best_step() const {
    return std::min(settings_.steps, best_validation() * settings_.validate_every);
  }
  [[nodiscard]] bool is_stale() const {
    return settings_.patience > 0 && scores_.size() > settings_.patience + best_validation();
  }

  /// A validation if one is due, else a step of the weights.
  void step() {
    const std::size_t index = history_.size();
    if (scores_.size() < validations_due()) {
      scores_.push_back(validate_(detector_.detector()));
      if (best_validation() + 1 == scores_.size()) best_ = detector_.state();
      return;
    }
    pictures_.fill(Random(settings_.seed).fork(0x73746570ULL).fork(index), detector_.detector().fit(), batch_,
                   truths_);
    const double rate = warm_cosine_rate(settings_.learning_rate, index, settings_.steps, 100);
    history_.push_back(learner_.step(batch_, truths_, rate, index + 1));
  }

  /// Writes the checkpoint, then the detector of the best validation; of each the previous one survives any
  /// interruption.
  /// \param identity  of the run, see identity_text()
  void save(const std::string& checkpoint, const std::string& identity, const std::string& detector) {
    const auto now = detector_.state();
    io::NpzWriter file = begun_checkpoint(identity);
    file.add("state", now);
    detail::add_adam(file, "adam", learner_.state());
    file.add("best", best_);
    file.add("scores", scores_);
    file.add("history", detail::rows_of(history_));
    file.write(checkpoint);
    take_best();
    detector_.save(detector);
    detector_.restore(now);
  }

  /// \throws as read_checkpoint_file(), and FileError: malformed, mismatch (of another run)
  void restore(const std::string& checkpoint, const std::string& identity) {
    const auto file = read_checkpoint_file(checkpoint, identity);
    const auto adam = detail::adam_of(file, "adam", learner_.state().first_moment.size());
    const auto state = detail::weights_of(file, "state", best_);
    best_ = detail::weights_of(file, "best", best_);
    scores_ = file.get("scores").as<double>();
    history_ = detail::history_of<LossTerms>(file);
    detail::require_size(checkpoint, "adam_step", history_.size(), adam.step);
    const std::size_t due = validations_due();
    detail::require_size(checkpoint, "scores", std::clamp(scores_.size(), due - 1, due), scores_.size());
    detector_.restore(state);
    learner_.restore(adam);
  }

  void take_best() {
    detector_.restore(best_);
    detector_.set_pictures_seen(best_step() * settings_.batch);
  }

  [[nodiscard]] std::string progress_text() const {
    return formatted("step %zu of %zu: loss %.3f, AP50 %.1f %%, best %.1f %% after step %zu", history_.size(),
                     settings_.steps, history_.empty() ? 0 : history_.back().total, 100 * scores_.back(),
                     100 * scores_[best_validation()], best_step());
  }

 private:
  [[nodiscard]] std::size_t best_validation() const {
    return static_cast<std::size_t>(std::ranges::max_element(scores_) - scores_.begin());
  }
  /// Number of validations due before the next step, including one after the last step.
  [[nodiscard]] std::size_t validations_due() const {
    const bool is_cut = history_.size() == settings_.steps && settings_.steps % settings_.validate_every != 0;
    return history_.size() / settings_.validate_every + 1 + (is_cut ? 1 : 0);
  }

  LearningDetector& detector_;
  const DatasetTraining& settings_;
  const DatasetPictures& pictures_;
  Validate validate_;
  Learner learner_;
  Array<float, 4> batch_;
  loss::Truths truths_{};
  Array<float, 1> best_;  ///< see LearningDetector::state()
  std::vector<double> scores_{};
  std::vector<LossTerms> history_{};  ///< one entry a step
};
}  // namespace tapestry::shell
