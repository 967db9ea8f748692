#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tapestry/autodiff/tape/huge_page_allocator.hpp>
#include <tapestry/autodiff/tape/tape_record.hpp>
#include <tapestry/autodiff/tape/vector_adjoints.hpp>
#include <vector>

namespace tapestry::detail {

/// Runs the pullbacks of a tape's records in a sweep of several roots: one root after the other, each with
/// adjoints of its own, which are taken out of the vectors and put back. Array adjoints are in lanes from 1
/// on.
template <std::floating_point T, std::size_t Width>
class VectorPullbacks {
 public:
  /// \param lane_count  roots, at most Width; \param attachment  what keeps array adjoints, or null
  VectorPullbacks(std::span<const HeldRecord<T>> records, std::size_t lane_count, std::size_t last,
                  TapeAttachment* attachment, VectorAdjoints<T, Width>& adjoints)
      : records_(records),
        next_(records.size()),
        lane_count_(lane_count),
        attachment_(attachment),
        adjoints_(adjoints) {
    if (records.empty()) return;
    for_each_lane(Width, [&](std::size_t) {
      for (const HeldRecord<T>& held : records_) held.record->forget_adjoint();
    });
    std::size_t most_results = 0;
    for (const HeldRecord<T>& held : records_)
      if (held.results > most_results) most_results = held.results;
    std::size_t bytes = (last + 1 + most_results) * sizeof(T);
    memory_ = PageMemory(allocate_pages(bytes));
  }
  VectorPullbacks(const VectorPullbacks&) = delete;
  VectorPullbacks& operator=(const VectorPullbacks&) = delete;
  ~VectorPullbacks() { select(0); }

  void skip() { --next_; }

  /// The record before, which is statement `statement`.
  void run(std::size_t statement) {
    const HeldRecord<T>& held = records_[--next_];
    inputs_.clear();
    held.record->list_inputs(inputs_);
    const auto view = adjoints_.view();
    T* const single = reinterpret_cast<T*>(memory_.get());
    for_each_lane(lane_count_, [&](std::size_t lane) {
      if (inputs_.empty() && lane > 0) return;  // a place to come by
      single[statement] = view.in_window(statement)[lane];
      for (std::size_t i = statement + 1; i <= statement + held.results; ++i) {
        const T* const all = adjoints_.passed(i);
        single[i] = all == nullptr ? T(0) : all[lane];
      }
      for (const std::uint32_t i : inputs_) single[i] = view.at(i, adjoints_)[lane];
      held.record->pull_back(single, statement);
      for (const std::uint32_t i : inputs_) view.at(i, adjoints_)[lane] = single[i];
    });
  }

 private:
  void select(std::size_t lane) const {
    if (attachment_ != nullptr) attachment_->select_lane(lane);
  }
  template <class Visit>
  void for_each_lane(std::size_t count, Visit visit) const {
    for (std::size_t lane = 0; lane < count; ++lane) {
      select(lane + 1);
      visit(lane);
    }
    select(0);
  }

  std::span<const HeldRecord<T>> records_;
  std::size_t next_;
  std::size_t lane_count_;
  TapeAttachment* attachment_;
  VectorAdjoints<T, Width>& adjoints_;
  PageMemory memory_;  // adjoints of one lane, of those statements that a record is about to use
  std::vector<std::uint32_t> inputs_;
};

}  // namespace tapestry::detail
