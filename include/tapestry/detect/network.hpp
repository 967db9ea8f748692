#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/detect/network/backward.hpp>
#include <tapestry/detect/network/forward.hpp>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/kept_forward.hpp>
#include <tapestry/detect/network/pass.hpp>
#include <tapestry/detect/network/prepared_weights.hpp>
#include <tapestry/detect/network/told_layers.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/image/pixel_window.hpp>
#include <tapestry/nn/window.hpp>
#include <utility>
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
  explicit Network(NetworkConfig config, std::size_t input_height = 0, std::size_t input_width = 0)
      : graph_(detail::make_graph(std::move(config), input_height, input_width)),
        parameters_(zeros<T, 1>({graph_.layout.count})) {
    for (const ParameterBlock& block : graph_.layout.blocks)
      if (block.role == ParameterRole::scale || block.role == ParameterRole::variance) fill(block, 1);
  }

  /// With these parameters, in the order of layout(); errors as above.
  /// \throws ShapeError unless there are as many as the cfg needs
  Network(NetworkConfig config, Array<T, 1> parameters, std::size_t input_height = 0,
          std::size_t input_width = 0)
      : graph_(detail::make_graph(std::move(config), input_height, input_width)),
        parameters_(std::move(parameters)) {
    if (parameters_.size() != graph_.layout.count)
      throw ShapeError("Network: parameters is [" + std::to_string(parameters_.size()) + "], expected [" +
                       std::to_string(graph_.layout.count) + "]");
  }

  [[nodiscard]] std::size_t input_height() const override { return graph_.height; }
  [[nodiscard]] std::size_t input_width() const override { return graph_.width; }
  [[nodiscard]] std::size_t input_channels() const override { return graph_.config.channels; }
  [[nodiscard]] const std::vector<Head>& heads() const override { return graph_.heads; }
  /// As nms_kind and beta_nms of the last head say, which is the one that Darknet asks.
  [[nodiscard]] SuppressionMeasure suppression_measure() const override {
    SuppressionMeasure measure;
    for (const LayerConfig& layer : graph_.config.layers)
      if (is_head(layer.kind)) measure.distance_exponent = layer.beta_nms;
    return measure;
  }
  [[nodiscard]] const NetworkConfig& config() const { return graph_.config; }
  /// Where each layer's parameters lie.
  [[nodiscard]] const ParameterLayout& layout() const { return graph_.layout; }

  /// Weights normal with variance 2 / (inputs of a filter), biases 0, batch normalisation the identity.
  /// Source: He et al., "Delving deep into rectifiers" (2015), eq. 10.
  void initialise(Random& random) {
    for (const ParameterBlock& block : graph_.layout.blocks) {
      fill(block, block.role == ParameterRole::scale || block.role == ParameterRole::variance ? T(1) : T(0));
      if (block.role != ParameterRole::weight) continue;
      const auto fan_in = static_cast<double>(block.count / graph_.config.layers[block.layer].filters);
      const double deviation = std::sqrt(2 / fan_in);
      for (std::size_t i = 0; i < block.count; ++i)
        parameters_[block.offset + i] = static_cast<T>(deviation * random.normal());
    }
    cache_.forget();
  }

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
                                          std::size_t layer, std::size_t image) const override {
    this->require_logits_adjoint("Network::layer_adjoint", pass,
                                 pass.within.empty() && pass.layers.size() == graph_.image() + 1,
                                 logits_adjoint);
    const auto weights = cache_.adjoint(graph_, parameters_, pass.mode != Mode::training);
    return detail::told_adjoint(detail::BackwardPass<T>(graph_, engine_, parameters_, *weights, pass), graph_,
                                pass, logits_adjoint, layer, image);
  }

  /// \throws DomainError also for a pass of forward_within()
  void pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image, const Array<T, 3>& layer_adjoint,
                       Array<T, 4>& images_adjoint) const override {
    const auto weights = cache_.adjoint(graph_, parameters_, pass.mode != Mode::training);
    detail::pull_back_told(detail::BackwardPass<T>(graph_, engine_, parameters_, *weights, pass), graph_,
                           pass, layer, image, layer_adjoint, images_adjoint);
  }

  [[nodiscard]] std::uint64_t images_seen() const { return images_seen_; }
  void set_images_seen(std::uint64_t count) { images_seen_ = count; }

  /// How convolutions are computed, in both directions; automatic unless set.
  void set_engine(nn::Engine engine) { engine_ = engine; }
  [[nodiscard]] nn::Engine engine() const { return engine_; }

  /// All parameters in the order of layout(), running statistics included. Once they have been handed out
  /// for writing, every pass first compares them with those it prepared.
  [[nodiscard]] Array<T, 1>& parameters() {
    cache_.watch();
    return parameters_;
  }
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
  [[nodiscard]] Network resized(std::size_t input_height, std::size_t input_width) const {
    Network other(graph_.config, input_height, input_width);
    other.parameters_ = parameters_;
    other.images_seen_ = images_seen_;
    other.engine_ = engine_;
    other.graph_.told = graph_.told;
    return other;
  }

  /// The engines compute channels last, as pictures lie, so nothing is turned on the way in or back.
  void forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode = Mode::inference) const override {
    this->require_images(images);
    const auto weights = cache_.forward(graph_, parameters_, mode != Mode::training);
    begin(pass, images.shape(0), mode);
    pass.within.clear();
    detail::ForwardPass<T>(graph_, engine_, parameters_, *weights, pass)
        .run(images.data(), logits_of(pass, 0));
  }

  /// The layers' windows are their receptive fields, and where convolutions round by tiles all on which a bit
  /// depends. In Mode::training everything is computed.
  void forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
                      Mode mode = Mode::inference) const override {
    this->require_images(images);
    if (kept.size() != images.shape(0))
      throw ShapeError("Network::forward_within: " + std::to_string(kept.size()) + " kept pictures for " +
                       std::to_string(images.shape(0)) + " images");
    for (const KeptPicture<T>* picture : kept)
      if (picture != nullptr)
        image::require_window("Network::forward_within", picture->window(), graph_.height, graph_.width);
    if (mode == Mode::training) return forward(images, pass, mode);
    const auto weights = cache_.forward(graph_, parameters_, true);
    begin(pass, images.shape(0), mode);
    pass.layers.clear();
    pass.within.resize(kept.size());
    for (std::size_t i = 0; i < kept.size(); ++i) {
      Pass<T>& own = pass.within[i];
      own.mode = mode;
      own.images = 1;
      const T* const image = images.data() + i * graph_.shapes.back().size();
      if (kept[i] != nullptr) {
        detail::forward_kept<T>(graph_, engine_, parameters_, cache_, weights, image,
                                detail::window_of(kept[i]->window()), kept[i]->values(), own,
                                logits_of(pass, i));
      } else {
        own.plan = nullptr;
        own.window.reset();
        detail::ForwardPass<T>(graph_, engine_, parameters_, *weights, own).run(image, logits_of(pass, i));
      }
    }
  }

  [[nodiscard]] double share_kept(const image::PixelWindow& window) const override {
    image::require_window("Network::share_kept", window, graph_.height, graph_.width);
    return detail::share_left_out(graph_, detail::plan_of(graph_, engine_, parameters_, cache_,
                                                          Mode::input_gradient, detail::window_of(window)));
  }

  /// Adds (∂logits/∂parameters)ᵀ · logits_adjoint to parameters_adjoint, in the order of layout(); nothing
  /// is added for running statistics.
  /// \param pass  of forward() in Mode::training
  void parameter_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                         Array<T, 1>& parameters_adjoint) const {
    std::vector<const Array<T, 4>*> pointers;
    for (const auto& array : logits_adjoint) pointers.push_back(&array);
    adjoints("Network::parameter_adjoint", pass, pointers, nullptr, &parameters_adjoint);
  }

  void pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                 Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint = nullptr) const override {
    adjoints("Network::pull_back", pass, logits_adjoint, images_adjoint, parameters_adjoint);
  }

  /// Moves running means and variances a part of the way to those of a training pass:
  /// running ← (1 − momentum)·running + momentum·batch, the variance unbiased.
  void update_running_statistics(const Pass<T>& pass, double momentum = 0.1) {
    if (pass.mode != Mode::training)
      throw DomainError("Network::update_running_statistics: not a training pass");
    for (std::size_t i = 0; i < graph_.config.layers.size(); ++i) {
      if (!graph_.config.layers[i].batch_normalize) continue;
      const auto& statistics = pass.layers[i].statistics;
      const auto count = static_cast<double>(pass.images * graph_.shapes[i].height * graph_.shapes[i].width);
      const double unbias = count > 1 ? count / (count - 1) : 1;
      const auto move = [&](T& running, double batch) {
        running = static_cast<T>((1 - momentum) * static_cast<double>(running) + momentum * batch);
      };
      for (std::size_t c = 0; c < statistics.mean.size(); ++c) {
        move(parameters_[graph_.layout.layers[i].mean + c], statistics.mean[c]);
        move(parameters_[graph_.layout.layers[i].variance + c], statistics.variance[c] * unbias);
      }
    }
    cache_.forget();
  }

 private:
  template <std::floating_point U>
  friend class Network;

  void begin(Pass<T>& pass, std::size_t images, Mode mode) const {
    pass.mode = mode;
    pass.images = images;
    pass.logits.resize(graph_.head_values.size());
    for (std::size_t h = 0; h < pass.logits.size(); ++h) {
      const FeatureShape& shape = graph_.shapes[graph_.head_values[h]];
      pass.logits[h].resize({images, shape.channels, shape.height, shape.width});
    }
  }

  /// Where the logits of an image lie in those of all.
  [[nodiscard]] static std::vector<T*> logits_of(Pass<T>& pass, std::size_t image) {
    std::vector<T*> pointers;
    for (auto& logits : pass.logits)
      pointers.push_back(logits.data() + image * (logits.size() / pass.images));
    return pointers;
  }

  void fill(const ParameterBlock& block, T value) {
    for (std::size_t i = 0; i < block.count; ++i) parameters_[block.offset + i] = value;
  }

  void adjoints(const char* operation, Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint) const {
    const bool kept_something = pass.layers.size() == graph_.image() + 1 || !pass.within.empty();
    this->require_logits_adjoint(operation, pass, kept_something, logits_adjoint);
    if (images_adjoint != nullptr) {
      require_shape(operation, "images_adjoint", *images_adjoint,
                    {pass.images, graph_.height, graph_.width, graph_.config.channels});
    }
    if (parameters_adjoint != nullptr)
      detail::require_parameters_adjoint(operation, pass, parameters_adjoint->size(), parameters_.size());
    const auto weights = cache_.adjoint(graph_, parameters_, pass.mode != Mode::training);
    const auto run = [&](Pass<T>& own, std::size_t image) {
      std::vector<const T*> heads;
      for (const Array<T, 4>* head : logits_adjoint)
        heads.push_back(head == nullptr ? nullptr : head->data() + image * (head->size() / pass.images));
      detail::BackwardPass<T>(graph_, engine_, parameters_, *weights, own)
          .run(heads,
               images_adjoint == nullptr ? nullptr
                                         : images_adjoint->data() + image * graph_.shapes.back().size(),
               parameters_adjoint == nullptr ? nullptr : parameters_adjoint->data());
    };
    if (pass.within.empty()) return run(pass, 0);
    for (std::size_t i = 0; i < pass.within.size(); ++i) run(pass.within[i], i);
  }

  detail::Graph graph_;
  nn::Engine engine_ = nn::Engine::automatic;
  Array<T, 1> parameters_;
  std::uint64_t images_seen_ = 0;
  mutable detail::WeightCache<T> cache_;
};

}  // namespace tapestry::detect
