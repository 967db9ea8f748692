#pragma once
#include <concepts>
#include <cstddef>
#include <cstring>
#include <memory>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/window_plan.hpp>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/mode.hpp>
#include <tapestry/nn/network/kept_values.hpp>
#include <tapestry/nn/window.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// nn::for_each_outside() of a value's map.
template <class Body>
void for_each_outside(const FeatureShape& shape, const nn::Window& outer, const nn::Window& inner,
                      Body body) {
  nn::for_each_outside({1, shape.height, shape.width, shape.channels}, outer, inner, body);
}

/// What a network keeps of a picture that changes within a window only: of each value those pixels around its
/// own window that are read to compute what has changed.
template <std::floating_point T>
struct KeptValues {
  std::shared_ptr<const WindowPlan> plan{};  ///< null: nothing is kept
  std::vector<nn::Buffer<T>> rings{};        ///< of each value; empty where nothing is needed
  nn::Buffer<T> picture{};                   ///< as it was
  std::weak_ptr<const void> weights{};       ///< that they were computed with
  nn::Mode mode = nn::Mode::inference;       ///< likewise

  [[nodiscard]] std::size_t bytes() const {
    std::size_t count = picture.size();
    for (const auto& ring : rings) count += ring.size();
    return count * sizeof(T);
  }

  /// Copies a value's ring from its activation, or back.
  void save(const FeatureShape& shape, std::size_t value, const T* values) {
    std::size_t count = 0;
    for_each_outside(shape, plan->read[value], plan->changed[value],
                     [&](std::size_t, std::size_t size) { count += size; });
    if (count == 0) return;
    rings[value].resize(count);
    T* to = rings[value].data();
    for_each_outside(shape, plan->read[value], plan->changed[value],
                     [&](std::size_t first, std::size_t size) {
                       std::memcpy(to, values + first, size * sizeof(T));
                       to += size;
                     });
  }
  void restore(const FeatureShape& shape, std::size_t value, T* values) const {
    if (rings[value].empty()) return;
    const T* from = rings[value].data();
    for_each_outside(shape, plan->read[value], plan->changed[value],
                     [&](std::size_t first, std::size_t size) {
                       std::memcpy(values + first, from, size * sizeof(T));
                       from += size;
                     });
  }

  /// Whether a picture of this shape is, outside of the window, the one that is kept, bit for bit.
  [[nodiscard]] bool is_same_outside(const FeatureShape& shape, const nn::Window& window,
                                     const T* other) const {
    bool is_same = true;
    for_each_outside(shape, whole_of(shape), window, [&](std::size_t first, std::size_t size) {
      is_same = is_same && std::memcmp(picture.data() + first, other + first, size * sizeof(T)) == 0;
    });
    return is_same;
  }
};

}  // namespace tapestry::detect::detail
