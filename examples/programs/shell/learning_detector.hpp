#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/batch_norm_folding_variable.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/detect/network_variable.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/io/onnx/weight_replacement.hpp>
#include <utility>
#include <vector>

#include "trained_network.hpp"

namespace tapestry::shell {

/// A detector whose weights learn, and the file that it is written to.
class LearningDetector {
 public:
  virtual ~LearningDetector() = default;
  LearningDetector(const LearningDetector&) = delete;
  LearningDetector& operator=(const LearningDetector&) = delete;

  /// The same object at any time, of the parameters as they are.
  [[nodiscard]] virtual const detect::Detector<float>& detector() const = 0;
  /// Everything that learning changes, and perhaps constants that no gradient reaches.
  [[nodiscard]] virtual Array<float, 1> parameters() const = 0;
  virtual void set_parameters(const Array<float, 1>& parameters) = 0;
  /// Logits on the active tape; the parameters must be those of the detector.
  [[nodiscard]] virtual std::vector<ArrayVariable<float, 4>> forward(
      const ArrayVariable<float, 4>& images, const ArrayVariable<float, 1>& parameters) = 0;
  /// Notes how many pictures it has learnt from here.
  virtual void set_pictures_seen(std::uint64_t) {}

  /// The ending of its file's name.
  [[nodiscard]] virtual const char* extension() const = 0;
  virtual void save(const std::string& path) const = 0;

 protected:
  LearningDetector() = default;
  std::shared_ptr<detect::Pass<float>> pass_ = std::make_shared<detect::Pass<float>>();
};

/// Batch normalisation keeps its running statistics, see detect::fold_batch_norm() on the tape; its shifts
/// and scales learn.
class LearningNetwork final : public LearningDetector {
 public:
  /// \param cfg  text that it is written with
  LearningNetwork(detect::Network<float> start, std::string cfg)
      : network_(std::move(start)),
        folded_(detect::without_batch_norm(network_.config()), network_.input_height(),
                network_.input_width()),
        detector_(network_.make_detector()),
        cfg_(std::move(cfg)),
        seen_before_(network_.images_seen()) {}

  [[nodiscard]] const detect::Detector<float>& detector() const override { return detector_; }
  [[nodiscard]] Array<float, 1> parameters() const override { return network_.parameters(); }
  void set_parameters(const Array<float, 1>& parameters) override {
    network_.parameters() = parameters;
    detector_ = network_.make_detector();
  }
  [[nodiscard]] std::vector<ArrayVariable<float, 4>> forward(
      const ArrayVariable<float, 4>& images, const ArrayVariable<float, 1>& parameters) override {
    return detect::forward(folded_, images,
                           detect::fold_batch_norm(network_.config(), network_.layout(), parameters), pass_);
  }
  void set_pictures_seen(std::uint64_t count) override { network_.set_images_seen(seen_before_ + count); }
  [[nodiscard]] const char* extension() const override { return ".safetensors"; }
  void save(const std::string& path) const override { save_network(network_, cfg_, path); }

 private:
  detect::Network<float> network_;
  detect::Network<float> folded_;  ///< what learns: the same function without batch normalisation
  detect::Detector<float> detector_;
  std::string cfg_;
  std::uint64_t seen_before_;
};

/// An ONNX model, written as the file that it was read from with other numbers in its initialisers. As far as
/// it can, it runs simplified as others do; where that merges weights, which the file has apart, it runs as
/// the file says, which takes longer and differs in rounding from what others make of the file written. Batch
/// normalisation that the file has keeps its running statistics.
class LearningGraph final : public LearningDetector {
 public:
  /// \param start  read from this file
  /// \param size   as of detect::Detector
  /// \throws FileError (mismatch) if weights are not numbers that can be replaced in the file, or if the file
  ///         would then be another network
  LearningGraph(const std::string& path, const detect::Detector<float>& start, std::size_t size)
      : path_(path), bytes_(io::read_text_file(path)) {
    const auto description = io::parse_onnx(bytes_, path);
    const auto is_own = [&](const nn::WeightBlock& weight) {
      return description.constants.contains(weight.name);
    };
    const bool may_simplify = std::ranges::all_of(start.network().weights(), is_own);
    graph_ = std::make_unique<detect::Detector<float>>(description, start.description(), size,
                                                       std::vector<std::string>{}, may_simplify);
    for (const nn::WeightBlock& weight : graph_->network().weights())
      if (!is_own(weight) || extents(weight.shape) != extents(description.constants.at(weight.name).shape))
        throw FileError(ErrorKind::mismatch, {path, "", "weights " + in_quotes(weight.name) + " cannot learn",
                                              "an initialiser, its elements in the order of the file",
                                              is_own(weight) ? "another order" : "what nodes compute"});
    require_same_when_read(size, may_simplify);
  }

  [[nodiscard]] const detect::Detector<float>& detector() const override { return *graph_; }
  [[nodiscard]] Array<float, 1> parameters() const override {
    const auto& constants = std::as_const(*graph_).network().constants();
    Array<float, 1> parameters(Extents<1>{constants.size()});
    std::ranges::copy(constants, parameters.data());
    return parameters;
  }
  void set_parameters(const Array<float, 1>& parameters) override {
    graph_->network().set_constants({parameters.data(), parameters.data() + parameters.size()});
  }
  [[nodiscard]] std::vector<ArrayVariable<float, 4>> forward(
      const ArrayVariable<float, 4>& images, const ArrayVariable<float, 1>& parameters) override {
    return detect::forward(*graph_, images, parameters, pass_);
  }
  [[nodiscard]] const char* extension() const override { return ".onnx"; }
  void save(const std::string& path) const override {
    io::write_file_atomically(path, std::string_view(written()));
  }

 private:
  /// Tried with each weight moved by a share of its own: a number that the file has once may be two weights
  /// here, or a weight and a setting of an operator. Refuses before anything is learnt.
  void require_same_when_read(std::size_t size, bool may_simplify) {
    const auto start = parameters();
    auto moved = start;
    std::size_t moved_count = 0;
    for (const nn::WeightBlock& weight : std::as_const(*graph_).network().weights()) {
      const float share = 1 + static_cast<float>(1 + moved_count++ % 31) / 1024;
      for (std::size_t i = 0; i < nn::size_of(weight.shape); ++i) moved(weight.offset + i) *= share;
    }
    set_parameters(moved);
    const detect::Detector<float> read(io::parse_onnx(written(), path_), graph_->description(), size,
                                       std::vector<std::string>{}, may_simplify);
    Array<float, 4> picture(Extents<4>{1, graph_->input_height(), graph_->input_width(), 3});
    Random random(1);
    for (float& value : picture.storage()) value = static_cast<float>(random.uniform());
    detect::Pass<float> here, there;
    graph_->forward(picture, here);
    read.forward(picture, there);
    for (std::size_t head = 0; head < here.logits.size(); ++head)
      if (!std::ranges::equal(here.logits[head].storage(), there.logits[head].storage()))
        throw FileError(ErrorKind::mismatch,
                        {path_, "", "weights cannot learn: written back they make another network",
                         "initialisers that are one weight each", "one in several roles"});
    set_parameters(start);
  }

  /// Those above 1: the order of a tensor's elements follows from them.
  [[nodiscard]] static nn::Shape extents(nn::Shape shape) {
    std::erase(shape, 1);
    return shape;
  }

  [[nodiscard]] std::string written() const {
    io::WeightValues values;
    const auto& network = std::as_const(*graph_).network();
    for (const nn::WeightBlock& weight : network.weights()) {
      const auto first = network.constants().begin() + static_cast<std::ptrdiff_t>(weight.offset);
      values[weight.name].assign(first, first + static_cast<std::ptrdiff_t>(nn::size_of(weight.shape)));
    }
    return io::with_weights(bytes_, path_, values);
  }

  std::string path_, bytes_;
  std::unique_ptr<detect::Detector<float>> graph_;
};

}  // namespace tapestry::shell
