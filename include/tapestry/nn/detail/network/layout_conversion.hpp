#pragma once
#include <tapestry/nn/detail/layout.hpp>
#include <tapestry/nn/detail/network/operation.hpp>
#include <tapestry/nn/pointwise.hpp>

namespace tapestry::nn {
/// Extents of a tensor [N, C, H, W] that is stored channels last, and back; of other ranks the same.
[[nodiscard]] inline Shape stored_shape(const Shape& logical) {
  return logical.size() == 4 ? Shape{logical[0], logical[2], logical[3], logical[1]} : logical;
}
[[nodiscard]] inline Shape logical_shape(const Shape& stored) {
  return stored.size() == 4 ? Shape{stored[0], stored[3], stored[1], stored[2]} : stored;
}

/// Shape with leading axes of extent 1 added, up to four axes.
[[nodiscard]] inline Shape padded_shape(const Shape& shape) {
  Shape padded(shape.size() < 4 ? 4 - shape.size() : 0, 1);
  padded.insert(padded.end(), shape.begin(), shape.end());
  return padded;
}

/// The values of a constant in the other order of axes.
/// \param logical  [N, C, H, W]
/// \param to_last  from that order to channels last, else back
[[nodiscard]] inline Constant reordered(const Constant& constant, const Shape& logical, bool to_last) {
  const std::size_t channels = logical[1], pixels = logical[2] * logical[3];
  Constant moved{to_last ? stored_shape(logical) : logical, constant.type};
  std::visit(
      [&](const auto& from) {
        std::vector<std::remove_cvref_t<decltype(from[0])>> values(from.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
          const std::size_t channel = i % channels, pixel = i / channels % pixels;
          const std::size_t place = ((i / channels / pixels) * channels + channel) * pixels + pixel;
          values[to_last ? i : place] = from[to_last ? place : i];
        }
        moved.values = std::move(values);
      },
      constant.values);
  return moved;
}

/// A constant of up to four axes as it is stored channels last.
[[nodiscard]] inline Constant to_channels_last(const Constant& constant) {
  return reordered(constant, padded_shape(constant.shape), true);
}

/// A constant of four axes that is stored channels last, in ONNX's order of axes.
[[nodiscard]] inline Constant from_channels_last(const Constant& stored) {
  return reordered(stored, logical_shape(stored.shape), false);
}

/// Stores a tensor of four axes in the other layout.
template <std::floating_point T>
class LayoutConversion : public Operation<T> {
 public:
  /// \param logical  [N, C, H, W]
  /// \param to_last  from that to [N, H, W, C], else back
  LayoutConversion(const Shape& logical, ElementType type, bool to_last)
      : Operation<T>({{to_last ? stored_shape(logical) : logical, type}}),
        images_(logical[0]),
        channels_(logical[1]),
        pixels_(logical[2] * logical[3]),
        to_last_(to_last) {}

  void forward(const ForwardCall<T>& call) const override {
    convert(to_last_, call.inputs[0].values, call.outputs[0].values);
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const from = call.output_adjoints[0].values;
    if (call.is_uninitialised[0]) {
      convert(!to_last_, from, call.input_adjoints[0].values);
      call.is_uninitialised[0] = false;
      return;
    }
    call.state.values.resize(images_ * channels_ * pixels_);
    convert(!to_last_, from, call.state.values.data());
    add(call.state.values.data(), call.input_adjoints[0].values, call.state.values.size());
  }

 private:
  void convert(bool to_last, const T* from, T* to) const {
    if (to_last) {
      nn::channels_last(images_, channels_, pixels_, from, to);
    } else {
      nn::channels_first(images_, channels_, pixels_, from, to);
    }
  }

  std::size_t images_, channels_, pixels_;
  bool to_last_;
};
}  // namespace tapestry::nn
