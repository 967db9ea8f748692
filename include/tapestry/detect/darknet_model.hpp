#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/parameter_layout.hpp>

namespace tapestry::detect {
/// The constant that holds a block of parameters in network_description().
[[nodiscard]] std::string constant_name(const ParameterBlock& block);

/// Extents of that constant: [filters], or [filters, channels / groups, row, column] for weights.
[[nodiscard]] nn::Shape constant_shape(const NetworkConfig& config, const ParameterBlock& block);

/// The network of a cfg file and its parameters as operators on named values, [N, C, H, W] from the input
/// "picture" on. The result of layer i is "layer_i", its constants are "layer_i.weights", ".biases" and, with
/// batch normalisation, ".scales", ".means" and ".variances". The outputs are the raw logits of the heads in
/// their order, or the last layer's values in a network without heads.
///
/// Layers that only pass something on (dropout, heads, a route of one whole layer) have no node. Darknet's
/// own operators become:
///
///   convolutional    ε of batch normalisation is added inside the root, see NetworkConfig
///   swish            x · Sigmoid(x)
///   hard_mish        HardMish, an operator of ours: its derivative at 0 is 1
///   upsample         Resize to the nearest pixel, rounding down, then a product with `scale`
///   shortcut         a source of other extents is cut or filled up with zeros to those of the layer before;
///                    along an axis with f times the pixels every f-th counts
///   softmax          of values / temperature, of each of `groups` equal runs of an image's values
///   reorg            Reshape, Transpose, Reshape, in Darknet's order
///   scale_channels   a product with one factor for each channel, or for each pixel
///
/// \param parameters     in the order of ParameterLayout
/// \param input_height   of the pictures, in pixels; 0 takes the cfg's own. Some operators state extents, so
///                       that the description is for pictures of this size alone
/// \param input_width    likewise
/// \param batch_statistics  batch normalisation takes the statistics of the pass's batch. The outputs then
///                      have "layer_i.batch_means" and "layer_i.batch_variances", biased, of each such layer
///                      behind those of the heads
/// \param borrows  constants refer to `parameters`, which must outlive the description; for float alone
/// \throws FileError as infer_shapes(); ShapeError unless there are as many parameters as the cfg needs
template <std::floating_point T>
[[nodiscard]] nn::NetworkDescription network_description(const NetworkConfig& config,
                                                         const Array<T, 1>& parameters,
                                                         std::size_t input_height = 0,
                                                         std::size_t input_width = 0,
                                                         bool batch_statistics = false, bool borrows = false);

/// A YOLO network, version 2 to 4 and relatives, as Darknet's files hold it: a cfg and the parameters in
/// Darknet's order. It makes the detectors that run; see network_description(). A detector of a network
/// without heads, such as a classifier, has the last layer's output, [N, C, H, W], in the place of logits,
/// before or behind a softmax.
template <std::floating_point T>
class DarknetModel {
 public:
  /// Sets all parameters to 0, but scales and variances to 1.
  ///
  /// \param input_height  of the pictures, in pixels; 0 takes the cfg's own
  /// \param input_width   likewise
  /// \throws FileError (mismatch or limit) if the layers do not fit that size
  explicit DarknetModel(NetworkConfig config, std::size_t input_height = 0, std::size_t input_width = 0);

  /// Takes these parameters, in the order of layout(); errors as above.
  /// \throws ShapeError unless there are as many as the cfg needs
  DarknetModel(NetworkConfig config, Array<T, 1> parameters, std::size_t input_height = 0,
               std::size_t input_width = 0);

  [[nodiscard]] std::size_t input_height() const { return height_; }
  [[nodiscard]] std::size_t input_width() const { return width_; }
  [[nodiscard]] std::size_t input_channels() const { return config_.channels; }
  [[nodiscard]] const std::vector<Head>& heads() const { return heads_; }
  /// The measure of nms_kind and beta_nms of the last head, as in Darknet.
  [[nodiscard]] SuppressionMeasure suppression_measure() const;
  [[nodiscard]] const NetworkConfig& config() const { return config_; }
  /// Places of each layer's parameters.
  [[nodiscard]] const ParameterLayout& layout() const { return layout_; }

  /// All parameters in the order of layout(), running statistics included.
  [[nodiscard]] Array<T, 1>& parameters() { return parameters_; }
  [[nodiscard]] const Array<T, 1>& parameters() const { return parameters_; }

  /// Number of pictures it was trained on, which Darknet's files store.
  [[nodiscard]] std::uint64_t images_seen() const { return images_seen_; }
  void set_images_seen(std::uint64_t count) { images_seen_ = count; }

  /// Draws weights from a normal distribution of variance 2 / (inputs of a filter); biases are 0, batch
  /// normalisation the identity. Source: He et al., "Delving deep into rectifiers" (2015), eq. 10.
  void initialise(Random& random);

  /// The same model in another precision.
  template <std::floating_point U>
  [[nodiscard]] DarknetModel<U> cast() const {
    DarknetModel<U> other(config_, tapestry::cast<U>(parameters_), height_, width_);
    other.set_images_seen(images_seen_);
    return other;
  }

  /// The same model for pictures of another size; errors as the constructor.
  [[nodiscard]] DarknetModel resized(std::size_t input_height, std::size_t input_width) const;

  /// Name of the value that a layer of config() computes or passes on; a detector observes it by that name.
  /// \throws FileError (mismatch) for a layer that is not there, or hands on the picture itself
  [[nodiscard]] std::string value_name(std::size_t layer) const;

  /// network_description() of the present parameters.
  [[nodiscard]] nn::NetworkDescription description(bool batch_statistics = false) const;

  /// The detector of the present parameters.
  /// \param layers  names of observed layers, see value_name()
  [[nodiscard]] Detector<T> detector(const std::vector<std::string>& layers = {}) const;

  /// A detector whose weights are the parameters that learn, in the form of the cfg, for passes in
  /// Mode::training; see take_weights() and, with batch statistics, update_running_statistics().
  ///
  /// \param batch_statistics  batch normalisation takes the statistics of the pass's batch instead of the
  ///                          running ones
  [[nodiscard]] Detector<T> learning_detector(bool batch_statistics = true) const;

  /// Takes over the weights of a learning_detector(); running statistics stay.
  void take_weights(const Detector<T>& learnt);

  /// Moves running means and variances towards those of a training pass: running ← (1 − momentum)·running +
  /// momentum·batch, the variance unbiased.
  ///
  /// \param pass  of a learning_detector() with batch statistics, in Mode::training
  /// \throws DomainError for another pass
  void update_running_statistics(const Pass<T>& pass, double momentum = 0.1);

 private:
  DarknetModel(NetworkConfig config, std::optional<Array<T, 1>> parameters, std::size_t input_height,
               std::size_t input_width);

  void fill(const ParameterBlock& block, T value) {
    for (std::size_t i = 0; i < block.count; ++i) parameters_[block.offset + i] = value;
  }

  [[nodiscard]] Detector<T> make_detector(bool batch_statistics, const std::vector<std::string>& layers,
                                          bool simplifies) const;

  NetworkConfig config_;
  std::size_t height_ = 0, width_ = 0;
  std::vector<FeatureShape> shapes_{};
  ParameterLayout layout_{};
  std::vector<Head> heads_{};
  Array<T, 1> parameters_;
  std::uint64_t images_seen_ = 0;
};

extern template class DarknetModel<float>;
extern template class DarknetModel<double>;
}  // namespace tapestry::detect
