#pragma once
#include <tapestry/autodiff/detail/tape/tape_state.hpp>
#include <tapestry/core/array.hpp>

namespace tapestry::detail {
template <std::size_t Rank>
[[nodiscard]] std::size_t count_of(const Extents<Rank>& extents) {
  std::size_t count = 1;
  for (const std::size_t extent : extents) count *= extent;
  return count;
}

/// Number of the current lane of adjoints, see TapeAttachment::select_lane(), shared by a tape's arrays.
using AdjointLane = std::shared_ptr<std::size_t>;

struct AttachedLane final : TapeAttachment {
  AdjointLane number = std::make_shared<std::size_t>(0);
  void select_lane(std::size_t lane) noexcept override { *number = lane; }
};

template <class T>
[[nodiscard]] const AdjointLane& lane_of(TapeState<T>& state) {
  if (state.adjoint_lane == nullptr) state.adjoint_lane = new AttachedLane;
  return static_cast<AttachedLane&>(*state.adjoint_lane).number;
}
}  // namespace tapestry::detail
