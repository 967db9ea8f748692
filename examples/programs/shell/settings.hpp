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

/// The detector and its thresholds.
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

/// Settings of the texture's optimisation.
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
  std::size_t batch = 8;
  double worst_views = 1;
  double learning_rate = 0.1;
  std::vector<std::string> ensemble;
  std::vector<std::string> conditions;
  std::uint64_t seed = 1;
};

/// Settings of the measurement at a run's end.
struct SurveySettings {
  static constexpr const char* group = "Measurement";
  std::string controls = "all";
};

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
        "--frames is left out, else none");
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
        "light on the car: {frame}, the light that the frame states, or {photo}, sun and sky estimated from "
        "the car in each frame's picture, which is taken to be of one colour and well exposed");
  visit(
      "unpainted", s.unpainted,
      "what glass, tyres and other faces without paint show: {photo}, the frame's own pixels, where its mask "
      "is the car's silhouette (by an IoU of .9), or with --light photo and no mask where the detector finds "
      "the car, else their materials; or {materials} everywhere");
}

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
        "how logits become boxes: {darknet}, {ultralytics} or {scaled}; left out, converted --weights "
        "decide, or for Darknet weights the cfg: scaled for new_coords=1, else darknet");
  visit("fit", s.fit,
        "how a picture goes into the network's input: {letterbox}, {letterbox_top_left} or {stretch}; left "
        "out, as letter_box of the cfg or the detector's description states, else letterbox");
  visit("names", s.names,
        "class names, one a line; left out, those of the bundled detector, for others of 80 classes COCO's, "
        "else none");
  visit("class", s.class_name,
        "name of the class that is the car; its number, from 0, when there are no names");
  visit("size", s.size, "side of the network's square input, pixels; 0: that of the cfg or the model");
  visit("confidence", s.confidence, "least objectness x class probability of a detection, 0 to 1");
  visit("nms", s.nms,
        "overlap (IoU, or as nms_kind of the cfg has it) above which the weaker of two boxes of one class is "
        "dropped, 0 to 1");
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
        "at least 5");
  visit("validation", s.validation,
        "training views to try each epoch's paint on instead; the best is kept. 0: the last epoch's is");
  visit("batch", s.batch, "views a step");
  visit("worst-views", s.worst_views,
        "share of each step's views to learn from, those of the largest losses (conditional value at risk); "
        "1: all");
  visit("learning-rate", s.learning_rate, "Adam's step size; 0.01 in the paper");
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
  visit_settings(settings, [&](const char* name, auto& value, const std::string& help) {
    if (std::find(except.begin(), except.end(), name) != except.end()) return;
    app.add_option(std::string("--") + name, value, help);
  });
}

/// Value of a setting that is missing in an older manifest: off, left to the detector, or the only choice at
/// that time. Null if the setting must be present.
inline const char* value_when_lacking(const std::string& name) {
  if (name == "filter") return raster::name_of(raster::TextureFilter::bilinear);
  if (name == "light") return "frame";
  if (name == "unpainted") return "materials";
  if (name == "paint") return "optimised";
  if (name == "attacks") return "measured";
  if (name == "up") return "z";
  if (name == "forward") return "x";
  if (name == "object") return "car";
  if (name == "scale") return "1";
  if (name == "method") return "fca";
  if (name == "precision") return "float";
  if (name == "validation") return "0";
  if (name == "controls") return "all";
  if (name == "colour-space") return image::name_of(image::ColourSpace::encoded);
  const bool is_open = name == "segmenter" || name == "decode" || name == "fit" || name == "detector" ||
                       name == "ensemble" || name == "conditions" || name == "palette";
  return is_open ? "" : nullptr;
}

/// Adds the settings to a JSON object under their option names.
template <class Settings>
void add_json(nlohmann::ordered_json& json, Settings settings) {
  visit_settings(settings, [&](const char* name, auto& value, const std::string&) {
    const nlohmann::ordered_json setting = value;
    const char* const lacking = value_when_lacking(name);
    if (lacking != nullptr && (setting.empty() || setting == lacking)) return;
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

/// Whether --start names a file.
inline bool is_texture_file(const std::string& start) { return start.ends_with(".npz"); }

inline void require_sound(const SceneSettings& s, ProblemList& list) {
  require_axes(s.axes, s.object, list);
  list.require(scale_of(s) > 0, "--scale is '" + s.scale + "'; expected a number above 0, such as 0.01");
  list.require_choice("--mask", s.mask, {"auto", "silhouette", "file", "u2net"});
  list.require(s.segmenter.empty() || s.mask == "u2net", "--segmenter needs --mask u2net");
  list.require_choice("--texture", s.texture, {"atlas", "cube"});
  list.require_choice("--filter", s.filter, names_of(raster::texture_filters));
  list.require_choice("--light", s.light, {"frame", "photo"});
  list.require_choice("--unpainted", s.unpainted, {"photo", "materials"});
  list.require_choice("--colour-space", s.colour_space, names_of(image::colour_spaces));
  list.require(s.samples == 1 || s.samples == 2 || s.samples == 4 || s.samples == 8,
               "--samples is " + std::to_string(s.samples) + "; expected 1, 2, 4 or 8");
  list.require(s.scenes <= 1000000, "--scenes must be at most 1000000");
  const std::size_t most_texels = s.texture == "cube" ? 256 : 8192;
  list.require(s.texels <= most_texels, "--texels must be at most " + std::to_string(most_texels));
  list.require(s.faces.empty() || s.material.empty(), "--faces and --material cannot be given together");
  list.require(s.mesh.empty() || !s.faces.empty() || !s.material.empty(),
               "--mesh needs --material or --faces, which select the painted faces");
}

/// Choices of --decode: the families of cfgs.
inline std::vector<std::string> decode_choices() {
  std::vector<std::string> choices;
  for (const auto family : detect::decode_families)
    if (detect::has_anchors(family)) choices.emplace_back(detect::name_of(family));
  return choices;
}

inline void require_sound(const DetectorSettings& s, ProblemList& list) {
  list.require(s.cfg.empty() || !s.weights.empty(), "--cfg and --weights go together; --weights is missing");
  if (!s.decode.empty()) list.require_choice("--decode", s.decode, decode_choices());
  if (!s.fit.empty()) list.require_choice("--fit", s.fit, names_of(image::fit_kinds));
  list.require(s.size <= 4096, "--size must be at most 4096 pixels");
  list.require(s.confidence >= 0 && s.confidence <= 1, "--confidence lies in 0 to 1");
  list.require(s.nms >= 0 && s.nms <= 1, "--nms lies in 0 to 1");
  list.require_choice("--precision", s.precision, {"float", "bfloat16"});
}

inline void require_controls(const std::string& controls, ProblemList& list) {
  list.require_choice("--controls", controls, {"all", "matched"});
}

inline void require_sound(const SurveySettings& s, ProblemList& list) { require_controls(s.controls, list); }

inline void require_sound(const OptimisationSettings& s, ProblemList& list) {
  list.require_choice("--method", s.method, names_of(camouflage::methods<float>()));
  list.attempt([&] { (void)loss::adversarial_loss_by_name(s.loss); });
  list.attempt([&] { (void)image::conditions_by_names(s.conditions); });
  list.require_choice("--smooth-over", s.smooth_over, {"picture", "texture"});
  if (!is_texture_file(s.start)) list.require_choice("--start", s.start, {"random", "zero", "own"});
  auto objective = s.objective;
  for (const auto& term : camouflage::ObjectiveTerms::all)
    list.require(term.option == nullptr || term.weight(objective) >= 0,
                 std::string("--") + (term.option ? term.option : "") + " must be at least 0");
  list.require(s.epochs <= 1000000, "--epochs must be at most 1000000");
  list.require(s.batch >= 1 && s.batch <= 1024, "--batch must be 1 to 1024");
  list.require(s.worst_views > 0 && s.worst_views <= 1, "--worst-views must be above 0 and at most 1");
  list.require(s.worst_views == 1 || s.batch > 1,
               "--worst-views has nothing to choose from where --batch is 1");
  list.require(s.palette.empty() || s.objective.printability > 0, "--palette needs --printability above 0");
  list.require(s.learning_rate > 0, "--learning-rate must be above 0");
}

inline void require_sound_thread_count(int threads, ProblemList& list) {
  list.require(threads >= 0 && threads <= 1024, "--threads must be 0 to 1024");
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
  visit_settings(whole, [&](const char* name, auto& value, const std::string&) {
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
      throw FileError(ErrorKind::malformed, {path, "", std::string("no sound setting '") + name + "'",
                                             lacks ? "a run that this version began" : "", ""});
  });
  ProblemList problems;
  require_sound(whole, problems);
  if (!problems.problems().empty())
    throw FileError(ErrorKind::malformed, {path, "", problems.problems().front().what()});
  visit_settings(settings, [&](const char* name, auto& value, const std::string&) {
    using Value = std::remove_reference_t<decltype(value)>;
    Value previous{};
    if constexpr (std::is_same_v<Value, std::string>)
      if (is_left_out(name)) previous = value_when_lacking(name);
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
