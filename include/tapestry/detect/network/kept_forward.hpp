#pragma once
#include <algorithm>
#include <cstddef>
#include <memory>
#include <tapestry/core/array.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/network/forward.hpp>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/kept_values.hpp>
#include <tapestry/detect/network/pass.hpp>
#include <tapestry/detect/network/prepared_weights.hpp>
#include <tapestry/detect/network/window_plan.hpp>
#include <tapestry/image/pixel_window.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/window.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// The plan of passes in a mode over one picture that changes within a window.
template <class T>
[[nodiscard]] WindowPlan plan_of(const Graph& graph, nn::Engine engine, const Array<T, 1>& parameters,
                                 WeightCache<T>& cache, Mode mode, const nn::Window& window) {
  const auto weights = cache.forward(graph, parameters, true);
  const auto adjoint = mode == Mode::inference ? nullptr : cache.adjoint(graph, parameters, true);
  WindowPlanner<T> planner(graph, engine, *weights, adjoint.get());
  return planner.plan(nn::at_least_a_pixel(window, graph.height, graph.width));
}

/// A forward pass over one image that changes within a window from call to call: what that does not reach is
/// taken from `kept`, which is filled if it does not hold.
///
/// \param weights  of cache.forward()
/// \param logits   of each head, [1, C, H, W], to write
template <class T>
void forward_kept(const Graph& graph, nn::Engine engine, const Array<T, 1>& parameters, WeightCache<T>& cache,
                  const std::shared_ptr<const ForwardWeights<T>>& weights, const T* image,
                  const nn::Window& window, KeptValues<T>& kept, Pass<T>& pass,
                  const std::vector<T*>& logits) {
  const FeatureShape& shape = graph.shapes.back();
  const bool holds = kept.plan && kept.weights.lock() == weights && kept.mode == pass.mode &&
                     kept.plan->engine == engine && kept.is_same_outside(shape, window, image);
  if (!holds) {
    kept.plan =
        std::make_shared<const WindowPlan>(plan_of(graph, engine, parameters, cache, pass.mode, window));
    kept.weights.reset();  // does not hold until it is full
    kept.mode = pass.mode;
    kept.picture.resize(shape.size());
    std::copy_n(image, shape.size(), kept.picture.data());
    kept.rings.clear();
    kept.rings.resize(graph.image() + 1);
  }
  ForwardPass<T>(graph, engine, parameters, *weights, pass, &kept, holds).run(image, logits);
  kept.weights = weights;
  pass.plan = kept.plan;
  pass.window = window;
}

}  // namespace tapestry::detect::detail
