#pragma once
#include <cstddef>
#include <optional>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/window_plan.hpp>
#include <tapestry/nn/window.hpp>

namespace tapestry::detect::detail {

/// How much of each value a pass computes.
class PassExtents {
 public:
  /// \param plan  of the one image, or null for all of all images
  PassExtents(const Graph& graph, std::size_t images, const WindowPlan* plan)
      : graph_(&graph), images_(images), plan_(plan) {}

  /// All values, computed or not.
  [[nodiscard]] std::size_t size_of(std::size_t value) const {
    return images_ * graph_->shapes[value].size();
  }
  [[nodiscard]] std::size_t pixels_of(std::size_t value) const {
    return images_ * graph_->shapes[value].height * graph_->shapes[value].width;
  }

  /// What is computed; none: all.
  [[nodiscard]] std::optional<nn::Window> window_of(std::size_t value) const {
    if (plan_ == nullptr) return {};
    const FeatureShape& shape = graph_->shapes[value];
    const nn::Window& window = plan_->changed[value];
    return window.covers(shape.height, shape.width) ? std::nullopt : std::optional(window);
  }

  /// Calls body(first pixel, count) for runs of pixels that are computed; see for_each_run().
  template <class Body>
  void for_each_pixels(std::size_t value, Body body) const {
    for_each_run(images_, graph_->shapes[value], window_of(value), body);
  }
  /// Calls body(place, count) for runs of values that are computed.
  template <class Body>
  void for_each_values(std::size_t value, Body body) const {
    const std::size_t channels = graph_->shapes[value].channels;
    for_each_pixels(value,
                    [&](std::size_t first, std::size_t count) { body(first * channels, count * channels); });
  }

 private:
  const Graph* graph_;
  std::size_t images_;
  const WindowPlan* plan_;
};

}  // namespace tapestry::detect::detail
