#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/layers_variable.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/operation.hpp>
#include <tapestry/nn/network/operator_context.hpp>
#include <tapestry/nn/network/operators.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <utility>
#include <vector>

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
      operation_ = operators<T>().at(node_.operation).make(context);
      context.require_all_asked();
    } catch (const ShapeError& error) {
      throw ShapeError("nn::" + node_.name + ": " + error.what());
    } catch (const DomainError& error) {
      throw DomainError("nn::" + node_.name + ": " + error.what());
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
    Buffer<T> own;  // which the operation may overwrite
    own.resize(result_adjoint.size());
    std::copy_n(result_adjoint.data(), own.size(), own.data());
    const std::vector<TensorView<const T>> views = inputs(),
                                           no_results{{&operation_->result_shape(), nullptr}};
    const std::vector<TensorView<T>> adjoints{{&operation_->result_shape(), own.data()}};
    std::vector<TensorView<T>> wanted;
    for (std::size_t i = 0; i < shapes_.size(); ++i)
      wanted.push_back({&shapes_[i], i < goals.size() ? goals[i] : nullptr});
    const std::unique_ptr<bool[]> is_fresh(new bool[shapes_.size()]());
    operation_->adjoint({views, no_results, adjoints, wanted, std::span(is_fresh.get(), shapes_.size()),
                         state_, Engine::automatic});
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

/// The layer on the tape. \param fixed  operands behind the weights that nothing depends on
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

[[nodiscard]] inline Attribute both(std::size_t count, std::size_t value) {
  return std::vector<std::int64_t>(count, static_cast<std::int64_t>(value));
}

[[nodiscard]] inline Node convolution_node(const ConvolutionLayer& layer) {
  return {"convolve",
          "Conv",
          {},
          {"y"},
          {{"strides", both(2, layer.stride)},
           {"pads", both(4, layer.padding)},
           {"dilations", both(2, layer.dilation)},
           {"group", static_cast<std::int64_t>(layer.groups)}}};
}

[[nodiscard]] inline Node pooling_node(const char* name, const char* operation, const PoolingLayer& layer) {
  return {name,
          operation,
          {},
          {"y"},
          {{"kernel_shape", both(2, layer.size)},
           {"strides", both(2, layer.stride)},
           {"pads", both(4, layer.padding)}}};
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
  const auto running = zeros<T, 1>({scale.value().size()});  // statistics that nobody asks for
  return detail::record_layer<T>(std::move(node), {running, running}, x, scale, bias);
}

template ArrayVariable<float, 4> convolve<float>(const ArrayVariable<float, 4>&,
                                                 const ArrayVariable<float, 4>&,
                                                 const ArrayVariable<float, 1>&, const ConvolutionLayer&);
template ArrayVariable<double, 4> convolve<double>(const ArrayVariable<double, 4>&,
                                                   const ArrayVariable<double, 4>&,
                                                   const ArrayVariable<double, 1>&, const ConvolutionLayer&);
template ArrayVariable<float, 4> convolve<float>(const ArrayVariable<float, 4>&,
                                                 const ArrayVariable<float, 4>&, const ConvolutionLayer&);
template ArrayVariable<double, 4> convolve<double>(const ArrayVariable<double, 4>&,
                                                   const ArrayVariable<double, 4>&, const ConvolutionLayer&);
template decltype(max_pool<float>) max_pool<float>;
template decltype(max_pool<double>) max_pool<double>;
template decltype(average_pool<float>) average_pool<float>;
template decltype(average_pool<double>) average_pool<double>;
template decltype(batch_norm<float>) batch_norm<float>;
template decltype(batch_norm<double>) batch_norm<double>;

}  // namespace tapestry::nn
