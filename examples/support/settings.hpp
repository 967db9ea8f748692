#pragma once
#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <tapestry/core/error.hpp>
#include <type_traits>
#include <vector>

namespace tapestry::examples {

/// What car, in which pictures. Empty paths stand for the bundled default.
struct SceneSettings {
  std::string mesh;
  std::vector<std::string> material;
  std::string faces;
  std::string frames;
  std::size_t scenes = 0;
  std::string mask = "auto";
  std::string texture = "atlas";
  std::size_t texels = 0;
  std::size_t samples = 2;
};

/// Which detector, and what it is asked for.
struct DetectorSettings {
  std::string cfg;
  std::string weights;
  std::string names;
  std::string class_name = "car";
  std::size_t size = 0;
  double confidence = 0.25;
  double nms = 0.45;
};

/// How the texture is optimised.
struct OptimisationSettings {
  std::string loss = "max_score";
  double iou = 0.05;
  double objectness = 1;
  double classification = 0.5;
  double max_score = 1;
  double smoothness = 1;
  std::string smooth_over = "picture";
  std::string start = "zero";
  std::size_t epochs = 0;
  std::size_t batch = 8;
  double learning_rate = 0.1;
  std::uint64_t seed = 1;
};

template <class Visit>
void visit_settings(SceneSettings& s, Visit visit) {
  visit("mesh", s.mesh, "OBJ file of the car; the bundled sedan when left out");
  visit("material", s.material, "materials whose faces are painted; 'body' for the bundled car");
  visit("faces", s.faces, "text file of painted faces, one 1-based number a line, instead of --material");
  visit("frames", s.frames,
        "folder of frames (.npz), or one with the folders train and test; bundled frames when left out");
  visit("scenes", s.scenes,
        "street scenes of the bundled car that are drawn to optimise on, instead of frames; 0: 800 when "
        "--frames is left out, else none");
  visit("mask", s.mask,
        "auto: the frame's own mask, else the rendered silhouette; silhouette; file: maskN.png beside "
        "dataN.npz");
  visit("texture", s.texture, "atlas: one uv picture, twice as wide as high; cube: texels on every face");
  visit("texels", s.texels, "rows of the atlas, or texels along a cube's edge; 0: 64 or 6");
  visit("samples", s.samples, "samples a pixel along each axis: 1, 2, 4 or 8");
}

template <class Visit>
void visit_settings(DetectorSettings& s, Visit visit) {
  visit("cfg", s.cfg, "Darknet network description; the bundled detector when left out");
  visit("weights", s.weights, "Darknet weights that belong to --cfg");
  visit("names", s.names, "class names, one a line");
  visit("class", s.class_name, "name of the class that is the car");
  visit("size", s.size, "side of the network's square input, pixels; 0: as the cfg says");
  visit("confidence", s.confidence, "least objectness x class probability of a detection, 0 to 1");
  visit("nms", s.nms, "overlap (IoU) above which the weaker of two boxes of one class is dropped, 0 to 1");
}

template <class Visit>
void visit_settings(OptimisationSettings& s, Visit visit) {
  visit("loss", s.loss, "adversarial loss: paper, as_coded or max_score");
  visit("iou-weight", s.iou, "weight alpha of the IoU term");
  visit("objectness-weight", s.objectness, "weight beta of the objectness term");
  visit("class-weight", s.classification, "weight gamma of the classification term");
  visit("max-score-weight", s.max_score, "weight of the max_score term");
  visit("smoothness-weight", s.smoothness, "weight mu of the smoothness term, in units of 1e-4");
  visit("smooth-over", s.smooth_over, "smoothness counts steps in the picture or in the texture");
  visit("start", s.start, "first texture: random, zero (mid grey) or own (the mesh's colours)");
  visit(
      "epochs", s.epochs,
      "passes over the training views; 0: 20 over drawn scenes; over frames enough to show 2400, at least 5");
  visit("batch", s.batch, "views a step");
  visit("learning-rate", s.learning_rate, "Adam's step size; 0.01 in the paper");
  visit("seed", s.seed, "seed of the start texture and of the views' order");
}

/// Adds one option a setting.
template <class Settings>
void add_options(CLI::App& app, Settings& settings) {
  visit_settings(settings, [&](const char* name, auto& value, const char* help) {
    app.add_option(std::string("--") + name, value, help)->capture_default_str();
  });
}

/// Adds the settings to a JSON object under their option names.
template <class Settings>
void add_json(nlohmann::ordered_json& json, Settings settings) {
  visit_settings(settings, [&](const char* name, auto& value, const char*) { json[name] = value; });
}

/// For a resumed run: settings not given on the command line are taken from the saved ones; the names of
/// those given and different are added to `differing`.
template <class Settings>
void adopt_saved(const CLI::App& app, const nlohmann::ordered_json& saved, Settings& settings,
                 std::vector<std::string>& differing) {
  visit_settings(settings, [&](const char* name, auto& value, const char*) {
    using Value = std::remove_reference_t<decltype(value)>;
    if (!saved.contains(name)) return;
    const auto previous = saved[name].template get<Value>();
    if (app.get_option(std::string("--") + name)->count() > 0 && value != previous)
      differing.push_back(std::string("--") + name + " (was " + saved[name].dump() + ", now " +
                          nlohmann::ordered_json(value).dump() + ")");
    else
      value = previous;
  });
}

/// Throws Error (usage) naming the choices unless `value` is one of them.
inline void require_choice(const char* option, const std::string& value,
                           const std::vector<std::string>& choices) {
  std::string list;
  for (const auto& choice : choices) {
    if (choice == value) return;
    list += (list.empty() ? "" : ", ") + choice;
  }
  throw Error(ErrorKind::usage, std::string(option) + " is '" + value + "'; expected one of " + list);
}

}  // namespace tapestry::examples
