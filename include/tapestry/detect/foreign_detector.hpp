#pragma once
#include <concepts>
#include <cstddef>
#include <functional>
#include <mutex>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/nn/network/network.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

/// An output of a foreign engine, values in row-major order.
struct ForeignOutput {
  nn::Shape shape{};
  std::vector<float> values{};
};

/// A detector that another library runs, such as OpenCV, ONNX Runtime or TensorRT, for models that our
/// readers do not read: everything that measures by forward passes takes it. It has no gradients; who asks
/// for one is refused.
template <std::floating_point T>
class ForeignDetector final : public Detector<T> {
 public:
  /// Runs the model on one picture, [3, H, W] of the input's extents, encoded as the description says, and
  /// returns the output with boxes and, unless it is the same, the one with scores. It is never called by two
  /// threads at once.
  using Engine = std::function<std::vector<ForeignOutput>(const std::vector<float>& picture)>;

  /// Runs the engine once, to know its outputs.
  /// \param kind           of boxes_and_scores
  /// \param height, width  of the model's input, pixels
  /// \throws DomainError for heads of another kind; FileError (mismatch) as GraphDetector, if the outputs are
  ///         not as described
  ForeignDetector(Engine engine, DetectorDescription kind, std::size_t height, std::size_t width)
      : engine_(std::move(engine)),
        kind_(std::move(kind)),
        height_(height),
        width_(width),
        shapes_(shapes_of(run_first(engine_, 3 * height * width))),
        decoding_(decoding_of(kind_, shapes_, height, width)),
        heads_(exported_heads(subject, kind_, {decoding_.output_shape(0)}, height, width)) {}

  [[nodiscard]] std::size_t input_height() const override { return height_; }
  [[nodiscard]] std::size_t input_width() const override { return width_; }
  [[nodiscard]] const std::vector<Head>& heads() const override { return heads_.heads; }

  /// \throws DomainError in another mode than inference; FileError (mismatch) if the engine's outputs change
  ///         their extents; otherwise as Detector::forward()
  void forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode = Mode::inference) const override;

  void pull_back(Pass<T>&, const std::vector<const Array<T, 4>*>&, Array<T, 4>*,
                 Array<T, 1>* = nullptr) const override {
    refuse_gradient("pull_back");
  }
  [[nodiscard]] Array<T, 3> layer_values(const Pass<T>&, std::size_t, std::size_t) const override {
    refuse_gradient("layer_values");
  }
  [[nodiscard]] Array<T, 3> layer_adjoint(Pass<T>&, const std::vector<const Array<T, 4>*>&, std::size_t,
                                          std::size_t) const override {
    refuse_gradient("layer_adjoint");
  }
  void pull_back_layer(Pass<T>&, std::size_t, std::size_t, const Array<T, 3>&, Array<T, 4>&) const override {
    refuse_gradient("pull_back_layer");
  }

 private:
  [[noreturn]] static void refuse_gradient(const char* operation);

  static constexpr const char* subject = "outputs of a foreign detector";

  [[nodiscard]] static std::vector<ForeignOutput> run_first(const Engine& engine, std::size_t size);

  /// The network that makes a head's logits of outputs of these extents.
  [[nodiscard]] static nn::NetworkDescription decoding_of(const DetectorDescription& kind,
                                                          const std::vector<nn::Shape>& shapes,
                                                          std::size_t height, std::size_t width);

  [[nodiscard]] static std::vector<nn::Shape> shapes_of(const std::vector<ForeignOutput>& outputs);

  [[nodiscard]] std::vector<ForeignOutput> run(const std::vector<float>& picture) const;

  Engine engine_;
  DetectorDescription kind_;
  std::size_t height_, width_;
  std::vector<nn::Shape> shapes_;
  nn::Network<T> decoding_;
  ExportedHeads heads_;
  mutable std::mutex one_at_a_time_;
};

extern template class ForeignDetector<float>;
extern template class ForeignDetector<double>;

}  // namespace tapestry::detect
