// Puts any car into street scenes or photographs: frames to optimise on and frames held out.
#include <tapestry/io/obj_file.hpp>

#include "../scenes/drawn_frames.hpp"
#include "../scenes/make_scene.hpp"
#include "shell/dataset_preview.hpp"
#include "shell/mesh_axes.hpp"
#include "shell/mesh_inputs.hpp"
#include "shell/own_texture.hpp"
#include "shell/photographs.hpp"
#include "shell/program.hpp"
#include "shell/run_origin.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

struct Options {
  std::string mesh = BundledAssets().mesh();
  geometry::MeshAxes axes;
  std::string object = "car";
  std::vector<std::string> material;
  std::string faces;
  double length = 0;
  std::string output;
  std::size_t train = 200;
  std::size_t test = 50;
  std::size_t size = 416;
  std::pair<double, double> elevation{3, 35};
  std::vector<double> distance;
  std::pair<double, double> fov{50, 60};
  bool is_fov_given = false;
  double occluded = 0.25;
  bool one_street = false;
  std::string backgrounds;
  std::string format = "npz";
  double camera_height = 1.5;
  double camera_pitch = 0;
  std::uint64_t seed = 1;
  bool check = false;
};

void describe_car(CLI::App& app, Options& options) {
  app.add_option("--mesh", options.mesh,
                 "OBJ file of the car, with its own textures (map_Kd); the bundled sedan when left out")
      ->default_str("");
  app.add_option("--up", options.axes.up, up_help);
  app.add_option("--forward", options.axes.forward, forward_help);
  app.add_option("--object", options.object, object_help);
  app.add_option("--material", options.material, "materials whose faces take the car's colour");
  app.add_option("--faces", options.faces, "text file of those faces instead, one 1-based number a line");
  app.add_option("--length", options.length,
                 "metres of the longest side of the mesh; 0: its units are metres")
      ->check(CLI::Range(0.0, 20.0));
  app.add_option("--output", options.output,
                 "folder to write to; takes the folders train and test, and no other data set")
      ->required();
  app.add_option("--train", options.train, "frames to optimise on")->check(CLI::Range(0, 9999));
  app.add_option("--test", options.test, "frames held out")->check(CLI::Range(1, 9999));
  app.add_option("--format", options.format,
                 "of the frames: {npz}, or {png}: a picture with its mask and a JSON file of its camera");
  app.add_option("--size", options.size, "side of a frame, pixels")->check(CLI::Range(32, 2048));
}

void describe_views(CLI::App& app, Options& options) {
  app.add_option("--elevation", options.elevation,
                 "least and largest height of the camera above the horizon, degrees")
      ->check(CLI::Range(0.0, 85.0));
  app.add_option(
         "--distance", options.distance,
         "least and largest distance of the camera, metres; left out, the car is .25 to .75 of the picture")
      ->expected(2)
      ->check(CLI::Range(0.3, 200.0));
  app.add_option(
         "--fov", options.fov,
         "least and largest horizontal field of view, degrees; left out, by a photograph's EXIF, else "
         "50 to 60")
      ->check(CLI::Range(5.0, 120.0));
  app.add_option(
         "--occluded", options.occluded,
         "share of frames with an object in front of the car; none in front of what is shorter than 1 m")
      ->check(CLI::Range(0.0, 1.0));
  auto* const one_street = app.add_flag(
      "--one-street", options.one_street,
      "one street, light and camera in all frames of a part, in which the car turns once around; nothing "
      "stands in front of it");
  app.add_option("--backgrounds", options.backgrounds,
                 "folder of photographs (PNG, JPEG, BMP, PPM) on whose ground the car is put, instead of "
                 "streets; those of held-out frames are others than those of the rest, and of other places "
                 "if their names, without the digits at the end, tell places")
      ->excludes("--elevation")
      ->excludes("--occluded")
      ->excludes(one_street);
  app.add_option("--camera-height", options.camera_height,
                 "of the photographs' camera above the ground, metres")
      ->check(CLI::Range(0.1, 100.0))
      ->needs("--backgrounds");
  app.add_option("--camera-pitch", options.camera_pitch, "of the photographs' camera downwards, degrees")
      ->check(CLI::Range(-45.0, 85.0))
      ->needs("--backgrounds");
}

void describe(CLI::App& app, Options& options) {
  describe_car(app, options);
  describe_views(app, options);
  app.add_option("--seed", options.seed, "of the scenes");
  app.add_flag("--check", options.check, "only write preview.png, a sheet of twelve of the frames");
}

void require_ranges(const Options& options) {
  ProblemList list;
  require_axes(options.axes, options.object, list);
  list.require_choice("--format", options.format, {"npz", "png"});
  list.throw_first();
  const auto require = [](const char* name, double low, double high) {
    if (low > high)
      throw Error(ErrorKind::usage,
                  name + formatted(": %f is more than %f, expected the least first", low, high));
  };
  require("--elevation", options.elevation.first, options.elevation.second);
  require("--fov", options.fov.first, options.fov.second);
  if (!options.distance.empty()) require("--distance", options.distance[0], options.distance[1]);
}

constexpr double least_object_m = 0.2;  ///< length of the smallest object that is no car

scenes::Vehicle load_vehicle(const Options& options) {
  auto loaded = io::read_obj(options.mesh);
  auto warnings = loaded.warnings;
  const auto own = own_textures(loaded.mesh, warnings);
  const auto materials = options.material.empty() && options.mesh == BundledAssets().mesh()
                             ? std::vector<std::string>{"body"}
                             : options.material;
  auto painted = selected_faces(options.mesh, loaded.mesh, materials, options.faces, warnings);
  print_warnings(warnings);
  auto mesh = upright_object(options.mesh, std::move(loaded.mesh), options.axes, options.object);
  try {
    const double least_m = options.object == "any" ? least_object_m : 1;
    auto vehicle = scenes::stand_on_ground(std::move(mesh), std::move(painted), options.length, least_m);
    for (const OwnTexture& texture : own) scenes::add_texture(vehicle, texture.picture, texture.faces);
    return vehicle;
  } catch (const DomainError& error) {
    throw file_mismatch({options.mesh, "", error.what()});
  }
}

/// The index-th of `count` equal sectors of a turn, radians.
std::pair<double, double> sector(std::size_t index, std::size_t count) {
  const double step = 2 * std::numbers::pi / static_cast<double>(count);
  return {step * static_cast<double>(index), step * static_cast<double>(index + 1)};
}

/// The scene of a frame: views spread evenly around the car, everything else at random.
scenes::SceneOptions scene_options(const Options& options, const scenes::Vehicle& vehicle, std::size_t index,
                                   std::size_t count, Random& random) {
  scenes::SceneOptions scene;
  scene.vehicle = &vehicle;
  scene.azimuth_rad = sector(index, count);
  scene.elevation_deg = options.elevation;
  scene.fov_deg = options.fov;
  if (!options.distance.empty()) scene.distance_m = {options.distance[0], options.distance[1]};
  if (options.object == "any") {
    const auto bounds = geometry::bounds_of(vehicle.mesh.positions);
    scene.nearest_m = std::min(scene.nearest_m, std::max(2 * bounds.half_length(), 0.3));
    scene.aim_height_m = std::min(scene.aim_height_m, bounds.middle()[2]);
  }
  const bool is_occluded = random.chance(options.occluded) && !options.one_street;
  scene.occluder_chance = is_occluded && scene.nearest_m >= 1 ? 1 : 0;
  scene.sensor_noise = 0;
  if (options.one_street) {
    scene.heading_rad = scene.azimuth_rad.first;
    scene.azimuth_rad.first = scene.azimuth_rad.second = std::numbers::pi / 2;  // at its left, if not turned
    scene.fill = {0.5, 0.6};
    scene.ground_contrast = 0.03;  // as weak as in the bundled frames, so that a moving picture stays small
  }
  return scene;
}

/// The camera of a photograph, for a field of view that its EXIF replaces unless --fov is given.
scenes::PhotographOptions camera_of_photograph(const Options& options, const Photograph& source,
                                               double fov_deg) {
  scenes::PhotographOptions scene;
  scene.camera_height_m = options.camera_height;
  scene.pitch_deg = options.camera_pitch;
  scene.fov_deg = source.fov_deg > 0 && !options.is_fov_given ? source.fov_deg : fov_deg;
  if (!options.distance.empty()) scene.distance_m = {options.distance[0], options.distance[1]};
  return scene;
}

[[noreturn]] void refuse_photograph(const Options& options, const Photograph& source, double fov_deg,
                                    const std::string& what) {
  const bool is_by_exif = source.fov_deg > 0 && !options.is_fov_given;
  const std::string by_exif = "; by its EXIF it sees " + std::to_string(fov_deg) +
                              " degrees, which --distance fits to or --fov replaces";
  throw file_mismatch({source.path, "", what + (is_by_exif ? by_exif : "")});
}

/// \throws Error for a photograph that cannot be read, or that does not hold the whole car
void require_usable(const Options& options, const scenes::Vehicle& vehicle, const Photograph& source,
                    std::vector<std::string>& warnings) {
  const auto picture = io::read_image(source.path, &warnings);
  if (const auto word = word_on_kind(picture); !word.empty()) warnings.push_back(source.path + ": " + word);
  const auto scene = camera_of_photograph(options, source, options.fov.first);
  constexpr std::size_t least = 64;
  if (std::min(picture.shape(0), picture.shape(1)) < least)
    throw file_mismatch({source.path, "", "too small for a photograph",
                         "at least " + std::to_string(least) + " pixels a side",
                         std::to_string(picture.shape(1)) + " x " + std::to_string(picture.shape(0))});
  const double aspect = static_cast<double>(picture.shape(1)) / static_cast<double>(picture.shape(0));
  if (!scenes::shows_whole_vehicle(vehicle, scene, aspect))
    refuse_photograph(options, source, scene.fov_deg,
                      "the car does not lie in it as a whole from every side");
}

io::Frame frame_in_photograph(const Options& options, const scenes::Vehicle& vehicle,
                              const Photograph& source, std::size_t index, std::size_t count,
                              Random& random) {
  auto scene = camera_of_photograph(options, source, random.uniform(options.fov.first, options.fov.second));
  scene.yaw_rad = sector(index, count);
  std::vector<std::string> told_before;
  const auto photograph = scenes::resized_photograph(
      image::from_bytes<float>(io::read_image(source.path, &told_before)), options.size);
  const auto make = [&](Random& numbers) {
    return scenes::make_scene_in_photograph(numbers, photograph, vehicle, scene);
  };
  try {
    return scenes::make_frame(random, make, 0.97, 2, photograph.shape(0), photograph.shape(1));
  } catch (const DomainError& error) {
    refuse_photograph(options, source, scene.fov_deg, error.what());
  }
}

/// The options as words of the command line, without the folder that frames are written to.
Json settings_json(const CLI::App& app, const Options& options) {
  constexpr std::array unsaved{"output", "check", "quiet", "verbose"};
  Json settings{{"seed", options.seed}};
  for (const auto* option : app.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty() || !option->get_configurable()) continue;
    const std::string& name = option->get_lnames().front();
    if (settings.contains(name) || std::ranges::find(unsaved, name) != std::end(unsaved)) continue;
    std::string words;
    for (const auto& word : option->results()) words += (words.empty() ? "" : ",") + word;
    const std::string& by_default = option->get_default_str();
    if (words != by_default && "[" + words + "]" != by_default) settings[name] = words;
  }
  return settings;
}

/// Checks that a data set may be written to a folder. A folder with the same manifest holds an interrupted
/// data set, or one to draw again.
/// \throws Error (in_use) for a folder that holds anything but frames of this data set
void require_own_folder(const std::string& folder, const Json& manifest) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorKind::in_use, folder + " holds " + what + "; give another --output");
  };
  const std::string path = manifest_path(folder);
  if (is_there(path, ErrorKind::write)) {
    const Json saved = read_json_file(path);
    if (!saved.is_object() || saved.value("program", Json()) != "make_dataset") refuse("a run");
    const std::string differing = differences(saved, manifest);
    if (!differing.empty()) refuse("another data set: " + differing);
    return;
  }
  for (const char* part : {"", "/train", "/test"})
    if (is_folder(folder + part, ErrorKind::write) && !io::listed_paths(folder + part, [&](const auto& file) {
                                                         return *part == 0 ? file.extension() == ".npz"
                                                                           : is_frame_file(file);
                                                       }).empty())
      refuse("frames without the manifest of this data set");
}

class FrameDrawing {
 public:
  FrameDrawing(const Options& options, const scenes::Vehicle& vehicle, const PhotographShares& pictures)
      : options_(options), vehicle_(vehicle), pictures_(pictures) {
    for (const bool held_out : {false, true})
      if (options.one_street) streets_[held_out ? 1 : 0] = first_street(held_out);
  }

  [[nodiscard]] io::Frame operator()(const FramePlace& place) const {
    const auto [held_out, index] = place;
    const std::size_t count = count_of(held_out);
    Random random = numbers_of(held_out, options_.one_street ? streets_[held_out ? 1 : 0] : index);
    const auto& pictures = held_out ? pictures_.test : pictures_.train;
    io::Frame frame =
        pictures.empty() ? scenes::make_frame(random, scene_options(options_, vehicle_, index, count, random),
                                              options_.size)
                         : frame_in_photograph(options_, vehicle_, pictures[index % pictures.size()], index,
                                               count, random);
    frame.camera = scenes::camera_of_mesh(vehicle_, *frame.camera);
    return frame;
  }

 private:
  [[nodiscard]] std::size_t count_of(bool held_out) const {
    return held_out ? options_.test : options_.train;
  }
  [[nodiscard]] Random numbers_of(bool held_out, std::uint64_t scene) const {
    return Random(options_.seed).fork(held_out ? 12 : 11).fork(scene);
  }

  /// The first street in which the whole car shows whichever way it stands.
  /// \throws DomainError if of a hundred streets none will do
  [[nodiscard]] std::uint64_t first_street(bool held_out) const {
    const std::size_t count = count_of(held_out);
    for (std::uint64_t street = 0; street < 100; ++street) {
      std::atomic<std::size_t> shown = 0;
      parallel_for(count, [&](std::size_t index) {
        Random random = numbers_of(held_out, street);
        const auto scene = scene_options(options_, vehicle_, index, count, random);
        const auto make = [&](Random& numbers) { return scenes::make_scene(numbers, scene); };
        if (scenes::find_frame(random, make, 0.97, 2, options_.size, options_.size, true, 1)) ++shown;
      });
      if (shown == count) return street;
    }
    throw DomainError(
        "--one-street: of a hundred streets none shows the whole car from all around; let the "
        "camera stand farther away");
  }

  const Options& options_;
  const scenes::Vehicle& vehicle_;
  const PhotographShares& pictures_;
  std::array<std::uint64_t, 2> streets_{};  // to optimise on and held out
};

void write_frames(const Options& options, const FrameDrawing& draw, bool held_out) {
  const std::size_t count = held_out ? options.test : options.train;
  if (count == 0) return;
  make_writable_folder(options.output + (held_out ? "/test" : "/train"));
  parallel_for(count, [&](std::size_t index) {
    const FramePlace place{held_out, index};
    io::write_frame(options.output + "/" + place.name() + (options.format == "png" ? ".json" : ".npz"),
                    draw(place));
  });
}

/// Assumptions about the photographs' camera that no option states; empty if there are none.
std::string assumptions(const CLI::App& app, const Options& options, bool is_fov_known) {
  std::string what, names;
  const auto add = [&](const std::string& name, const std::string& words) {
    if (app.count(name) > 0) return;
    what += (what.empty() ? "" : ", ") + words;
    names += (names.empty() ? "" : ", ") + name;
  };
  add("--camera-height", formatted("height %g m", options.camera_height));
  add("--camera-pitch", formatted("pitch %g degrees", options.camera_pitch));
  if (!is_fov_known)
    add("--fov", formatted("field of view %g to %g degrees", options.fov.first, options.fov.second));
  return names.empty() ? "" : "assumed of the camera: " + what + "; set " + names + " to what is true";
}

/// Prints the preview's path, and how to check the photographs' camera by it.
void remark_preview(const CLI::App& app, const Options& options, const std::vector<Photograph>& pictures,
                    const std::string& path) {
  remark("preview: " + path);
  if (pictures.empty()) return;
  const auto without_fov = static_cast<std::size_t>(std::ranges::count(pictures, 0.0, &Photograph::fov_deg));
  if (!options.is_fov_given && without_fov < pictures.size())
    remark("field of view of " + std::to_string(pictures.size() - without_fov) + " of " +
           std::to_string(pictures.size()) + " photographs is by their EXIF");
  if (const auto assumed = assumptions(app, options, without_fov == 0); !assumed.empty()) remark(assumed);
  remark(
      "strength and colour of a frame's light are those of the ground around the car, taken for grey "
      "asphalt; the sun's direction and share are drawn at random");
  remark(
      "  its blue line is the horizon: if it lies below that of a photograph, raise --camera-pitch, if "
      "above, lower it;");
  remark("  if cars are too small for where they stand, lower --camera-height");
}

/// The command that optimises on the written frames, or measures in them if all are held out.
std::string next_command(const Options& options) {
  if (options.train == 0)
    return shell_line({"evaluate", "--frames", options.output, "--run", "run"}) +
           "    # a run of this car; there are no frames to optimise on";
  std::vector<std::string> words{"camouflage", "--frames", options.output};
  const auto add = [&](const std::string& name, const std::string& value, const std::string& left_out) {
    if (value != left_out) words.insert(words.end(), {name, value});
  };
  add("--mesh", options.mesh, BundledAssets().mesh());
  add("--up", options.axes.up, geometry::MeshAxes{}.up);
  add("--forward", options.axes.forward, geometry::MeshAxes{}.forward);
  add("--object", options.object, "car");
  add("--faces", options.faces, "");
  if (!options.material.empty()) words.push_back("--material");
  words.insert(words.end(), options.material.begin(), options.material.end());
  words.insert(words.end(), {"--output", "run"});
  return shell_line(words);
}

int make_dataset(const CLI::App& app, Options& options) {
  require_ranges(options);
  options.is_fov_given = app.count("--fov") > 0;
  if (!options.output.empty()) adopt_instruction_set(manifest_path(options.output));
  io::InputLedger ledger;
  ledger.leave_out(options.output);
  const scenes::Vehicle vehicle = load_vehicle(options);
  std::vector<std::string> warnings;
  const auto pictures = photographs(
      options.backgrounds,
      [&](const Photograph& photograph, std::vector<std::string>& words) {
        require_usable(options, vehicle, photograph, words);
      },
      warnings);
  print_warnings(warnings);
  Json manifest = make_manifest("make_dataset", settings_json(app, options), options.seed, options.train > 0);
  manifest["frames"] = {{"train", options.train}, {"test", options.test}};
  const RunFolder folder(options.output, !is_there(options.output, ErrorKind::write));
  require_own_folder(options.output, manifest);
  const PhotographShares shares = shares_of(pictures, options.train, options.test);
  const FrameDrawing draw(options, vehicle, shares);
  const std::string preview = options.output + "/preview.png";
  write_preview(preview, options.train, options.test, !pictures.empty(), draw);
  remark_preview(app, options, pictures, preview);
  if (!shares.train.empty())
    remark(std::to_string(shares.test.size()) + " of " + std::to_string(pictures.size()) +
           " photographs are held out, " +
           (shares.are_apart ? "of other places by their names"
                             : "of the same places as far as their names tell"));
  if (options.check) return 0;
  if (!is_there(manifest_path(options.output), ErrorKind::write))
    write_text(manifest_path(options.output), exact_text(manifest) + "\n");
  write_frames(options, draw, false);
  write_frames(options, draw, true);
  remark("wrote " + std::to_string(options.train) + " frames to optimise on and " +
         std::to_string(options.test) + " held out to " + options.output);
  remark("next: " + next_command(options));
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  auto app = command_line(
      "Draws street scenes around any car: frames to optimise a camouflage on, and frames held out. Every "
      "frame is a scene of its own, with its camera, light, mask and box.");
  Options options;
  describe(app, options);
  app.footer(
      "  make_dataset --output frames\n"
      "  make_dataset --mesh car.obj --material body --output frames --check\n"
      "  make_dataset --mesh car.obj --material body --output frames --train 200");
  return run_program(app, argc, argv, [&] { return make_dataset(app, options); });
}
