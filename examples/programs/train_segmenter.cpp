// Trains a small network of the U²-Net family to find the car in procedural street scenes, drawn as they are
// needed.
#include <tapestry/image/batch.hpp>
#include <tapestry/loss/cross_entropy.hpp>
#include <tapestry/nn/network_variable.hpp>
#include <tapestry/optim/adam.hpp>
#include <tapestry/segment/u2_net.hpp>
#include <tapestry/segment/u2_net_description.hpp>

#include "../scenes/segmented_scene.hpp"
#include "shell/program.hpp"
#include "shell/scene_training.hpp"
#include "shell/trained_network.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;
using namespace tapestry::scenes;

struct Options {
  std::string weights;
  std::string output = "segmenter.onnx";
  std::size_t side = 128;
  SceneTraining training{4000, 4, 100, 1000};
};

void describe(CLI::App& app, Options& o) {
  app.add_option(
      "--weights", o.weights,
      "ONNX model to start from, one that this program wrote and whose size is kept; random weights when "
      "left out. Steps and learning rate begin anew");
  app.add_option("--output", o.output, "ONNX model to write");
  app.add_option("--side", o.side,
                 "side of the network's square input, pixels, without --weights; a multiple of 16");
  add_options(app, o.training, "IoU");
}

using HeldOutScenes = std::vector<HeldOut<SegmentedScene>>;

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         std::max(1.0, static_cast<double>(values.size()));
}

/// Prints the overlap of the mask with the silhouette: for its largest piece, and for the piece in the car's
/// box.
void print_validation(const nn::NetworkDescription& description, const HeldOutScenes& sets) {
  const segment::U2Net network(description);
  for (const auto& set : sets) {
    std::vector<double> largest(set.scenes.size()), labelled(set.scenes.size());
    parallel_for(set.scenes.size(), [&](std::size_t i) {
      const SegmentedScene& scene = set.scenes[i];
      const auto mask = network(image::from_bytes<float>(scene.colours));
      const auto silhouette = silhouette_of(scene);
      largest[i] = segment::mask_iou(segment::car_component(mask), silhouette);
      labelled[i] = segment::mask_iou(segment::car_component(mask, scene.box), silhouette);
    });
    std::vector<double> sorted = labelled;
    std::sort(sorted.begin(), sorted.end());
    std::printf("  %-12s mean IoU %.3f in the label's box, %.3f of the largest piece; median %.3f, of %zu\n",
                set.name.c_str(), mean(labelled), mean(largest),
                sorted.empty() ? 0.0 : sorted[sorted.size() / 2], sorted.size());
  }
  std::fflush(stdout);
}

/// The network and the memory for a step. The loss is the source's: the mean cross entropy of each
/// output, summed over all outputs.
class Trainer {
 public:
  Trainer(nn::NetworkDescription description, const SceneTraining& options)
      : description_(std::move(description)),
        network_(nn::pruned(description_, segment::u2_net_logits(description_)), {}, true),
        options_(options),
        weights_(array_of(std::vector<float>(network_.weights().begin(), network_.weights().end()))),
        adam_(weights_.size(), {options.learning_rate}),
        scenes_(options.seed),
        pictures_(Extents<4>{options.batch, side(), side(), 3}),
        inputs_(pictures_.shape()) {
    const auto require = [&](bool holds, const char* fault) {
      if (!holds)
        throw file_mismatch({description_.path, "", std::string("cannot be trained: ") + fault,
                             "a model that train_segmenter wrote", ""});
    };
    for (const nn::WeightBlock& weight : network_.weight_blocks())
      require(description_.constants.contains(weight.name), "weights are merged as it is read");
    for (std::size_t output = 0; output < network_.output_count(); ++output)
      require(network_.output_shape(output) == nn::Shape{1, 1, side(), side()},
              "an output is not of the input's size");
  }

  [[nodiscard]] std::size_t side() const { return network_.input_shape(0)[1]; }

  double step(std::size_t index) {
    const auto wanted = draw_batch(index);
    tape_.clear();
    const auto scope = tape_.activate();
    const auto weights = tape_.input(weights_);
    Variable<float> loss = 0;
    for (const auto& logits : nn::forward(network_, ArrayVariable<float, 4>(inputs_), weights, pass_))
      loss += loss::binary_cross_entropy(logits, wanted);
    if (!std::isfinite(loss.value()))
      throw NumericError("train_segmenter: the loss of step " + std::to_string(index + 1) + " is not finite");
    tape_.reverse(loss);
    adam_.set_learning_rate(warm_cosine_rate(options_.learning_rate, index, options_.steps, 200));
    adam_.step(weights_, weights.adjoint());
    return static_cast<double>(loss.value());
  }

  [[nodiscard]] const nn::NetworkDescription& description() {
    network_.set_weights({weights_.data(), weights_.size()});
    for (auto& [name, values] : io::weight_values(network_))
      description_.constants.at(name).values = std::move(values);
    return description_;
  }

  void save(const std::string& path) {
    std::map<std::string, nn::Shape> shapes;
    for (const std::string& output : description_.outputs) shapes[output] = {1, 1, side(), side()};
    io::write_onnx(path, description(), shapes);
  }

 private:
  /// Draws the pictures of a step as the network takes them, and the silhouettes, [N, 1, S, S].
  std::shared_ptr<const Array<float, 4>> draw_batch(std::size_t index) {
    const Random random = scenes_.fork(index);
    Array<float, 3> silhouettes(Extents<3>{options_.batch, side(), side()});
    parallel_for(options_.batch, [&](std::size_t image) {
      put_segmented(random.fork(image), image, pictures_, silhouettes);
      const auto input = segment::u2_net_input(image::picture_of(pictures_, image));
      std::copy_n(input.data(), input.size(), inputs_.data() + image * input.size());
    });
    Array<float, 4> wanted(Extents<4>{options_.batch, 1, side(), side()});
    std::ranges::copy(silhouettes.storage(), wanted.data());
    return std::make_shared<const Array<float, 4>>(std::move(wanted));
  }

  nn::NetworkDescription description_;
  nn::Network<float> network_;
  const SceneTraining& options_;
  Array<float, 1> weights_;
  optim::Adam<float> adam_;
  Random scenes_;
  Array<float, 4> pictures_, inputs_;
  std::shared_ptr<nn::NetworkPass<float>> pass_ = std::make_shared<nn::NetworkPass<float>>();
  Tape<float> tape_;
};

int train(const Options& options) {
  const SceneTraining& training = options.training;
  // The bundled network has three stages, with the fewest channels at the highest resolution.
  Trainer trainer(options.weights.empty()
                      ? segment::u2_net_description(
                            {options.side, {{5, 8, 8}, {4, 8, 16}, {3, 8, 16}}, 8, 16}, training.seed)
                      : io::read_onnx(options.weights),
                  training);
  constexpr std::size_t size = 256;  // of the bundled frames
  const HeldOutScenes sets = held_out_sets(
      0x5E6D0FF5E7ULL, training.validate,
      [](const Random& random, const SceneOptions& scene) { return draw_segmented(random, scene, size); });
  const std::size_t done = train_on_scenes(
      training, [&](std::size_t index) { return StepLoss{trainer.step(index)}; },
      [&] { trainer.save(options.output); }, [&] { print_validation(trainer.description(), sets); });
  if (done == training.steps) return 0;
  std::fprintf(stderr, "\nstopped; the model of step %zu is in %s\n", done,
               for_terminal(options.output).c_str());
  return StopSignal::exit_code();
}

void require_sound(const Options& o) {
  ProblemList list;
  require_sound(o.training, list);
  list.require(o.side >= 32 && o.side <= 1024 && o.side % 16 == 0,
               "--side must be a multiple of 16, 32 to 1024 pixels");
  list.throw_first();
}
}  // namespace

int main(int argc, char** argv) {
  auto app = command_line(
      "Trains a small network of the U²-Net family to find the car in procedural street scenes and writes it "
      "as ONNX.");
  Options options;
  describe(app, options);
  app.footer("  train_segmenter --output segmenter.onnx --seed 1");
  return run_program(app, argc, argv, [&] {
    require_sound(options);
    return run_training(options.training, options.output, [&] { return train(options); });
  });
}
