#pragma once
#include <tapestry/io/onnx/onnx_file.hpp>
#include "problem.hpp"

namespace tapestry::benchmarks {
/// A network of this library on the problem's picture.
template <std::floating_point T>
class GraphRun {
 public:
  /// \param simplifies  see nn::Network
  explicit GraphRun(const NetworkOptions& options, bool simplifies = true)
      : network_(read(options, simplifies)) {
    for (const float value : read_numbers<float>(options.input)) picture_.push_back(static_cast<T>(value));
    picture_.resize(picture_.size() + 128 / sizeof(T));  // may be read past the end
    for (std::size_t i = 0; i < network_.output_count(); ++i)
      weightings_.push_back(weighting<T>(nn::size_of(network_.output_shape(i))));
  }

  void forward(nn::Mode mode = nn::Mode::inference) { network_.forward({picture_.data()}, pass_, mode); }

  /// After forward() in Mode::input_gradient.
  void adjoint() {
    gradient_.assign(nn::size_of(network_.input_shape(0)), T(0));
    std::vector<const T*> adjoints;
    for (const auto& weights : weightings_) adjoints.push_back(weights.data());
    network_.adjoint(pass_, adjoints, {gradient_.data()});
  }

  /// Values of all outputs, one after the other.
  [[nodiscard]] std::vector<T> outputs() const {
    std::vector<T> values;
    for (std::size_t i = 0; i < network_.output_count(); ++i)
      values.insert(values.end(), pass_.output(i), pass_.output(i) + nn::size_of(network_.output_shape(i)));
    return values;
  }
  [[nodiscard]] const std::vector<T>& gradient() const { return gradient_; }

 private:
  [[nodiscard]] static nn::Network<T> read(const NetworkOptions& options, bool simplifies) {
    const auto description = io::read_onnx(options.model);
    const nn::Shape shape{1, 3, options.size, options.size};
    return nn::Network<T>(description, {{description.inputs.at(0).name, shape}}, false, simplifies);
  }

  nn::Network<T> network_;
  nn::NetworkPass<T> pass_;
  std::vector<T> picture_;
  std::vector<std::vector<T>> weightings_;
  std::vector<T> gradient_;
};
}  // namespace tapestry::benchmarks
