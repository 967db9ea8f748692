#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/prepared_weights.hpp>
#include <tapestry/nn/convolution_window.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/pointwise.hpp>
#include <tapestry/nn/window.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// What must be computed anew, forward and backward, when one picture changes within a window. Windows are
/// those of pixels of each value, the image's included. They hold whatever changes by a bit: where
/// convolutions round by tiles that is more than the receptive field.
struct WindowPlan {
  nn::Engine engine = nn::Engine::automatic;  ///< whose tiles they are
  /// Of each value: all that depends on the picture's window, and the adjoint of all else is not needed.
  /// Never empty.
  std::vector<nn::Window> changed{};
  /// Of each value: `changed`, and around it what is read to compute what has changed elsewhere.
  std::vector<nn::Window> read{};
};

[[nodiscard]] inline nn::Window whole_of(const FeatureShape& shape) {
  return {{0, shape.height}, {0, shape.width}};
}

/// Calls body(first pixel, count) for pixels of a window that lie side by side, of one image; without a
/// window once for those of all images. Runs of different rows may be on different threads.
template <class Body>
void for_each_run(std::size_t images, const FeatureShape& shape, const std::optional<nn::Window>& window,
                  Body body) {
  if (!window) return body(std::size_t(0), images * shape.height * shape.width);
  if (window->width() == shape.width) {
    body(window->rows.begin * shape.width, window->height() * shape.width);
    return;
  }
  parallel_for(window->height(), [&](std::size_t row) {
    body((window->rows.begin + row) * shape.width + window->columns.begin, window->width());
  });
}

/// Share of the multiply-adds of a network's convolutions that a plan leaves out.
[[nodiscard]] inline double share_left_out(const Graph& graph, const WindowPlan& plan) {
  double all = 0, planned = 0;
  for (std::size_t i = 0; i < graph.image(); ++i) {
    if (graph.config.layers[i].kind != LayerKind::convolutional) continue;
    const nn::ConvolutionShape shape = graph.convolution(i);
    const double of_pixel = static_cast<double>(shape.taps() * shape.in_channels / shape.groups) *
                            static_cast<double>(shape.out_channels);
    all += of_pixel * static_cast<double>(graph.shapes[i].height * graph.shapes[i].width);
    planned += of_pixel * static_cast<double>(plan.changed[i].height() * plan.changed[i].width());
  }
  return all > 0 ? 1 - planned / all : 0;
}

/// Makes the plan of a network, from the layers' receptive fields.
template <class T>
class WindowPlanner {
 public:
  /// \param adjoint_weights  null if no adjoint will be asked for
  WindowPlanner(const Graph& graph, nn::Engine engine, const ForwardWeights<T>& weights,
                const AdjointWeights<T>* adjoint_weights)
      : graph_(graph), engine_(engine), weights_(weights), adjoint_weights_(adjoint_weights) {}

  /// \param picture  the window that changes, not empty
  [[nodiscard]] WindowPlan plan(const nn::Window& picture) {
    plan_.engine = engine_;
    plan_.changed.resize(graph_.image() + 1);
    plan_.changed.back() = picture;
    for (std::size_t i = 0; i < graph_.image(); ++i)
      if (graph_.makes_value(i)) plan_.changed[i] = reached(i);
    for (std::size_t i = graph_.image(); i-- > 0;)
      if (is_plain_sum(i))
        for (const std::size_t input : graph_.inputs[i])
          if (is_read_only_by(i, input)) plan_.changed[input] = plan_.changed[i];
    plan_.read = plan_.changed;
    for (std::size_t i = 0; i < graph_.image(); ++i)
      if (graph_.makes_value(i)) read_inputs(i);
    for (const std::size_t value : graph_.head_values) plan_.read[value] = whole_of(graph_.shapes[value]);
    return std::move(plan_);
  }

 private:
  [[nodiscard]] bool is_plain_sum(std::size_t i) const {
    return graph_.makes_value(i) && graph_.config.layers[i].kind == LayerKind::shortcut &&
           std::ranges::all_of(graph_.inputs[i], [&](std::size_t v) { return graph_.is_whole(i, v); });
  }
  /// What only a sum reads may be made in the sum's place, and then within the sum's window.
  [[nodiscard]] bool is_read_only_by(std::size_t i, std::size_t value) const {
    return value != graph_.image() && graph_.first_use[value] == i && graph_.last_use[value] == i;
  }

  /// What is computed of a layer's output: its window, and what shares tiles with it.
  [[nodiscard]] nn::Window computed(std::size_t i) const {
    nn::Window window = plan_.changed[i];
    const auto grow = [&](std::size_t convolution) {
      const std::size_t tile = nn::tile_of(engine_, weights_.convolutions[convolution]).outputs;
      const FeatureShape& shape = graph_.shapes[i];
      window = nn::hull(window, {nn::aligned(plan_.changed[i].rows, tile, shape.height),
                                 nn::aligned(plan_.changed[i].columns, tile, shape.width)});
    };
    if (graph_.config.layers[i].kind == LayerKind::convolutional) grow(i);
    if (is_plain_sum(i))
      for (const std::size_t input : graph_.inputs[i])
        if (is_read_only_by(i, input) && graph_.config.layers[input].kind == LayerKind::convolutional)
          grow(input);
    return window;
  }

  [[nodiscard]] std::span<const nn::PackedConvolution<T>> adjoint_parts(std::size_t i) const {
    if (adjoint_weights_ == nullptr) return {};
    return adjoint_weights_->convolutions[i];
  }

  /// Where layer i's output depends on changed inputs, and where its adjoint is read to compute theirs.
  [[nodiscard]] nn::Window reached(std::size_t i) const {
    const LayerConfig& layer = graph_.config.layers[i];
    const nn::Window& in = plan_.changed[graph_.inputs[i].front()];
    if (layer.kind == LayerKind::convolutional && has_whole_bytes(i)) return reached_by_convolution(i, in);
    if (layer.kind == LayerKind::maxpool) {
      const nn::PoolingShape shape = graph_.pooling(i);
      return {nn::outputs_reached(shape.rows(), {}, in.rows),
              nn::outputs_reached(shape.columns(), {}, in.columns)};
    }
    if (layer.kind == LayerKind::upsample) return nn::pixels_of_blocks(in, layer.stride, layer.stride);
    if (layer.kind == LayerKind::route || (is_plain_sum(i) && has_whole_bytes(i))) {
      nn::Window window = in;
      for (const std::size_t input : graph_.inputs[i]) window = nn::hull(window, plan_.changed[input]);
      return window;
    }
    return whole_of(graph_.shapes[i]);
  }

  [[nodiscard]] nn::Window reached_by_convolution(std::size_t i, const nn::Window& in) const {
    const nn::ConvolutionShape shape = graph_.convolution(i);
    const nn::OutputTile tile = nn::tile_of(engine_, weights_.convolutions[i]);
    nn::Window window{nn::outputs_reached(shape.rows, tile, in.rows),
                      nn::outputs_reached(shape.columns, tile, in.columns)};
    for (const auto& part : adjoint_parts(i)) {
      const nn::Window outputs = nn::outputs_inside(part, in);
      const nn::OutputTile own = nn::tile_of(engine_, part);
      window.rows = nn::hull(window.rows, nn::inputs_needed(part.shape.rows, own, outputs.rows));
      window.columns = nn::hull(window.columns, nn::inputs_needed(part.shape.columns, own, outputs.columns));
    }
    return window;
  }

  /// Whether the sign bits of each pixel begin at a byte of their own, if there are any.
  [[nodiscard]] bool has_whole_bytes(std::size_t i) const {
    return !nn::slope_needs_sign(graph_.config.layers[i].activation) || graph_.shapes[i].channels % 8 == 0;
  }

  /// Adds to plan_.read what layer i reads to compute what has changed.
  void read_inputs(std::size_t i) {
    const LayerConfig& layer = graph_.config.layers[i];
    const nn::Window out = computed(i);
    for (const std::size_t input : graph_.inputs[i]) {
      nn::Window window = whole_of(graph_.shapes[input]);
      if (layer.kind == LayerKind::convolutional) {
        const nn::ConvolutionShape shape = graph_.convolution(i);
        const nn::OutputTile tile = nn::tile_of(engine_, weights_.convolutions[i]);
        window = {nn::inputs_needed(shape.rows, tile, out.rows),
                  nn::inputs_needed(shape.columns, tile, out.columns)};
      } else if (layer.kind == LayerKind::maxpool) {
        const nn::PoolingShape shape = graph_.pooling(i);
        window = {nn::inputs_needed(shape.rows(), {}, out.rows),
                  nn::inputs_needed(shape.columns(), {}, out.columns)};
      } else if (layer.kind == LayerKind::upsample) {
        window = nn::blocks_of_pixels(out, layer.stride, layer.stride);
      } else if (layer.kind == LayerKind::route || is_plain_sum(i)) {
        window = out;
      }
      plan_.read[input] = nn::hull(plan_.read[input], window);
    }
  }

  const Graph& graph_;
  nn::Engine engine_;
  const ForwardWeights<T>& weights_;
  const AdjointWeights<T>* adjoint_weights_;
  WindowPlan plan_{};
};

}  // namespace tapestry::detect::detail
