#pragma once
#include <memory>
#include <mutex>
#include <tapestry/autodiff/detail/tape/tape_state.hpp>
#include <tapestry/core/array.hpp>

namespace tapestry::detail {

template <std::size_t Rank>
[[nodiscard]] std::size_t count_of(const Extents<Rank>& extents) {
  std::size_t count = 1;
  for (const std::size_t extent : extents) count *= extent;
  return count;
}

/// Memory of forgotten arrays, kept for the next recording: fresh pages of the system cost more than most
/// operations. Holds at most the largest size that was in use at once, and frees arrays of other sizes before
/// it allocates. Any thread may give back.
template <class T>
class ArrayMemory {
 public:
  using Storage = typename Array<T, 1>::storage_type;

  std::size_t lane = 0;  ///< current lane of adjoints, see TapeAttachment::select_lane()

  /// Storage of `size` elements of any value.
  [[nodiscard]] Storage take(std::size_t size) {
    const std::scoped_lock lock(mutex_);
    lent_ += size;
    most_lent_ = std::max(most_lent_, lent_);
    const auto same_size = [size](const Storage& storage) { return storage.size() == size; };
    const auto found = std::find_if(held_.rbegin(), held_.rend(), same_size);
    if (found != held_.rend()) {
      Storage storage = std::move(*found);
      held_.erase(std::next(found).base());
      held_size_ -= size;
      return storage;
    }
    make_room(size);
    return Storage(size);
  }

  void give(Storage&& storage) noexcept {
    const std::scoped_lock lock(mutex_);
    const std::size_t size = storage.size();
    lent_ -= std::min(lent_, size);
    if (held_size_ + size > most_lent_ || held_.size() == held_.capacity()) return;
    held_size_ += size;
    held_.push_back(std::move(storage));
  }

 private:
  /// Frees the oldest arrays until those held and lent, with `size` more, are no more than were lent at once.
  void make_room(std::size_t size) {
    held_.reserve(64);
    std::size_t dropped = 0;
    while (dropped < held_.size() && held_size_ + lent_ > std::max(most_lent_, size))
      held_size_ -= held_[dropped++].size();
    held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(dropped));
  }

  std::mutex mutex_;
  std::vector<Storage> held_;  // oldest first
  std::size_t held_size_ = 0;
  std::size_t lent_ = 0;
  std::size_t most_lent_ = 0;
};

/// Arrays below this many bytes come from the heap directly.
inline constexpr std::size_t least_kept_bytes = 16384;

template <class T>
struct AttachedArrayMemory final : TapeAttachment {
  std::shared_ptr<ArrayMemory<T>> memory = std::make_shared<ArrayMemory<T>>();
  void select_lane(std::size_t lane) noexcept override { memory->lane = lane; }
};

template <class T>
[[nodiscard]] std::shared_ptr<ArrayMemory<T>> memory_of(TapeState<T>& state) {
  if (state.array_memory == nullptr) state.array_memory = new AttachedArrayMemory<T>;
  return static_cast<AttachedArrayMemory<T>&>(*state.array_memory).memory;
}

/// Gives an array elements of any value; `memory` may be null.
template <class T, std::size_t Rank>
void allocate(Array<T, Rank>& array, const Extents<Rank>& extents, ArrayMemory<T>* memory) {
  if (memory != nullptr && count_of(extents) * sizeof(T) >= least_kept_bytes)
    array.storage() = memory->take(count_of(extents));
  array.resize(extents);
}
template <class T, std::size_t Rank>
void release(Array<T, Rank>& array, ArrayMemory<T>* memory) noexcept {
  if (memory != nullptr && array.storage().size() * sizeof(T) >= least_kept_bytes)
    memory->give(std::move(array.storage()));
  array = Array<T, Rank>();
}

/// A shared array with elements of any value, whose memory returns to its
/// source; `memory` may be null.
template <class T, std::size_t Rank>
[[nodiscard]] std::shared_ptr<Array<T, Rank>> shared_array(const Extents<Rank>& extents,
                                                           std::shared_ptr<ArrayMemory<T>> memory) {
  if (memory == nullptr) return std::make_shared<Array<T, Rank>>(extents);
  auto array = std::make_unique<Array<T, Rank>>();
  allocate(*array, extents, memory.get());
  return {array.release(), [memory = std::move(memory)](Array<T, Rank>* mine) {
            release(*mine, memory.get());
            delete mine;
          }};
}

}  // namespace tapestry::detail
