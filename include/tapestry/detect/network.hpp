#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/pass.hpp>
#include <tapestry/detect/network/prepared_weights.hpp>
#include <tapestry/detect/network/told_layers.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/image/pixel_window.hpp>
#include <vector>

namespace tapestry::detect {

/// A YOLO detector, version 2 to 4 and relatives, as Darknet describes it: forward, and backward to its input
/// or to its parameters. Batch normalisation adds config().batch_norm_epsilon inside the root; dropout passes
/// everything on in every mode. A network without heads, such as a classifier, hands out its last layer's
/// output, [N, C, H, W], in their place: the only entry of Pass::logits, be it logits or behind a softmax.
/// Results are the same bits for any number of threads.
template <std::floating_point T>
class Network final : public Detector<T> {
 public:
  /// \param input_height  of the pictures, in pixels; 0 takes the cfg's own
  /// \param input_width   likewise
  /// \throws FileError (mismatch or limit) if the layers do not fit that size
  explicit Network(NetworkConfig config, std::size_t input_height = 0, std::size_t input_width = 0);

  /// With these parameters, in the order of layout(); errors as above.
  /// \throws ShapeError unless there are as many as the cfg needs
  Network(NetworkConfig config, Array<T, 1> parameters, std::size_t input_height = 0,
          std::size_t input_width = 0);
  Network(const Network&);
  Network(Network&&) noexcept;
  Network& operator=(const Network&);
  Network& operator=(Network&&) noexcept;
  ~Network() override;

  [[nodiscard]] std::size_t input_height() const override { return graph_.height; }
  [[nodiscard]] std::size_t input_width() const override { return graph_.width; }
  [[nodiscard]] std::size_t input_channels() const override { return graph_.config.channels; }
  [[nodiscard]] const std::vector<Head>& heads() const override { return graph_.heads; }
  /// As nms_kind and beta_nms of the last head say, which is the one that Darknet asks.
  [[nodiscard]] SuppressionMeasure suppression_measure() const override;
  [[nodiscard]] const NetworkConfig& config() const { return graph_.config; }
  /// Where each layer's parameters lie.
  [[nodiscard]] const ParameterLayout& layout() const { return graph_.layout; }

  /// Weights normal with variance 2 / (inputs of a filter), biases 0, batch normalisation the identity.
  /// Source: He et al., "Delving deep into rectifiers" (2015), eq. 10.
  void initialise(Random& random);

  /// Names layers, by their places among config().layers, whose values and adjoints passes tell from now on,
  /// which takes the memory of these values. What a pass computes stays the same.
  /// \throws FileError (mismatch) for a layer that is not there, or hands on the picture itself
  void tell_layers(const std::vector<std::size_t>& layers) { detail::tell_layers(graph_, layers); }
  /// The last layer of which all heads are computed; nothing if there is none.
  [[nodiscard]] std::optional<std::size_t> common_layer() const { return detail::common_value(graph_); }

  [[nodiscard]] Array<T, 3> layer_values(const Pass<T>& pass, std::size_t layer,
                                         std::size_t image) const override {
    return detail::told_values(graph_, pass, layer, image);
  }
  /// \throws DomainError also for a pass of forward_within()
  [[nodiscard]] Array<T, 3> layer_adjoint(Pass<T>& pass,
                                          const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          std::size_t layer, std::size_t image) const override;

  /// \throws DomainError also for a pass of forward_within()
  void pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image, const Array<T, 3>& layer_adjoint,
                       Array<T, 4>& images_adjoint) const override;

  [[nodiscard]] std::uint64_t images_seen() const { return images_seen_; }
  void set_images_seen(std::uint64_t count) { images_seen_ = count; }

  /// How convolutions are computed, in both directions; automatic unless set.
  void set_engine(nn::Engine engine) { engine_ = engine; }
  [[nodiscard]] nn::Engine engine() const { return engine_; }

  /// All parameters in the order of layout(), running statistics included. Once they have been handed out
  /// for writing, every pass first compares them with those it prepared.
  [[nodiscard]] Array<T, 1>& parameters();
  [[nodiscard]] const Array<T, 1>& parameters() const { return parameters_; }

  /// The same network in another precision.
  template <std::floating_point U>
  [[nodiscard]] Network<U> cast() const {
    Network<U> other(graph_.config, graph_.height, graph_.width);
    for (std::size_t i = 0; i < parameters_.size(); ++i)
      other.parameters_[i] = static_cast<U>(parameters_[i]);
    other.images_seen_ = images_seen_;
    other.engine_ = engine_;
    other.graph_.told = graph_.told;
    return other;
  }

  /// The same network for pictures of another size; errors as the constructor.
  [[nodiscard]] Network resized(std::size_t input_height, std::size_t input_width) const;

  /// The engines compute channels last, as pictures lie, so nothing is turned on the way in or back.
  void forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode = Mode::inference) const override;

  /// The layers' windows are their receptive fields, and where convolutions round by tiles all on which a bit
  /// depends. In Mode::training everything is computed.
  void forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
                      Mode mode = Mode::inference) const override;

  [[nodiscard]] double share_kept(const image::PixelWindow& window) const override;

  /// Adds (∂logits/∂parameters)ᵀ · logits_adjoint to parameters_adjoint, in the order of layout(); nothing
  /// is added for running statistics.
  /// \param pass  of forward() in Mode::training
  void parameter_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                         Array<T, 1>& parameters_adjoint) const;

  void pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                 Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint = nullptr) const override {
    adjoints("Network::pull_back", pass, logits_adjoint, images_adjoint, parameters_adjoint);
  }

  /// Moves running means and variances a part of the way to those of a training pass:
  /// running ← (1 − momentum)·running + momentum·batch, the variance unbiased.
  void update_running_statistics(const Pass<T>& pass, double momentum = 0.1);

 private:
  template <std::floating_point U>
  friend class Network;

  void begin(Pass<T>& pass, std::size_t images, Mode mode) const;

  /// Where the logits of an image lie in those of all.
  [[nodiscard]] static std::vector<T*> logits_of(Pass<T>& pass, std::size_t image);

  void fill(const ParameterBlock& block, T value) {
    for (std::size_t i = 0; i < block.count; ++i) parameters_[block.offset + i] = value;
  }

  void adjoints(const char* operation, Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint) const;

  detail::Graph graph_;
  nn::Engine engine_ = nn::Engine::automatic;
  Array<T, 1> parameters_;
  std::uint64_t images_seen_ = 0;
  mutable detail::WeightCache<T> cache_;
};

extern template class Network<float>;
extern template class Network<double>;

}  // namespace tapestry::detect
