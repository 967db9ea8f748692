#include "inputs.hpp"

#include <tapestry/evaluate/meter.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/painted.hpp>

#include "../../scenes/dark_parts.hpp"
#include "../../scenes/drawn_frames.hpp"
#include "own_texture.hpp"
#include "run_manifest.hpp"

namespace tapestry::shell {
namespace {
/// An atlas spans the u of the painted faces, with square texels.
raster::TextureLayout layout_of(const SceneSettings& settings, const raster::PaintedMesh& car) {
  auto layout = settings.texture == "cube" ? raster::cube_layout(settings.texels) : raster::TextureLayout{};
  layout.filter = raster::texture_filter_by_name(settings.filter);
  if (!layout.traits().is_picture) return layout;
  if (car.mesh.uvs.empty())
    throw file_mismatch(
        {settings.mesh, "", "no texture coordinates, which an atlas needs", "vt records, or --texture cube"});
  require_uvs(settings.mesh, car.mesh, car.painted, "an atlas");
  try {
    layout.u_extent = raster::u_extent_of(car);
  } catch (const DomainError& error) {
    throw file_mismatch({settings.mesh, "", error.what()});
  }
  layout.height = settings.texels;
  layout.width = settings.texels * static_cast<std::size_t>(layout.u_extent);
  return layout;
}

std::string word_on_starved(const Car& car) {
  return formatted("%.0f", 100 * car.starved_share) +
         " % of the painted area has hardly a texel of the atlas: its uv share points, as of a palette, "
         "or are small, for which see --texels";
}

/// Checks the files of a detector. The other files are checked even if the cfg is unsound.
void check_detector(DetectorSettings settings, ProblemList& list, std::vector<std::string>& warnings) {
  fill_in_bundled(settings);
  if (settings.weights.empty()) return;
  bool is_sound = false;
  list.attempt([&] {
    std::vector<std::string> remarks;
    const auto loaded = load_detector(settings, remarks);
    is_sound = true;
    warnings.insert(warnings.end(), remarks.begin(), remarks.end());
    loss::require_raw_logits("camouflage", loaded.heads());
    (void)loaded.class_index(settings.class_name);
  });
  if (is_sound) return;
  const std::string found = list.problems().back().what();
  for (const auto& path : {settings.weights, settings.names})
    if (!path.empty() && !found.starts_with(path + ":")) list.attempt([&] { (void)io::RegularFile(path); });
}

/// Warns of frames that the manifest of make_dataset lists and the folder lacks: the program was interrupted,
/// or frames were removed. In other folders a file of this name may be anything.
std::vector<std::string> warnings_about_set(const std::string& folder) {
  std::vector<std::string> warnings;
  const std::string path = manifest_path(folder);
  if (folder.empty() || !is_there(path)) return warnings;
  Json manifest;
  try {
    manifest = read_json_file(path);
  } catch (const FileError&) {
    return warnings;
  }
  if (!manifest.is_object() || manifest.value("program", Json()) != "make_dataset") return warnings;
  const auto promised = manifest.find("frames");
  if (promised == manifest.end() || !promised->is_object()) return warnings;
  for (const char* part : {"train", "test"}) {
    const Json count = promised->value(part, Json());
    if (!count.is_number_unsigned()) continue;
    const std::string frames = folder + "/" + part;
    const std::size_t found = is_folder(frames) ? io::listed_paths(frames, is_frame_file).size() : 0;
    if (found < count.get<std::size_t>())
      warnings.push_back(frames + " holds " + std::to_string(found) + " of the " + count.dump() +
                         " frames that make_dataset was to draw; the same command again completes them");
  }
  return warnings;
}
}  // namespace

void fill_in_bundled(SceneSettings& scene) {
  const BundledAssets bundled;
  if (scene.mesh.empty()) {
    scene.mesh = bundled.mesh();
    if (scene.material.empty() && scene.faces.empty()) scene.material = {"body"};
  }
  if (scene.frames.empty()) {
    scene.frames = bundled.frames();
    if (scene.scenes == 0) scene.scenes = 800;
  }
  if (scene.mask == "u2net" && scene.segmenter.empty()) scene.segmenter = bundled.segmenter();
  if (scene.texels == 0) scene.texels = scene.texture == "cube" ? 6 : 64;
}

void fill_in_bundled(DetectorSettings& detector) {
  const BundledAssets bundled;
  if (detector.cfg.empty() && detector.weights.empty()) {
    detector.cfg = bundled.cfg();
    detector.weights = bundled.weights();
    if (detector.names.empty()) detector.names = bundled.names();
  }
  if (detector.detector.empty()) detector.detector = io::description_beside(detector.weights);
}

Car load_car(const SceneSettings& settings) {
  const io::InputLedger::Role role(mesh_role);
  auto loaded = io::read_obj(settings.mesh);
  Car car;
  car.warnings = loaded.warnings;
  car.material_files = loaded.material_files;
  const auto own = own_textures(loaded.mesh, car.warnings);
  car.painted.painted =
      selected_faces(settings.mesh, loaded.mesh, settings.material, settings.faces, car.warnings);
  car.painted.mesh = scenes::with_dark_parts(std::move(loaded.mesh), car.painted.painted);
  car.painted.layout = layout_of(settings, car.painted);
  car.painted.mesh =
      upright_object(settings.mesh, std::move(car.painted.mesh), settings.axes, settings.object);
  car.scale = scale_of(settings);
  for (auto& position : car.painted.mesh.positions) position = geometry::scale(position, car.scale);
  car.starved_share = raster::starved_share(car.painted);
  if (car.starved_share >= 0.05) car.warnings.push_back(settings.mesh + ": " + word_on_starved(car));
  car.painted.space = image::colour_space_by_name(settings.colour_space);
  car.painted.pyramid = raster::pyramid_of(car.painted);
  car.painted.pictures = pictures_of(own, car.painted.mesh, car.painted.layout.filter, car.painted.space);
  car.description = description_of(
      car.painted, painted_part(settings.material, settings.faces, car.painted.painted), settings.axes);
  return car;
}

void require_texels(const SceneSettings& settings, const Car& car) {
  constexpr double most = 0.5;
  if (car.starved_share <= most) return;
  SceneSettings finest = settings;
  finest.texels = std::max<std::size_t>(settings.texels, 1024);
  raster::PaintedMesh fine = car.painted;
  fine.layout = layout_of(finest, fine);
  if (raster::starved_share(fine) > most)  // small charts need rows alone
    throw file_mismatch(
        {settings.mesh, "", word_on_starved(car) + "; --texture cube gives every face texels of its own"});
}

FrameLists find_frames(const SceneSettings& scene) {
  const std::string& folder = scene.frames;
  FrameLists lists;
  const bool has_test = is_folder(folder + "/test", ErrorKind::malformed);
  lists.drawn = scene.scenes;
  lists.held_out = lists.drawn > 0 || (has_test && is_folder(folder + "/train", ErrorKind::malformed));
  lists.test = io::frame_paths(has_test ? folder + "/test" : folder);
  if (lists.drawn == 0) lists.train = lists.held_out ? io::frame_paths(folder + "/train") : lists.test;
  return lists;
}

void require_one_scale(const FrameLists& lists) {
  if (lists.posed && lists.drawn > 0)
    throw file_mismatch({lists.test.front(), "",
                         "a frame without a camera sees a car normalised to length 2, but "
                         "--scenes see the bundled car in metres"});
}

io::Frame load_frame(const std::string& path, const MaskRule& mask, std::optional<bool> posed) {
  const io::InputLedger::Role role(frame_role);
  auto frame = io::read_frame(path);
  if (frame.camera.has_value() == posed)
    throw file_mismatch({path, "", "frames with and without a camera cannot be mixed",
                         *posed ? "poses alone, as in the first frame" : "a camera, as in the first frame",
                         *posed ? "a camera" : "poses alone"});
  apply_mask_rule(mask, path, frame);
  frame.name = io::path_of(path).stem().string();
  return frame;
}

FrameLoaders frame_loaders(const std::vector<std::string>& paths, const MaskRule& mask, bool posed) {
  FrameLoaders loaders;
  for (const auto& path : paths) loaders.push_back([=] { return load_frame(path, mask, posed); });
  return loaders;
}

FrameLoaders train_loaders(const FrameLists& lists, const MaskRule& mask) {
  auto loaders = frame_loaders(lists.train, mask, lists.posed);
  const bool has_masks = mask.kind != "silhouette";
  const scenes::DrawnFrames draw{lists.drawn, scenes::DrawnFrames::Stream::train};
  for (std::size_t i = 0; i < lists.drawn; ++i)
    loaders.push_back([=] {
      io::Frame frame = draw(i);
      frame.name = "scene " + std::to_string(i);
      if (!has_masks) frame.mask.reset();
      return frame;
    });
  return loaders;
}

void note_frames(const std::vector<std::string>& frames, const MaskRule& mask) {
  const io::InputLedger::Role role(frame_role);
  for (const std::string& frame : frames) {
    for (const std::string& part : io::frame_files(frame)) io::InputLedger::note(part);
    const io::InputLedger::Role beside(mask_role);
    if (mask.kind == "file") io::InputLedger::note(mask_path_of(frame));
  }
}

std::vector<std::string> warnings_about(const SceneSettings& scene) {
  std::vector<std::string> warnings = warnings_about_set(scene.frames);
  const BundledAssets bundled;
  if (scene.mesh == bundled.mesh() || (scene.scenes == 0 && scene.frames != bundled.frames()))
    return warnings;
  warnings.push_back("the bundled frames and --scenes show the bundled car, not " + scene.mesh +
                     "; the two will not cover each other. Give --frames of that car, and no --scenes");
  return warnings;
}

detect::Detector<float> load_first_detector(const DetectorSettings& settings,
                                            std::vector<std::string>& warnings,
                                            const std::vector<std::string>& layers) {
  const io::InputLedger::Role role(role_of_detector());
  return load_detector(settings, warnings, layers);
}

Inputs load_inputs(SceneSettings& scene, DetectorSettings& detector, const std::vector<std::string>& layers) {
  fill_in_bundled(scene);
  fill_in_bundled(detector);
  std::vector<std::string> warnings;
  Inputs inputs{load_first_detector(detector, warnings, layers),
                0,
                {},
                load_car(scene),
                find_frames(scene),
                warnings_about(scene)};
  inputs.class_index = inputs.detector.class_index(detector.class_name);
  inputs.mask = load_mask_rule(scene, inputs.warnings);
  const std::string& path = inputs.frames.test.front();
  const io::Frame first = io::read_frame(path);
  inputs.frames.posed = !first.camera;
  if (const auto word = word_on_masks(inputs.mask, path, first); !word.empty())
    inputs.warnings.push_back(word);
  if (inputs.frames.posed)
    inputs.car.painted.mesh = geometry::normalise_mesh(std::move(inputs.car.painted.mesh));
  inputs.keeps_photograph = scene.unpainted == "photo";
  if (scene.light != "frame")
    inputs.photo_light = camouflage::PhotoLight{.occlusion = std::make_shared<const raster::AmbientOcclusion>(
                                                    raster::ambient_occlusion(inputs.car.painted.mesh)),
                                                .is_one_place = scene.light == "place"};
  for (const auto* more : {&warnings, &inputs.car.warnings})
    inputs.warnings.insert(inputs.warnings.end(), more->begin(), more->end());
  return inputs;
}

std::optional<camouflage::PhotoLight> witnessed(std::optional<camouflage::PhotoLight> rule,
                                                const detect::Detector<float>& detector,
                                                std::size_t class_index, const DetectorSettings& settings) {
  if (!rule) return rule;
  const auto meter = std::make_shared<evaluate::Meter>(
      detector, class_index, evaluate::MeterSettings{settings.confidence, settings.nms});
  rule->shows_car = [meter](const Array<float, 3>& picture, const std::string& name, const detect::Box& box) {
    return meter->examine(picture, name, box).found;
  };
  return rule;
}

camouflage::ViewStore<float>::Settings store_settings(const Inputs& inputs, const SceneSettings& scene,
                                                      const DetectorSettings& detector,
                                                      std::size_t keep_mib) {
  return {inputs.detector.input_height(),
          inputs.detector.input_width(),
          scene.samples,
          keep_mib << 20U,
          inputs.detector.fit(),
          witnessed(inputs.photo_light, inputs.detector, inputs.class_index, detector),
          false,
          inputs.keeps_photograph};
}

FurtherDetector load_further_detector(const std::string& option, const std::string& path,
                                      DetectorSettings settings, std::vector<std::string>& warnings,
                                      const std::vector<std::string>& layers) {
  if (!io::is_onnx(path))
    throw Error(ErrorKind::usage, option + ": " + path +
                                      " is not an .onnx model; convert_weights makes one of Darknet weights");
  settings.cfg = settings.decode = settings.fit = "";
  settings.weights = path;
  settings.detector = io::description_beside(path);
  const io::InputLedger::Role role(role_of_detector(path));
  FurtherDetector further{load_detector(settings, warnings, layers)};
  further.class_index = further.detector.class_index(settings.class_name);
  return further;
}

std::vector<FurtherDetector> load_ensemble(const std::vector<std::string>& paths,
                                           const DetectorSettings& settings,
                                           const detect::Detector<float>& first,
                                           std::vector<std::string>& warnings) {
  std::vector<FurtherDetector> members;
  for (const std::string& path : paths) {
    FurtherDetector member = load_further_detector("--ensemble", path, settings, warnings);
    loss::require_raw_logits("camouflage", member.detector.heads());
    const auto& network = member.detector;
    const std::size_t height = first.input_height(), width = first.input_width();
    if (network.input_height() != height || network.input_width() != width)
      throw file_mismatch(
          {path, "", "an input of another size than the first detector's; --size chooses one for all",
           std::to_string(width) + "x" + std::to_string(height),
           std::to_string(network.input_width()) + "x" + std::to_string(network.input_height())});
    if (member.detector.fit().kind != first.fit().kind)
      warnings.push_back(path + " gets its pictures by --fit " +
                         std::string(image::name_of(first.fit().kind)) + ", as the first detector, not by " +
                         std::string(image::name_of(member.detector.fit().kind)));
    members.push_back(std::move(member));
  }
  return members;
}

void check_inputs(SceneSettings scene, const DetectorSettings& detector, ProblemList& list,
                  std::vector<std::string>& warnings) {
  fill_in_bundled(scene);
  list.attempt([&] { warnings = warnings_about(scene); });
  check_detector(detector, list, warnings);
  if (!scene.faces.empty() || !scene.material.empty())
    list.attempt([&] {
      const Car car = load_car(scene);
      warnings.insert(warnings.end(), car.warnings.begin(), car.warnings.end());
    });
  FrameLists frames;
  list.attempt([&] { frames = find_frames(scene); });
  std::vector<std::string> paths = frames.test;
  if (frames.held_out) paths.insert(paths.end(), frames.train.begin(), frames.train.end());
  MaskRule mask{scene.mask};
  list.attempt([&] { mask = load_mask_rule(scene, warnings); });
  if (mask.kind == "u2net" && !mask.segmenter) mask.kind = "auto";  // the frames can still be checked
  std::optional<bool> posed;
  for (const auto& path : paths)
    list.attempt([&] {
      const bool has_camera = load_frame(path, mask, posed).camera.has_value();
      if (!posed) posed = !has_camera;
    });
  frames.posed = posed.value_or(false);
  list.attempt([&] { require_one_scale(frames); });
}
}  // namespace tapestry::shell
