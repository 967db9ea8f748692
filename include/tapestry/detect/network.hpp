#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/detect/pass.hpp>
#include <tapestry/image/pixel_window.hpp>
#include <vector>

namespace tapestry::detect {
namespace detail {

/// The graphs that a network has made for its parameters, one for running statistics and one for those of a
/// batch. Copies of a network make their own. May be called from several threads.
template <std::floating_point T>
class GraphCache {
 public:
  GraphCache() = default;
  GraphCache(const GraphCache&) {}
  GraphCache& operator=(const GraphCache&) {
    const std::lock_guard<std::mutex> lock(mutex_);
    clear();
    training_.reset();
    return *this;
  }

  /// From now on the owner may change the parameters unseen, so compare them before each use.
  void watch() { is_watched_ = true; }

  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    clear();
  }

  /// \param make    makes the graph of the parameters
  /// \param update  gives a graph of older parameters these
  template <class Make, class Update>
  [[nodiscard]] std::shared_ptr<const Detector<T>> get(bool is_training, const Array<T, 1>& parameters,
                                                       Make make, Update update) {
    const std::lock_guard<std::mutex> lock(mutex_);
    compare(parameters);
    if (!is_training) {
      if (!running_) running_ = make();
      return running_;
    }
    if (!training_) {
      training_ = make();
    } else if (is_stale_) {
      update(*training_);
    }
    is_stale_ = false;
    return training_;
  }

 private:
  void clear() {
    running_.reset();
    is_stale_ = true;
  }
  void compare(const Array<T, 1>& parameters);

  std::mutex mutex_;
  bool is_watched_ = false;
  bool is_stale_ = false;  ///< training_ has other parameters
  Array<T, 1> made_from_;
  std::shared_ptr<Detector<T>> running_, training_;
};

}  // namespace detail

/// A YOLO detector, version 2 to 4 and relatives, as Darknet describes it: a cfg, its parameters in Darknet's
/// order, and the graph that network_description() makes of them, which passes run over: forward, and
/// backward to its input or to its parameters. Batch normalisation adds config().batch_norm_epsilon inside
/// the root; dropout passes everything on in every mode. A network without heads, such as a classifier, hands
/// out its last layer's output, [N, C, H, W], in their place: the only entry of Pass::logits, be it logits or
/// behind a softmax. Results are the same bits for any number of threads.
template <std::floating_point T>
class Network {
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
  ~Network();

  [[nodiscard]] std::size_t input_height() const { return height_; }
  [[nodiscard]] std::size_t input_width() const { return width_; }
  [[nodiscard]] std::size_t input_channels() const { return config_.channels; }
  [[nodiscard]] const std::vector<Head>& heads() const { return heads_; }
  /// As nms_kind and beta_nms of the last head say, which is the one that Darknet asks.
  [[nodiscard]] SuppressionMeasure suppression_measure() const;
  [[nodiscard]] const NetworkConfig& config() const { return config_; }
  /// Where each layer's parameters lie.
  [[nodiscard]] const ParameterLayout& layout() const { return layout_; }

  /// Weights normal with variance 2 / (inputs of a filter), biases 0, batch normalisation the identity.
  /// Source: He et al., "Delving deep into rectifiers" (2015), eq. 10.
  void initialise(Random& random);

  /// Names layers, by their places among config().layers, whose values and adjoints passes tell from now on,
  /// which takes the memory of these values. What a pass computes stays the same.
  /// \throws FileError (mismatch) for a layer that is not there, or hands on the picture itself
  void tell_layers(const std::vector<std::size_t>& layers);
  /// The last layer of which all heads are computed; nothing if there is none.
  [[nodiscard]] std::optional<std::size_t> common_layer() const;

  [[nodiscard]] Array<T, 3> layer_values(const Pass<T>& pass, std::size_t layer, std::size_t image) const;
  /// \throws DomainError also for a pass of forward_within()
  [[nodiscard]] Array<T, 3> layer_adjoint(Pass<T>& pass,
                                          const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          std::size_t layer, std::size_t image) const;

  /// \throws DomainError also for a pass of forward_within()
  void pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image, const Array<T, 3>& layer_adjoint,
                       Array<T, 4>& images_adjoint) const;

  [[nodiscard]] std::uint64_t images_seen() const { return images_seen_; }
  void set_images_seen(std::uint64_t count) { images_seen_ = count; }

  /// How convolutions are computed, in both directions; automatic unless set.
  void set_engine(nn::Engine engine);
  [[nodiscard]] nn::Engine engine() const { return engine_; }

  /// All parameters in the order of layout(), running statistics included. Once they have been handed out
  /// for writing, every pass first compares them with those it prepared.
  [[nodiscard]] Array<T, 1>& parameters();
  [[nodiscard]] const Array<T, 1>& parameters() const { return parameters_; }

  /// The same network in another precision.
  template <std::floating_point U>
  [[nodiscard]] Network<U> cast() const {
    Network<U> other(config_, tapestry::cast<U>(parameters_), height_, width_);
    other.images_seen_ = images_seen_;
    other.engine_ = engine_;
    other.layers_ = layers_;
    return other;
  }

  /// The same network for pictures of another size; errors as the constructor.
  [[nodiscard]] Network resized(std::size_t input_height, std::size_t input_width) const;

  /// The detector of the parameters as they are, for passes of a mode: with their statistics and simplified
  /// or, for training, as the cfg has it and with the statistics of the batch.
  [[nodiscard]] std::shared_ptr<const Detector<T>> detector(Mode mode = Mode::inference) const;
  /// A detector of its own.
  [[nodiscard]] Detector<T> make_detector() const { return std::move(*make_graph(false)); }

  // Shorthands for those of detector():
  void forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode = Mode::inference) const;

  /// The layers' windows are their receptive fields, and where convolutions round by tiles all on which a bit
  /// depends. In Mode::training everything is computed.
  void forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
                      Mode mode = Mode::inference) const;

  [[nodiscard]] double share_kept(const image::PixelWindow& window) const;

  /// Adds (∂logits/∂parameters)ᵀ · logits_adjoint to parameters_adjoint, in the order of layout(); nothing
  /// is added for running statistics.
  /// \param pass  of forward() in Mode::training
  void parameter_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                         Array<T, 1>& parameters_adjoint) const;

  void pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                 Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint = nullptr) const;
  void input_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                     Array<T, 4>& images_adjoint) const;

  /// Moves running means and variances a part of the way to those of a training pass:
  /// running ← (1 − momentum)·running + momentum·batch, the variance unbiased.
  void update_running_statistics(const Pass<T>& pass, double momentum = 0.1);

 private:
  template <std::floating_point U>
  friend class Network;

  void fill(const ParameterBlock& block, T value) {
    for (std::size_t i = 0; i < block.count; ++i) parameters_[block.offset + i] = value;
  }

  [[nodiscard]] std::unique_ptr<Detector<T>> make_graph(bool is_training) const;

  /// The graph that ran a pass. \throws DomainError if none of this library's networks did
  [[nodiscard]] static const Detector<T>& graph_of(const char* operation, const Pass<T>& pass);

  /// Calls body(offset among the graph's constants, block) for each block of parameters that learn.
  template <class Body>
  void for_each_weight(const Detector<T>& graph, Body body) const;

  NetworkConfig config_;
  std::size_t height_ = 0, width_ = 0;
  std::vector<FeatureShape> shapes_{};
  ParameterLayout layout_{};
  std::vector<Head> heads_{};
  std::vector<std::size_t> layers_{};  ///< that passes tell
  nn::Engine engine_ = nn::Engine::automatic;
  Array<T, 1> parameters_;
  std::uint64_t images_seen_ = 0;
  mutable detail::GraphCache<T> graphs_;
};

extern template class Network<float>;
extern template class Network<double>;

}  // namespace tapestry::detect
