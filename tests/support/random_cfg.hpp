#pragma once
#include <tapestry/io/darknet/model_file.hpp>

namespace tapestry::test {
/// A small random network in Darknet's vocabulary: every kind of layer and activation, with heads or without.
///
/// One draw a statement, so that every compiler makes the same network of a seed. Sections are drawn almost
/// freely; cfg files that the reader refuses are drawn again.
class RandomCfg {
 public:
  explicit RandomCfg(std::uint64_t seed) {
    for (std::uint64_t attempt = 0; config_.layers.empty(); ++attempt) {
      random_ = Random(seed).fork(attempt);
      build();
    }
  }

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] const detect::NetworkConfig& config() const { return config_; }

 private:
  static constexpr std::size_t most_products = 1U << 21U;  ///< multiply-adds of a layer
  static constexpr std::size_t most_values = 1U << 15U;    ///< of a layer's output

  void build() {
    constexpr std::size_t extents[] = {5, 8, 12, 16, 17, 24, 32, 33, 40};
    text_ = "[net]\n";
    option("height", pick(extents), text_);
    option("width", pick(extents), text_);
    option("channels", 3, text_);
    config_ = io::detail::parse_cfg(text_, "random.cfg");
    shapes_.clear();
    const std::size_t layer_count = 2 + random_.index(11);
    for (int trial = 0; trial < 400 && config_.layers.size() < layer_count; ++trial) try_sections(drawn());
    const bool wants_heads = random_.chance(0.7);
    for (int trial = 0; wants_heads && trial < 10; ++trial)
      if (try_sections(head())) break;
    try {
      config_ = has_head() ? io::parse_network_config(text_, "random.cfg")
                           : io::parse_classifier_config(text_, "random.cfg");
    } catch (const FileError&) {  // two heads of one grid, or cells that the picture does not divide into
      config_.layers.clear();
    }
  }

  /// Keeps the sections if all before and they make a network that is not too large.
  bool try_sections(const std::string& sections) {
    try {
      auto config = io::detail::parse_cfg(text_ + sections, "random.cfg");
      auto shapes = detect::infer_shapes(config, config.height, config.width);
      for (std::size_t i = config_.layers.size(); i < config.layers.size(); ++i) {
        const auto& layer = config.layers[i];
        const std::size_t channels = i > 0 ? shapes[i - 1].channels : 3;
        const std::size_t products = layer.size * layer.size * channels / layer.groups * shapes[i].size();
        if (shapes[i].size() > most_values) return false;
        if (layer.kind == detect::LayerKind::convolutional && products > most_products) return false;
      }
      config_ = std::move(config);
      shapes_ = std::move(shapes);
      text_ += sections;
      return true;
    } catch (const FileError&) {
      return false;
    }
  }

  [[nodiscard]] bool has_head() const {
    return std::ranges::any_of(config_.layers, [](const auto& layer) { return is_head(layer.kind); });
  }

  [[nodiscard]] std::string drawn() {
    switch (random_.index(18)) {
      case 0:
        return maxpool();
      case 1:
        return upsample();
      case 2:
        return random_.chance(0.3) ? "[avgpool]\n" : convolution();
      case 3:
        return "[dropout]\nprobability=.5\n";
      case 4:
        return random_.chance(0.5) ? "[reorg]\nstride=2\n" : "[reorg3d]\nstride=2\n";
      case 5:
        return softmax();
      case 6:
      case 7:
        return route();
      case 8:
      case 9:
      case 10:
        return combination("shortcut", random_.chance(0.7) ? 1 : 2 + random_.index(2));
      case 11:
        return scaling();
      case 12:
        return combination("sam", 1);
      case 13:
        return random_.chance(0.3) ? head() : convolution();
      default:
        return convolution();
    }
  }

  [[nodiscard]] std::string convolution() {
    constexpr std::size_t filters[] = {1, 3, 4, 5, 7, 8, 12, 16, 16, 24, 32, 32, 33, 48};
    constexpr std::size_t sizes[] = {1, 1, 3, 3, 3, 3, 3, 5, 5, 7};
    constexpr std::size_t groups[] = {2, 3, 4, 8, 16, 32};
    std::string text = "[convolutional]\n";
    if (random_.chance(0.15) && !shapes_.empty()) {
      option("filters", shapes_.back().channels, text);  // depthwise
      option("groups", shapes_.back().channels, text);
    } else {
      option("filters", pick(filters), text);
      if (random_.chance(0.15)) option("groups", pick(groups), text);
    }
    option("size", pick(sizes), text);
    if (random_.chance(0.2)) option("stride", 2 + random_.index(2), text);
    if (random_.chance(0.1)) option("dilation", 2 + random_.index(2), text);
    if (random_.chance(0.85))
      option("pad", 1, text);
    else
      option("padding", random_.index(4), text);
    if (random_.chance(0.4)) option("batch_normalize", 1, text);
    return text + activation(0.1);
  }

  [[nodiscard]] std::string maxpool() {
    std::string text = "[maxpool]\n";
    option("size", 1 + random_.index(5), text);
    option("stride", 1 + random_.index(3), text);
    if (random_.chance(0.3)) option("padding", random_.index(4), text);
    return text;
  }

  [[nodiscard]] std::string upsample() {
    std::string text = "[upsample]\n";
    option("stride", 2 + random_.index(2), text);
    if (random_.chance(0.3)) option("scale", random_.uniform(-2, 2), text);
    return text;
  }

  [[nodiscard]] std::string softmax() {
    std::string text = "[softmax]\n";
    option("groups", 1 + random_.index(3), text);
    option("temperature", random_.uniform(0.5, 3), text);
    return text;
  }

  [[nodiscard]] std::string route() {
    std::string text = "[route]\nlayers=" + sources(1 + random_.index(3));
    if (random_.chance(0.3)) {
      text += "groups=2\n";
      option("group_id", random_.index(2), text);
    }
    return text;
  }

  /// Layers before and an activation, more often linear.
  [[nodiscard]] std::string combination(const std::string& name, std::size_t count) {
    const std::string text = "[" + name + "]\nfrom=" + sources(count);
    return text + activation(0.5);
  }

  /// Multiplies the previous layer by factors computed from it.
  [[nodiscard]] std::string scaling() {
    if (shapes_.empty()) return convolution();
    const bool is_of_pixels = random_.chance(0.4);
    std::string text = is_of_pixels ? "[convolutional]\n" : "[avgpool]\n[convolutional]\n";
    option("filters", is_of_pixels ? 1 : shapes_.back().channels, text);
    text += is_of_pixels && random_.chance(0.5) ? "size=3\npad=1\n" : "size=1\n";
    text += activation(0);
    text += "[scale_channels]\n";
    option("from", shapes_.size() - 1, text);
    if (is_of_pixels) text += "scale_wh=1\n";
    return text + activation(0.5);
  }

  /// A head and the convolution before it.
  [[nodiscard]] std::string head() {
    const std::size_t classes = 1 + random_.index(3), anchors = 1 + random_.index(2);
    std::string text = "[convolutional]\n";
    option("filters", anchors * (5 + classes), text);
    text += random_.chance(0.5) ? "size=3\npad=1\n" : "size=1\n";
    text += activation(0.7);
    text += random_.chance(0.3) ? "[region]\n" : anchors == 1 ? "[yolo]\nmask=0\n" : "[yolo]\nmask=0,1\n";
    option("classes", classes, text);
    option("num", anchors, text);
    return text + (anchors == 1 ? "anchors=4,5\n" : "anchors=4,5, 9,8\n");
  }

  /// Linear with a probability, else any.
  [[nodiscard]] std::string activation(double linear) {
    const auto chosen = random_.chance(linear) ? nn::Activation::linear : pick(nn::activations);
    return "activation=" + std::string(nn::name_of(chosen)) + "\n";
  }

  /// Layers before this one, close ones are likelier.
  [[nodiscard]] std::string sources(std::size_t count) {
    std::string text;
    for (std::size_t i = 0; i < count && !shapes_.empty(); ++i) {
      const std::size_t reach =
          random_.chance(0.5) ? std::min<std::size_t>(4, shapes_.size()) : shapes_.size();
      const std::size_t back = 1 + random_.index(reach);
      text += i > 0 ? "," : "";
      text += random_.chance(0.5) ? "-" + std::to_string(back) : std::to_string(shapes_.size() - back);
    }
    return text + "\n";
  }

  template <class Choice, std::size_t Count>
  [[nodiscard]] Choice pick(const Choice (&choices)[Count]) {
    return choices[random_.index(Count)];
  }
  [[nodiscard]] nn::Activation pick(const decltype(nn::activations)& choices) {
    return choices[random_.index(choices.size())];
  }

  template <class Number>
  static void option(const std::string& key, Number value, std::string& text) {
    text += key + "=" + std::to_string(value) + "\n";
  }

  Random random_{0};
  std::string text_{};
  detect::NetworkConfig config_{};
  std::vector<detect::FeatureShape> shapes_{};  ///< of the layers so far
};

/// The first of a seed's networks that another library knows.
template <class IsKnown>
RandomCfg random_cfg_where(IsKnown is_known, std::uint64_t seed) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    RandomCfg cfg(Random(seed).fork(attempt).bits());
    if (is_known(cfg.config())) return cfg;
  }
}
}  // namespace tapestry::test
