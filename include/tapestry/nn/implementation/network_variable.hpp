#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/network_variable.hpp>

namespace tapestry::nn::detail {
/// \throws ShapeError unless a tensor is one map or picture
[[nodiscard]] inline Extents<4> batch_of_maps(const char* what, const Shape& shape, std::size_t batch) {
  if (shape.size() != 4 || shape[0] != 1)
    throw ShapeError(
        {"nn::forward: ", what, " of the network is ", shape, ", expected four axes, the first of extent 1"});
  return {batch, shape[1], shape[2], shape[3]};
}

template <std::floating_point T>
void require_input(const Network<T>& network, const Array<T, 4>& x) {
  if (network.input_count() != 1)
    throw ShapeError({"nn::forward: the network has ", network.input_count(), " inputs, expected one"});
  if (x.shape(0) == 0) throw ShapeError("nn::forward: a batch of none");
  require_shape("nn::forward", "x", x, batch_of_maps("the input", network.input_shape(0), x.shape(0)));
  for (std::size_t i = 0; i < network.output_count(); ++i)
    static_cast<void>(batch_of_maps("a result", network.output_shape(i), 1));
}

/// \param weights  variables of the network's weights, or nothing
template <std::floating_point T, class... Weights>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> record_network(const Network<T>& network, Mode mode,
                                                              std::shared_ptr<NetworkPass<T>> pass,
                                                              const ArrayVariable<T, 4>& x,
                                                              const Weights&... weights) {
  if (!pass) pass = std::make_shared<NetworkPass<T>>();
  const std::size_t batch = x.value().shape(0);
  const auto input = std::make_shared<Buffer<T>>(x.value().size());
  std::copy_n(x.value().data(), input->size(), input->data());
  network.forward({input->data()}, *pass, mode, batch);
  std::vector<Array<T, 4>> results;
  for (std::size_t i = 0; i < network.output_count(); ++i) {
    results.emplace_back(batch_of_maps("a result", network.output_shape(i), batch));
    std::copy_n(pass->output(i), results.back().size(), results.back().data());
  }
  const auto pullback = [&network, pass, input](const std::vector<const Array<T, 4>*>& adjoints,
                                                Array<T, 4>* x_adjoint, auto*... weights_adjoint) {
    std::vector<const T*> of_results;
    for (const auto* adjoint : adjoints) of_results.push_back(adjoint == nullptr ? nullptr : adjoint->data());
    T* of_weights = nullptr;
    ((of_weights = weights_adjoint == nullptr ? nullptr : weights_adjoint->data()), ...);
    network.adjoint(*pass, of_results, {x_adjoint == nullptr ? nullptr : x_adjoint->data()}, of_weights);
  };
  return record_arrays<T, 4>(std::move(results), pullback, x, weights...);
}
}  // namespace tapestry::nn::detail

namespace tapestry::nn {
template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(const Network<T>& network, const ArrayVariable<T, 4>& x,
                                         std::shared_ptr<NetworkPass<T>> pass) {
  detail::require_input(network, x.value());
  return detail::record_network(network, x.is_active() ? Mode::input_gradient : Mode::inference,
                                std::move(pass), x);
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(Network<T>& network, const ArrayVariable<T, 4>& x,
                                         const ArrayVariable<T, 1>& weights,
                                         std::shared_ptr<NetworkPass<T>> pass) {
  detail::require_input(network, x.value());
  require_shape("nn::forward", "weights", weights.value(), {network.weights().size()});
  tapestry::detail::require_recordable<T>(x.link(), weights.link());
  network.set_weights({weights.value().data(), weights.value().size()});
  return detail::record_network(std::as_const(network), Mode::training, std::move(pass), x, weights);
}
}  // namespace tapestry::nn

namespace tapestry::nn::detail {
/// One operator of networks applied to maps: what its record keeps.
template <std::floating_point T>
class LayerRecord {
 public:
  /// \param node     its name, attributes and results; of its operands x is the first, weights come after it
  /// \param x        [N, H, W, C]
  /// \throws as the operator's maker, with the operator's name
  LayerRecord(Node node, const Array<T, 4>& x) : node_(std::move(node)) {
    input_.resize(x.size());
    std::copy_n(x.data(), x.size(), input_.data());
    add_operand(Shape(x.shape().begin(), x.shape().end()), nullptr, 0);
  }

  template <std::size_t Rank>
  void add_weights(const Array<T, Rank>& weights) {
    add_operand(Shape(weights.shape().begin(), weights.shape().end()), weights.data(), weights.size());
  }

  [[nodiscard]] Array<T, 4> forward(bool keeps) {
    std::vector<Operand> operands;
    for (std::size_t i = 0; i < shapes_.size(); ++i)
      operands.push_back({shapes_[i], ElementType::floating, i == 0 ? nullptr : &constants_[i], true});
    try {
      OperatorContext context(node_, 18, std::move(operands), true);
      operation_ = made_operation(operators<T>().at(node_.operation), context);
    } catch (const ShapeError& error) {
      throw ShapeError({"nn::", node_.name, ": ", error.what()});
    } catch (const DomainError& error) {
      throw DomainError({"nn::", node_.name, ": ", error.what()});
    }
    std::vector<TensorView<const T>> views = inputs();
    operation_->prepare(views);
    const Shape& shape = operation_->result_shape();
    Array<T, 4> result(Extents<4>{shape[0], shape[1], shape[2], shape[3]});
    const std::vector<TensorView<T>> results{{&shape, result.data()}};
    operation_->forward({views, results, state_, keeps, Engine::automatic});
    return result;
  }

  /// \param goals  where the adjoint of each operand is added, null where it is not wanted
  void adjoint(const Array<T, 4>& result_adjoint, const std::vector<T*>& goals) {
    Buffer<T> own;  // a copy, because the operation may overwrite it
    own.resize(result_adjoint.size());
    std::copy_n(result_adjoint.data(), own.size(), own.data());
    const std::vector<TensorView<const T>> views = inputs(),
                                           no_results{{&operation_->result_shape(), nullptr}};
    const std::vector<TensorView<T>> adjoints{{&operation_->result_shape(), own.data()}};
    std::vector<TensorView<T>> wanted;
    for (std::size_t i = 0; i < shapes_.size(); ++i)
      wanted.push_back({&shapes_[i], i < goals.size() ? goals[i] : nullptr});
    const std::unique_ptr<bool[]> is_uninitialised(new bool[shapes_.size()]());
    operation_->adjoint({views, no_results, adjoints, wanted,
                         std::span(is_uninitialised.get(), shapes_.size()), state_, Engine::automatic});
  }

 private:
  void add_operand(Shape shape, const T* values, std::size_t count) {
    shapes_.push_back(std::move(shape));
    constants_.push_back({shapes_.back(), ElementType::floating, std::vector<T>(values, values + count)});
    node_.inputs.push_back(std::to_string(shapes_.size()));
  }

  [[nodiscard]] std::vector<TensorView<const T>> inputs() const {
    std::vector<TensorView<const T>> views{{&shapes_[0], input_.data()}};
    for (std::size_t i = 1; i < shapes_.size(); ++i)
      views.push_back({&shapes_[i], std::get<std::vector<T>>(constants_[i].values).data()});
    return views;
  }

  Node node_;
  Buffer<T> input_;
  std::vector<Shape> shapes_;
  std::vector<Constant> constants_;
  std::unique_ptr<Operation<T>> operation_;
  OperationState<T> state_{};
};

/// The layer on the tape. \param fixed operands behind the weights, without derivatives
template <std::floating_point T, class... Weights>
[[nodiscard]] ArrayVariable<T, 4> record_layer(Node node, const std::vector<Array<T, 1>>& fixed,
                                               const ArrayVariable<T, 4>& x, const Weights&... weights) {
  const auto record = std::make_shared<LayerRecord<T>>(std::move(node), x.value());
  (record->add_weights(weights.value()), ...);
  for (const auto& operand : fixed) record->add_weights(operand);
  const bool keeps = x.is_active() || (weights.is_active() || ...);
  const auto pullback = [record](const Array<T, 4>& value_adjoint, auto*... adjoints) {
    record->adjoint(value_adjoint, {(adjoints == nullptr ? nullptr : adjoints->data())...});
  };
  return record_array(record->forward(keeps), pullback, x, weights...);
}

[[nodiscard]] inline Attribute repeated(std::size_t count, std::size_t value) {
  return std::vector<std::int64_t>(count, static_cast<std::int64_t>(value));
}

[[nodiscard]] inline Node convolution_node(const ConvolutionLayer& layer) {
  return {"convolve",
          "Conv",
          {},
          {"y"},
          {{"strides", repeated(2, layer.stride)},
           {"pads", repeated(4, layer.padding)},
           {"dilations", repeated(2, layer.dilation)},
           {"group", static_cast<std::int64_t>(layer.groups)}}};
}

[[nodiscard]] inline Node pooling_node(const char* name, const char* operation, const PoolingLayer& layer) {
  return {name,
          operation,
          {},
          {"y"},
          {{"kernel_shape", repeated(2, layer.size)},
           {"strides", repeated(2, layer.stride)},
           {"pads", repeated(4, layer.padding)}}};
}
}  // namespace tapestry::nn::detail

namespace tapestry::nn {
template <std::floating_point T>
ArrayVariable<T, 4> convolve(const ArrayVariable<T, 4>& x, const ArrayVariable<T, 4>& weights,
                             const ArrayVariable<T, 1>& bias, const ConvolutionLayer& layer) {
  return detail::record_layer<T>(detail::convolution_node(layer), {}, x, weights, bias);
}

template <std::floating_point T>
ArrayVariable<T, 4> convolve(const ArrayVariable<T, 4>& x, const ArrayVariable<T, 4>& weights,
                             const ConvolutionLayer& layer) {
  return detail::record_layer<T>(detail::convolution_node(layer), {}, x, weights);
}

template <std::floating_point T>
ArrayVariable<T, 4> max_pool(const ArrayVariable<T, 4>& x, const PoolingLayer& layer) {
  return detail::record_layer<T>(detail::pooling_node("max_pool", "MaxPool", layer), {}, x);
}

template <std::floating_point T>
ArrayVariable<T, 4> average_pool(const ArrayVariable<T, 4>& x, const PoolingLayer& layer) {
  return detail::record_layer<T>(detail::pooling_node("average_pool", "AveragePool", layer), {}, x);
}

template <std::floating_point T>
ArrayVariable<T, 4> batch_norm(const ArrayVariable<T, 4>& x, const ArrayVariable<T, 1>& scale,
                               const ArrayVariable<T, 1>& bias, double epsilon) {
  Node node{"batch_norm",
            "BatchNormalization",
            {},
            {"y"},
            {{"training_mode", std::int64_t(1)}, {"epsilon", epsilon}}};
  const auto running = zeros<T, 1>({scale.value().size()});  // running statistics, which are not used
  return detail::record_layer<T>(std::move(node), {running, running}, x, scale, bias);
}
}  // namespace tapestry::nn
