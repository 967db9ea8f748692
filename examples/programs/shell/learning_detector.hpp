#pragma once
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/io/atomic_file.hpp>
#include "trained_network.hpp"

namespace tapestry::shell {
/// A detector whose weights are trained, and the file it is written to. Batch normalisation keeps its running
/// statistics unless a LearningModel is made to follow those of batches; its shifts and scales are trained.
class LearningDetector {
 public:
  virtual ~LearningDetector() = default;
  LearningDetector(const LearningDetector&) = delete;
  LearningDetector& operator=(const LearningDetector&) = delete;

  /// The detector with the current weights; always the same object.
  [[nodiscard]] virtual const detect::Detector<float>& detector() const { return learning_; }
  [[nodiscard]] Array<float, 1> weights() const { return learning_.weights(); }
  virtual void set_weights(const Array<float, 1>& weights) { learning_.set_weights(weights); }
  /// Sets the weights after a step of forward(), and everything else that a step changes.
  virtual void take_step(const Array<float, 1>& weights) { set_weights(weights); }
  /// All that learning changes.
  [[nodiscard]] virtual Array<float, 1> state() const { return weights(); }
  virtual void restore(const Array<float, 1>& state) { set_weights(state); }
  /// Logits on the active tape; the weights must be the detector's.
  [[nodiscard]] std::vector<ArrayVariable<float, 4>> forward(const ArrayVariable<float, 4>& images,
                                                             const ArrayVariable<float, 1>& weights) {
    return detect::forward(learning_, images, weights, pass_);
  }
  virtual void set_pictures_seen(std::uint64_t) {}

  /// Writes an ONNX model.
  virtual void save(const std::string& path) const = 0;

 protected:
  explicit LearningDetector(detect::Detector<float> learning) : learning_(std::move(learning)) {}
  detect::Detector<float> learning_;
  std::shared_ptr<detect::Pass<float>> pass_ = std::make_shared<detect::Pass<float>>();
};

/// A Darknet model. It is trained as its cfg describes it, and attacked in simplified form.
class LearningModel final : public LearningDetector {
 public:
  /// \param cfg    text of the cfg to write
  /// \param names  of the classes
  /// \param fit    of photographs; left out, the cfg's
  /// \param batch_statistics  batch normalisation learns from the batches' statistics, as random weights need
  LearningModel(detect::DarknetModel<float> start, std::string cfg, std::vector<std::string> names,
                const std::optional<image::Fit>& fit = {}, bool batch_statistics = false)
      : LearningDetector(start.learning_detector(batch_statistics)),
        model_(std::move(start)),
        detector_(model_.detector()),
        cfg_(std::move(cfg)),
        seen_before_(model_.images_seen()),
        batch_statistics_(batch_statistics) {
    detector_.set_names(std::move(names));
    if (fit) detector_.set_fit(*fit);
  }

  [[nodiscard]] const detect::Detector<float>& detector() const override { return detector_; }
  void set_weights(const Array<float, 1>& weights) override {
    learning_.set_weights(weights);
    model_.take_weights(learning_);
    renew();
  }
  void take_step(const Array<float, 1>& weights) override {
    if (batch_statistics_) model_.update_running_statistics(*pass_, 0.03);
    set_weights(weights);
  }
  [[nodiscard]] Array<float, 1> state() const override { return model_.parameters(); }
  void restore(const Array<float, 1>& state) override {
    model_.parameters() = state;
    learning_ = model_.learning_detector(batch_statistics_);
    renew();
  }
  void set_pictures_seen(std::uint64_t count) override { model_.set_images_seen(seen_before_ + count); }
  void save(const std::string& path) const override { save_model(model_, cfg_, path); }

 private:
  void renew() {
    auto names = detector_.names();
    const auto fit = detector_.fit();
    detector_ = model_.detector();
    detector_.set_names(std::move(names));
    detector_.set_fit(fit);
  }

  detect::DarknetModel<float> model_;
  detect::Detector<float> detector_;
  std::string cfg_;
  std::uint64_t seen_before_;
  bool batch_statistics_;
};

/// An ONNX model, written as its original file with new numbers in its initialisers. If possible it runs
/// simplified, as other detectors do. If simplifying merges weights that are separate in the file, it runs
/// the file's own nodes, which takes longer and differs in rounding from the detector read from the written
/// file. Batch normalisation in the file keeps its running statistics.
class LearningGraph final : public LearningDetector {
 public:
  /// \param bytes  of the file
  /// \param start  read from it
  /// \param size   as of detect::Detector
  /// \throws FileError (mismatch) if weights cannot be replaced in the file, or if the file would then hold
  ///         another network
  LearningGraph(const std::string& path, const std::string& bytes, const detect::Detector<float>& start,
                std::size_t size)
      : LearningGraph(path, bytes, io::parse_onnx(bytes, path), start, size) {}

  void save(const std::string& path) const override {
    io::write_file_atomically(path, std::string_view(written()));
  }

 private:
  LearningGraph(const std::string& path, const std::string& bytes, const nn::NetworkDescription& network,
                const detect::Detector<float>& start, std::size_t size)
      : LearningDetector({network, start.description(), size, {}, may_simplify(network, start)}),
        path_(path),
        bytes_(bytes) {
    learning_.set_names(start.names());
    for (const nn::WeightBlock& weight : learning_.network().weight_blocks()) {
      const bool is_own = network.constants.contains(weight.name);
      if (!is_own || extents(weight.constant_shape) != extents(network.constants.at(weight.name).shape))
        throw file_mismatch({path_, "", "weights " + in_quotes(weight.name) + " cannot learn",
                             "a constant, its elements in the order of the file",
                             is_own ? "another order" : "what nodes compute"});
    }
    require_same_when_read(size, may_simplify(network, start));
  }

  /// Whether all weights of the simplified network are the file's.
  [[nodiscard]] static bool may_simplify(const nn::NetworkDescription& network,
                                         const detect::Detector<float>& simplified) {
    return std::ranges::all_of(simplified.network().weight_blocks(), [&](const nn::WeightBlock& weight) {
      return network.constants.contains(weight.name);
    });
  }

  /// Checks before training that the written file gives the same network, with each weight changed by a
  /// different factor: one number of the file may be two weights here, or a weight and a setting of an
  /// operator.
  void require_same_when_read(std::size_t size, bool simplifies) {
    const auto start = weights();
    auto moved = start;
    std::size_t moved_count = 0;
    for (const nn::WeightBlock& weight : learning_.network().weight_blocks()) {
      const float share = 1 + static_cast<float>(1 + moved_count++ % 31) / 1024;
      for (std::size_t i = 0; i < nn::size_of(weight.shape); ++i) moved(weight.offset + i) *= share;
    }
    set_weights(moved);
    const detect::Detector<float> read(io::parse_onnx(written(), path_), learning_.description(), size, {},
                                       simplifies);
    Array<float, 4> picture(Extents<4>{1, learning_.input_height(), learning_.input_width(), 3});
    Random random(1);
    for (float& value : picture.storage()) value = static_cast<float>(random.uniform());
    const auto here = detect::forward(learning_, picture), there = detect::forward(read, picture);
    for (std::size_t head = 0; head < here.size(); ++head)
      if (!std::ranges::equal(here[head].storage(), there[head].storage()))
        throw file_mismatch({path_, "", "weights cannot learn: written back they make another network",
                             "initialisers that are one weight each", "one in several roles"});
    set_weights(start);
  }

  /// The extents above 1: they determine the order of a tensor's elements.
  [[nodiscard]] static nn::Shape extents(nn::Shape shape) {
    std::erase(shape, 1);
    return shape;
  }

  [[nodiscard]] std::string written() const {
    return io::with_weights(bytes_, path_, io::weight_values(learning_.network()));
  }

  std::string path_, bytes_;
};
}  // namespace tapestry::shell
