#pragma once
#include <concepts>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/mode.hpp>
#include <tapestry/nn/network/program.hpp>
#include <tapestry/nn/network/window_plan.hpp>
#include <tapestry/nn/window.hpp>
#include <vector>

namespace tapestry::nn {

/// Calls body(place, count) for the elements of a map that lie in the window `outer`, or anywhere, but not in
/// `inner`, in runs that lie side by side.
template <class Body>
void for_each_outside(const Shape& map, const std::optional<Window>& outer, const Window& inner, Body body) {
  const std::size_t width = map[2], channels = map[3];
  const Window all = outer.value_or(Window{{0, map[1]}, {0, width}});
  const auto piece = [&](std::size_t y, std::size_t begin, std::size_t end) {
    if (begin < end) body((y * width + begin) * channels, (end - begin) * channels);
  };
  for (std::size_t y = all.rows.begin; y < all.rows.end; ++y) {
    if (y < inner.rows.begin || y >= inner.rows.end) {
      piece(y, all.columns.begin, all.columns.end);
    } else {
      piece(y, all.columns.begin, inner.columns.begin);
      piece(y, inner.columns.end, all.columns.end);
    }
  }
}

/// Memory of a network about a picture that changes from pass to pass within one window: of each value the
/// pixels around its own window that are read to compute what has changed. See Network::forward_within().
template <std::floating_point T>
struct KeptValues {
  std::shared_ptr<const WindowPlan> plan{};  ///< null: nothing is kept
  std::vector<Buffer<T>> rings{};            ///< of each value; empty where nothing is needed
  Buffer<T> picture{};                       ///< as it was
  std::weak_ptr<const void> constants{};     ///< that they were computed with
  Mode mode = Mode::inference;               ///< likewise

  [[nodiscard]] std::size_t bytes() const {
    std::size_t count = picture.size();
    for (const auto& ring : rings) count += ring.size();
    return count * sizeof(T);
  }

  /// Copies a value's ring from its elements, or back.
  void save(const Shape& map, std::size_t value, const T* values) {
    std::size_t count = 0;
    for_each_piece(map, value, [&](std::size_t, std::size_t size) { count += size; });
    rings[value].resize(count);
    T* to = rings[value].data();
    for_each_piece(map, value, [&](std::size_t first, std::size_t size) {
      std::memcpy(to, values + first, size * sizeof(T));
      to += size;
    });
  }
  void restore(const Shape& map, std::size_t value, T* values) const {
    const T* from = rings[value].data();
    for_each_piece(map, value, [&](std::size_t first, std::size_t size) {
      std::memcpy(values + first, from, size * sizeof(T));
      from += size;
    });
  }

  /// Whether a picture is, outside of its window, the one that is kept, bit for bit.
  [[nodiscard]] bool is_same_outside(const Shape& map, const T* other) const {
    bool is_same = true;
    for_each_outside(map, std::nullopt, plan->picture, [&](std::size_t first, std::size_t size) {
      is_same = is_same && std::memcmp(picture.data() + first, other + first, size * sizeof(T)) == 0;
    });
    return is_same;
  }

 private:
  template <class Body>
  void for_each_piece(const Shape& map, std::size_t value, Body body) const {
    if (plan->changed[value]) for_each_outside(map, plan->read[value], *plan->changed[value], body);
  }
};

}  // namespace tapestry::nn
