#pragma once
#include <cmath>
#include <optional>
#include <tapestry/autodiff/detail/tape/tape_memory.hpp>

namespace tapestry {
/// A statement of a tape with a value or partial derivative that is not finite.
struct NonFinite {
  std::size_t statement = 0;  ///< counted from 1
  bool is_value = false;      ///< else a partial derivative
  double number = 0;
  std::string label{};  ///< names of the labels around it, the outermost first, with '/' between

  /// One line for a message.
  [[nodiscard]] std::string description() const {
    return std::string(is_value ? "the value" : "a partial derivative") + " of statement " +
           std::to_string(statement) + (label.empty() ? "" : ", " + label + ",") + " is " +
           std::to_string(number);
  }
};

/// Products of slopes with 0 · ∞ or 0 · NaN, taken as 0.
struct ZeroProducts {
  std::size_t count = 0;
  std::size_t statement = 0;  ///< the first one, counted from 1; 0 if there is none
  std::string label{};        ///< as in NonFinite

  /// One line for a message.
  [[nodiscard]] std::string description() const {
    return std::to_string(count) + " times 0 met a number that is not finite" +
           (count == 0 ? "" : ", first in statement " + std::to_string(statement)) +
           (label.empty() ? "" : ", " + label);
  }
};

namespace detail {
/// Records of a tape beside its statements, to find where a NaN came from. Writing a statement does not touch
/// it, unless the statement finds no usual room; while values are watched, none does.
class TapeDiagnosis : public TapeMemory {
 public:
  void watch_values(bool on) {
    is_watching_ = on;
    refuse_usual_room(on);
  }
  [[nodiscard]] bool is_watching() const { return is_watching_; }

  /// Remembers the first of the values, if watched, that is not finite.
  void note_value(Link link, double value) {
    if (is_watching_ && !first_ && !std::isfinite(value)) first_ = NonFinite{link.index(), true, value};
  }
  [[nodiscard]] const std::optional<NonFinite>& first_value() const { return first_; }

  /// \returns a number that ends it
  std::size_t begin_label(std::string name) {
    labels_.push_back({++label_count_, next_index(), no_end, std::move(name)});
    return label_count_;
  }
  void end_label(std::size_t number) {
    for (Label& label : labels_)
      if (label.number == number) label.end = next_index();
  }
  [[nodiscard]] std::string label_of(std::size_t statement) const {
    std::string names;
    for (const Label& label : labels_)
      if (label.begin <= statement && statement < label.end) names += (names.empty() ? "" : "/") + label.name;
    return names;
  }

  /// Calls visit(path, begin, end) for each label: its name behind the names of outer labels, and
  /// its statements [begin, end).
  template <class Visit>
  void visit_labels(Visit visit) const {
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      std::string path;
      for (std::size_t j = 0; j < i; ++j)
        if (labels_[j].begin <= labels_[i].begin && labels_[i].begin < labels_[j].end)
          path += labels_[j].name + "/";
      visit(path + labels_[i].name, labels_[i].begin,
            labels_[i].end < next_index() ? labels_[i].end : next_index());
    }
  }

 protected:
  /// Forgets statements from `begin` on.
  void forget_diagnosis(std::size_t begin) noexcept {
    std::erase_if(labels_, [begin](const Label& label) { return label.begin >= begin; });
    for (Label& label : labels_)
      if (label.end != no_end && label.end > begin) label.end = begin;
    if (first_ && first_->statement >= begin) first_.reset();
  }

 private:
  static constexpr std::size_t no_end = std::numeric_limits<std::size_t>::max();

  /// A name of the statements from `begin` to `end`.
  struct Label {
    std::size_t number;
    std::size_t begin;
    std::size_t end;
    std::string name;
  };

  [[nodiscard]] std::size_t next_index() const { return statement_count() + 1; }

  std::vector<Label> labels_;
  std::size_t label_count_ = 0;
  std::optional<NonFinite> first_;
  bool is_watching_ = false;
};
}  // namespace detail
}  // namespace tapestry
