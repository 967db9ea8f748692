#pragma once
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <tapestry/camouflage/method/methods.hpp>
#include <tapestry/camouflage/objective_terms.hpp>
#include <tapestry/image/transform/chain.hpp>
#include "mesh_axes.hpp"

namespace tapestry::shell {
/// Car and pictures. Empty paths stand for the bundled files.
struct SceneSettings {
  static constexpr const char* group = "Car and pictures";
  std::string mesh;
  geometry::MeshAxes axes;
  std::string object = "car";
  std::string scale = "1";
  std::vector<std::string> material;
  std::string faces;
  std::string frames;
  std::size_t scenes = 0;
  std::string mask = "auto";
  std::string segmenter;
  std::string texture = "atlas";
  std::size_t texels = 0;
  std::size_t samples = 2;
  std::string filter = "anisotropic";
  std::string colour_space = "linear";
  std::string light = "frame";
  std::string unpainted = "photo";
};

struct DetectorSettings {
  static constexpr const char* group = "Detector";
  std::string cfg;
  std::string weights;
  std::string decode;
  std::string detector;
  std::string fit;
  std::string names;
  std::string class_name = "car";
  std::size_t size = 0;
  double confidence = 0.25;
  double nms = 0.45;
  std::string precision = "float";
};

struct OptimisationSettings {
  static constexpr const char* group = "Optimisation";
  std::string method = "fca";
  std::string loss = "max_score";
  camouflage::ObjectiveOptions objective{.printability = 0};  ///< its weights alone
  std::string palette;
  std::string smooth_over = "picture";
  std::string start = "zero";
  std::size_t epochs = 0;
  std::size_t validation = 0;
  std::size_t patience = 0;
  std::size_t batch = 8;
  double worst_views = 1;
  double learning_rate = 0.1;
  std::vector<std::string> ensemble;
  std::vector<std::string> conditions;
  std::uint64_t seed = 1;
};

struct SurveySettings {
  static constexpr const char* group = "Measurement";
  std::string controls = "all";
};

/// Numbers that a setting takes: more than `least` or, unless `excludes_least`, equal to it.
struct Numbers {
  double least = 0, most = std::numeric_limits<double>::infinity();
  bool excludes_least = false;
};
inline constexpr Numbers shares{0, 1}, at_most_a_million{0, 1e6}, of_a_batch{1, 1024};
inline constexpr Numbers above_zero{.excludes_least = true};

// Calls visit(name, value, help) for every setting, or visit(name, value, help, Numbers). A word must be one
// of those in braces of the help, where there are any; see require_values().

template <class Visit>
void visit_settings(SceneSettings& s, Visit visit) {
  visit("mesh", s.mesh, "OBJ file of the car; the bundled sedan when left out");
  visit("up", s.axes.up, up_help);
  visit("forward", s.axes.forward, forward_help);
  visit("object", s.object, object_help);
  visit("scale", s.scale,
        "factor of the mesh's coordinates, such as 0.01 for a mesh in centimetres in frames of metres");
  visit("material", s.material, "materials whose faces are painted; left out, 'body' for the bundled car");
  visit("faces", s.faces,
        "text file of painted faces, one 1-based number a line, instead of --material; none when left out");
  visit("frames", s.frames,
        "folder of frames (.npz, or .json with pictures), or one with the folders train and test; bundled "
        "frames when left out");
  visit("scenes", s.scenes,
        "street scenes of the bundled car that are drawn to optimise on, instead of frames; 0: 800 when "
        "--frames is left out, else none",
        at_most_a_million);
  visit(
      "mask", s.mask,
      "{auto}: the frame's own mask, else the rendered silhouette; {silhouette}; {file}: masks/dataN.png or "
      "maskN.png beside dataN.npz; {u2net}: the mask that --segmenter finds in the frame's picture. Drawn "
      "scenes keep their own");
  visit("segmenter", s.segmenter,
        "ONNX model of the U2-Net family for --mask u2net; a small one that is bundled when left out");
  visit("texture", s.texture, "{atlas}: one uv picture, twice as wide as high; {cube}: texels on every face");
  visit("texels", s.texels, "rows of the atlas, or texels along a cube's edge; 0: 64 or 6");
  visit("filter", s.filter,
        "filter of the atlas: {anisotropic} or {trilinear}, as fine as pixels see it, or {bilinear}, at one "
        "place for each face and pixel");
  visit("samples", s.samples, "samples a pixel along each axis: {1}, {2}, {4} or {8}");
  visit("colour-space", s.colour_space,
        "how colours are lit, filtered and blended: {linear}, in proportion to light as a camera sees it, or "
        "{encoded}, by the numbers of the picture as in the paper");
  visit("light", s.light,
        "light on the car: {frame}, its own; {photo}, from the photograph or all of a simulator's place; "
        "{place}, from all without a pose. The light is taken to be white, the car to be of one colour");
  visit(
      "unpainted", s.unpainted,
      "what glass, tyres and other faces without paint show: {photo}, the frame's own pixels, where its mask "
      "is the car's silhouette (by an IoU of .9), or with --light photo and no mask where the detector finds "
      "the car, else their materials; or {materials} everywhere");
}

inline constexpr const char* decode_help = "how logits become boxes: {darknet}, {ultralytics} or {scaled}";

template <class Visit>
void visit_settings(DetectorSettings& s, Visit visit) {
  visit("cfg", s.cfg,
        "Darknet network description; left out, the one inside converted --weights, or the bundled one");
  visit("weights", s.weights,
        "Darknet weights that belong to --cfg, or an .onnx model, such as convert_weights makes; the "
        "bundled one's when both are left out");
  visit("detector", s.detector,
        "JSON file that describes input and outputs of an .onnx detector, or the family that it is of: "
        "{yolox}, {nanodet}, {picodet}, {yolov5}, {yolov8}, {end_to_end}, {torchvision}, {detr} or "
        "{rt_detr}; left out, those are recognised that can be");
  visit("decode", s.decode,
        std::string(decode_help) +
            "; left out, converted --weights decide, or for Darknet weights the cfg: scaled for "
            "new_coords=1, else darknet");
  visit("fit", s.fit,
        "how a picture goes into the network's input: {letterbox}, {letterbox_top_left} or {stretch}; left "
        "out, as letter_box of the cfg or the detector's description states, else letterbox");
  visit("names", s.names,
        "class names, one a line; left out, those of the bundled detector, for others of 80 classes COCO's, "
        "else none");
  visit("class", s.class_name,
        "name of the class that is the car; its number, from 0, when there are no names");
  visit("size", s.size, "side of the network's square input, pixels; 0: that of the cfg or the model",
        Numbers{0, 4096});
  visit("confidence", s.confidence, "least objectness x class probability of a detection, 0 to 1", shares);
  visit("nms", s.nms,
        "overlap (IoU, or as nms_kind of the cfg has it) above which the weaker of two boxes of one class is "
        "dropped, 0 to 1",
        shares);
  visit("precision", s.precision,
        "precision of products in convolutions: {float}, or {bfloat16}, which is faster on processors that "
        "have it and less accurate everywhere");
}

/// image::condition_names, as words that an option takes.
inline const std::string conditions_help =
    "{camera}, {light}, {blur}, {noise}, {contrast}, {jpeg}, {print}, or {physical} for all";

template <class Visit>
void visit_settings(OptimisationSettings& s, Visit visit) {
  visit("method", s.method, "method of the paint: " + help_of(camouflage::methods<float>()));
  visit("loss", s.loss, "adversarial loss: " + help_of(loss::adversarial_losses));
  for (const auto& term : camouflage::ObjectiveTerms::all)
    if (term.option != nullptr) visit(term.option, term.weight(s.objective), term.help);
  visit("palette", s.palette,
        "text file of printable colours, red, green and blue from 0 to 1 a line; left out, mixtures of four "
        "levels of a printer's three channels");
  visit("smooth-over", s.smooth_over, "smoothness counts steps in the {picture} or in the {texture}");
  visit("start", s.start,
        "first texture: {random}, {zero} (mid grey), {own} (the mesh's colours), or the texture.npz of a run "
        "of this car");
  visit("epochs", s.epochs,
        "passes over the training views; 0: 20 over drawn scenes; over frames, as many as give 2400 views, "
        "at least 5",
        at_most_a_million);
  visit("validation", s.validation,
        "training views to try each epoch's paint on instead; the best is kept. 0: the last epoch's is");
  visit("patience", s.patience,
        "epochs without a better --validation after which the run ends; 0: never before --epochs",
        at_most_a_million);
  visit("batch", s.batch, "views a step", of_a_batch);
  visit("worst-views", s.worst_views,
        "share of each step's views to learn from, those of the largest losses (conditional value at risk); "
        "1: all",
        Numbers{0, 1, true});
  visit("learning-rate", s.learning_rate, "Adam's step size; 0.01 in the paper", above_zero);
  visit("ensemble", s.ensemble,
        "further detectors to optimise against, .onnx models of the same input "
        "size and --class: the loss is the mean over all; only the first, --weights, is measured");
  visit("conditions", s.conditions,
        "conditions under which every step photographs its views, drawn anew: " + conditions_help +
            "; none when left out");
  visit("seed", s.seed,
        "seed of the start texture, the views' order, --conditions and the draws of --method");
}

template <class Visit>
void visit_settings(SurveySettings& s, Visit visit) {
  visit("controls", s.controls,
        "what is measured beside the paint: {all}, or {matched}, without random and plain colours, which are "
        "the same for every paint");
}

/// Adds one option for each setting, in the group of these settings, except those named in `except`.
template <class Settings>
void add_options(CLI::App& app, Settings& settings, const std::vector<std::string>& except = {}) {
  app.option_defaults()->group(Settings::group);
  visit_settings(settings, [&](const char* name, auto& value, const std::string& help, const auto&...) {
    if (std::find(except.begin(), except.end(), name) != except.end()) return;
    app.add_option(std::string("--") + name, value, help);
  });
}

/// Values of settings that are missing in an older manifest: off, left to the detector, or the only choice at
/// that time. Others must be present.
inline const nlohmann::ordered_json& values_when_lacking() {
  static const auto values = nlohmann::ordered_json::parse(
      R"({"up": "z", "forward": "x", "object": "car", "scale": "1", "segmenter": "", "filter": "bilinear",
      "colour-space": "encoded", "light": "frame", "unpainted": "materials", "precision": "float", "decode": "",
      "fit": "", "detector": "", "method": "fca", "palette": "", "validation": "0", "patience": "0", "ensemble": "",
      "conditions": "", "controls": "all", "paint": "optimised", "attacks": "measured"})");
  return values;
}
inline const std::string* value_when_lacking(const std::string& name) {
  const auto found = values_when_lacking().find(name);
  return found == values_when_lacking().end() ? nullptr : found->get_ptr<const std::string*>();
}

/// Adds the settings to a JSON object under their option names.
template <class Settings>
void add_json(nlohmann::ordered_json& json, Settings settings) {
  visit_settings(settings, [&](const char* name, auto& value, const auto&...) {
    const nlohmann::ordered_json setting = value;
    const std::string* const lacking = value_when_lacking(name);
    if (lacking != nullptr && (setting.empty() || setting == *lacking)) return;
    json[name] = setting;
  });
}

/// Settings that decide the result of a run, under the names of their options.
template <class... Settings>
nlohmann::ordered_json json_of_settings(const Settings&... settings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  (add_json(json, settings), ...);
  return json;
}

/// The number of --scale; 0 for other text.
inline double scale_of(const SceneSettings& settings) {
  double scale = 0;
  return io::parse_number(settings.scale, scale) ? scale : 0;
}

inline bool is_texture_file(const std::string& start) { return start.ends_with(".npz"); }

/// Requires that the numbers of settings lie in their ranges, and that words are among those in braces of
/// their help. An empty word leaves the choice open; --start and --detector take files, too.
template <class Settings>
void require_values(Settings s, ProblemList& list) {
  const auto require = [&]<class Value>(const std::string& name, const Value& value, const std::string& help,
                                        const Numbers& numbers = {}) {
    const std::string option = "--" + name, *const lacking = value_when_lacking(name);
    if constexpr (std::is_arithmetic_v<Value>)
      list.require_number(option, static_cast<double>(value), numbers.least, numbers.most,
                          numbers.excludes_least);
    std::string word;
    if constexpr (std::is_integral_v<Value>) word = std::to_string(value);
    if constexpr (std::is_same_v<Value, std::string>) word = value;
    const bool is_file = name == "detector" || (name == "start" && is_texture_file(word));
    const bool is_open = word.empty() && lacking != nullptr && lacking->empty();
    const auto words = words_in(help);
    if (!words.empty() && !is_open && !is_file) list.require_choice(option, word, words);
  };
  visit_settings(s, require);
}

inline void require_sound(const SceneSettings& s, ProblemList& list) {
  require_values(s, list);
  require_right_angle(s.axes, list);
  list.require(scale_of(s) > 0, "--scale is '" + s.scale + "'; expected a number above 0, such as 0.01");
  list.require(s.segmenter.empty() || s.mask == "u2net", "--segmenter needs --mask u2net");
  list.require_number("--texels", static_cast<double>(s.texels), 0, s.texture == "cube" ? 256 : 8192);
  list.require(s.faces.empty() || s.material.empty(), "--faces and --material cannot be given together");
  list.require(s.mesh.empty() || !s.faces.empty() || !s.material.empty(),
               "--mesh needs --material or --faces, which select the painted faces");
}

inline void require_sound(const DetectorSettings& s, ProblemList& list) {
  require_values(s, list);
  list.require(s.cfg.empty() || !s.weights.empty(), "--cfg and --weights go together; --weights is missing");
}

inline void require_sound(const SurveySettings& s, ProblemList& list) { require_values(s, list); }

inline void require_sound(const OptimisationSettings& s, ProblemList& list) {
  require_values(s, list);
  list.attempt([&] { (void)image::conditions_by_names(s.conditions); });
  list.require(s.worst_views == 1 || s.batch > 1,
               "--worst-views has nothing to choose from where --batch is 1");
  list.require(s.patience == 0 || s.validation > 0, "--patience needs --validation above 0");
  list.require(s.palette.empty() || s.objective.printability > 0, "--palette needs --printability above 0");
}

/// Whether a 0 leaves a setting to the program, as in its help.
inline bool is_open_at_zero(const std::string& name) {
  return name == "scenes" || name == "texels" || name == "size" || name == "epochs";
}

/// For a resumed run: settings not given on the command line are taken from the saved ones. The names of
/// those that were given and differ are added to `differing`. A 0 that leaves the choice to the program
/// agrees with any saved value.
/// \throws FileError (malformed) if `saved`, read from the file `path`, lacks a setting or has an invalid one
template <class Settings>
void adopt_saved(const CLI::App& app, const nlohmann::ordered_json& saved, const std::string& path,
                 Settings& settings, std::vector<std::string>& differing) {
  Settings whole;
  const auto is_left_out = [&](const char* name) {
    return value_when_lacking(name) != nullptr && saved.is_object() && !saved.contains(name);
  };
  visit_settings(whole, [&](const char* name, auto& value, const auto&...) {
    if (is_left_out(name)) return;
    bool is_sound = saved.is_object() && saved.contains(name);
    if constexpr (std::is_integral_v<std::remove_reference_t<decltype(value)>>)  // no fractions
      is_sound = is_sound && saved[name].is_number_unsigned();
    try {
      if (is_sound) saved[name].get_to(value);
    } catch (const nlohmann::json::exception&) {
      is_sound = false;
    }
    const bool lacks = saved.is_object() && !saved.contains(name);  // as in manifests of earlier versions
    if (!is_sound)
      throw malformed_file({path, "", std::string("no sound setting '") + name + "'",
                            lacks ? "a run that this version began" : "", ""});
  });
  ProblemList problems;
  require_sound(whole, problems);
  if (!problems.problems().empty()) throw malformed_file({path, "", problems.problems().front().what()});
  visit_settings(settings, [&](const char* name, auto& value, const auto&...) {
    using Value = std::remove_reference_t<decltype(value)>;
    Value previous{};
    if constexpr (std::is_same_v<Value, std::string>)
      if (is_left_out(name)) previous = *value_when_lacking(name);
    if (!is_left_out(name)) saved[name].get_to(previous);
    const bool given = app.get_option(std::string("--") + name)->count() > 0;
    const bool left_open = std::is_unsigned_v<Value> && value == Value{} && is_open_at_zero(name);
    if (given && !left_open && value != previous)
      differing.push_back(std::string("--") + name + " (was " + nlohmann::ordered_json(previous).dump() +
                          ", now " + nlohmann::ordered_json(value).dump() + ")");
    else
      value = previous;
  });
}
}  // namespace tapestry::shell
