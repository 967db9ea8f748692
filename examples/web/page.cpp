// The page's side in C++: a car in streets, a detector, and a paint that is optimised so that the detector
// loses the car. It answers requests in JSON: in a browser those of worker.js, natively those of standard
// input, a line each. So both compute the same.
#include <iostream>
#include <nlohmann/json.hpp>
#include <tapestry/camouflage/training.hpp>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/raster/painted.hpp>

#include "../scenes/drawn_frames.hpp"
#include "../scenes/make_scene.hpp"
#include "../scenes/photograph.hpp"

namespace {
using namespace tapestry;
using Json = nlohmann::json;

constexpr std::array panel_names{"plain", "noise", "paint"};
constexpr double rad_per_deg = std::numbers::pi / 180;

/// The material to paint: body, else the one with the largest area, else all of a mesh without materials.
std::string material_to_paint(const geometry::Mesh& mesh) {
  std::vector<double> areas(mesh.materials.size());
  for (std::size_t face = 0; face < mesh.face_materials.size(); ++face) {
    if (mesh.face_materials[face] < 0) continue;
    const auto corner = [&](std::size_t i) {
      return mesh.positions[static_cast<std::size_t>(mesh.faces[face][i])];
    };
    areas[static_cast<std::size_t>(mesh.face_materials[face])] += geometry::length(
        geometry::cross(geometry::subtract(corner(1), corner(0)), geometry::subtract(corner(2), corner(0))));
  }
  std::string name;
  double largest = 0;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    if (mesh.materials[i].name == "body") return "body";
    if (areas[i] > largest) name = mesh.materials[i].name, largest = areas[i];
  }
  return name;
}

/// Reads a mesh and stands it on the ground, as long as a car if it is none of 2 to 20 m.
scenes::Vehicle read_vehicle(const std::string& path, const std::string& material) {
  auto mesh = io::read_obj(path).mesh;
  const auto axes = geometry::better_car_axes(mesh, {});
  mesh = geometry::turned_upright(std::move(mesh), axes.value_or(geometry::MeshAxes{}));
  const double length = 2 * geometry::bounds_of(mesh.positions).half_length();
  auto painted = material.empty() ? std::vector<std::uint8_t>(mesh.faces.size(), 1)
                                  : geometry::faces_by_material(mesh, {material});
  return scenes::stand_on_ground(std::move(mesh), std::move(painted), length < 2 || length > 20 ? 4.5 : 0);
}

/// The mesh with a texture as camouflage's by default, or with texels of each face where it has no uv.
raster::PaintedMesh painted_car(const scenes::Vehicle& vehicle, const std::string& material) {
  bool has_uvs = true;
  for (std::size_t face = 0; face < vehicle.painted.size(); ++face)
    has_uvs = has_uvs && (vehicle.painted[face] == 0 || (face < vehicle.mesh.face_uvs.size() &&
                                                         std::ranges::min(vehicle.mesh.face_uvs[face]) >= 0));
  raster::PaintChoice choice{.material = material, .filter = raster::TextureFilter::anisotropic};
  if (!has_uvs) choice = {.material = material, .kind = raster::TextureKind::cube, .rows = 6};
  return raster::painted(vehicle.mesh, choice);
}

/// The class that is the car: by its name, else COCO's, else the first.
std::size_t car_class(const detect::Detector<float>& detector) {
  for (std::size_t i = 0; i < detector.names().size(); ++i)
    if (detector.names()[i] == "car") return i;
  return detector.names().empty() && detector.heads().front().classes == 80 ? 2 : 0;
}

/// A picture of bytes, red, green, blue and opacity, as a canvas of the browser has them.
Array<float, 3> read_pixels(const std::string& path, std::size_t height, std::size_t width) {
  const auto bytes = io::read_file(path);
  if (bytes.size() != 4 * height * width) throw ShapeError({path, " has ", bytes.size(), " bytes"});
  Array<float, 3> picture(Extents<3>{height, width, 3});
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture.data()[i] = static_cast<float>(bytes[i / 3 * 4 + i % 3]) / 255;
  return picture;
}

/// One car, detector and place, and the paint.
class Workshop {
 public:
  /// \param request  files and settings, as worker.js sends them
  explicit Workshop(const Json& request)
      : seed_(request.value("seed", std::uint64_t{1})),
        detector_(io::read_detector<float>({.weights = request.at("weights"),
                                            .config = request.value("config", ""),
                                            .names = request.value("names", "")})),
        class_index_(car_class(detector_)),
        material_(material_to_paint(io::read_obj(request.at("car")).mesh)),
        vehicle_(read_vehicle(request.at("car"), material_)),
        car_(painted_car(vehicle_, material_)),
        whole_(evaluate::joined_chart(raster::texture_charts(car_), car_.layout)),
        store_(car_, store_settings(), loaders(request.value("views", std::size_t{240}))),
        objective_(
            detector_,
            {.kind = loss::AdversarialLoss::max_score, .printability = 0, .class_index = class_index_}),
        meter_(detector_, class_index_),
        parameter_(zeros<float, 2>({car_.layout.texel_count(car_.mesh), 3})) {
    objective_.keep_layers(std::size_t{256} << 20U);
    if (request.contains("picture"))
      photograph_ = image::resize_bilinear(
          read_pixels(request["picture"], request.at("height"), request.at("width")), height(), width());
  }

  Json load() const {
    return {{"views", store_.size()},
            {"height", height()},
            {"width", width()},
            {"faces", car_.mesh.faces.size()}};
  }

  /// Draws a view to optimise in.
  Json prepare(std::size_t index) {
    if (store_.view(index)->visible_pixels > 0) usable_.push_back(index);
    return Json::object();
  }

  Json step() {
    if (!training_) {
      camouflage::TrainingOptions options{.epochs = 100000, .batch = 8, .seed = seed_};
      options.adam.learning_rate = 0.1;
      training_.emplace(objective_, store_, usable_, parameter_, options);
    }
    const std::size_t images = training_->step();
    parameter_ = training_->parameter();
    const auto& terms = training_->history().back();
    return {{"step", training_->steps_taken()},
            {"images", images},
            {"loss", terms.total},
            {"score", terms.max_score}};
  }

  /// Chooses the view that see() shows.
  Json look(double heading_deg, double distance_m) {
    view_ = view_from(heading_deg, distance_m);
    return Json::object();
  }

  /// Draws the view in a paint, and looks for the car in it.
  Json see(std::size_t panel) {
    if (!view_) throw DomainError("look first");
    const auto picture = camouflage::picture_of(*view_, colours(panel));
    const auto result = meter_.examine(picture, *view_);
    const auto bytes = image::to_bytes(picture);
    auto& pixels = pixels_.at(panel);
    pixels.assign(bytes.size() / 3 * 4, 255);
    for (std::size_t i = 0; i < bytes.size(); ++i) pixels[i / 3 * 4 + i % 3] = bytes.data()[i];
    Json boxes = Json::array();
    for (const auto& [index, confidence, objectness, box, head, candidate] : result.detections) {
      const bool is_car = index == class_index_ && detect::iou(box, view_->target) >= 0.5;
      const auto& names = detector_.names();
      boxes.push_back({box.cx - box.w / 2, box.cy - box.h / 2, box.w, box.h, confidence, is_car,
                       index < names.size() ? names[index] : std::to_string(index)});
    }
    return {{"found", result.found}, {"confidence", result.best_confidence}, {"boxes", boxes}};
  }

  /// Whether the car is found from one of twelve sides, in each of the paints.
  Json side(std::size_t index, double distance_m) {
    if (sides_distance_ != distance_m) sides_ = {}, sides_distance_ = distance_m;
    auto& view = sides_.at(index);
    if (!view) view = view_from(30.0 * static_cast<double>(index), distance_m);
    Json found = Json::object();
    for (std::size_t panel = 0; panel < panel_names.size(); ++panel)
      found[panel_names[panel]] = meter_.examine(camouflage::picture_of(*view, colours(panel)), *view).found;
    return found;
  }

  /// Draws the noise anew, with the colours and the spectrum that the paint has now.
  Json match() {
    noise_ = evaluate::matched_noise(colours(2), {whole_}, Random(seed_));
    return Json::object();
  }

  /// SHA-256 of the paint, to compare runs.
  Json digest() const {
    return {{"sha256", io::sha256({reinterpret_cast<const char*>(parameter_.data()),
                                   parameter_.size() * sizeof(float)})}};
  }

  [[nodiscard]] const std::uint8_t* pixels(std::size_t panel) const { return pixels_.at(panel).data(); }

 private:
  using View = camouflage::View<float>;

  static constexpr double nearest_m = 6, farthest_m = 12, elevation_deg = 10, fov_deg = 55;
  static constexpr double camera_azimuth_rad =
      std::numbers::pi / 2;  // at the car's left, if it is not turned

  [[nodiscard]] std::size_t height() const { return detector_.input_height(); }
  [[nodiscard]] std::size_t width() const { return detector_.input_width(); }
  [[nodiscard]] double aspect() const { return static_cast<double>(width()) / static_cast<double>(height()); }

  [[nodiscard]] Array<float, 2> colours(std::size_t panel) const {
    if (panel == 0 || (panel == 1 && noise_.size() == 0)) return camouflage::own_colours<float>(car_);
    return panel == 1 ? noise_ : camouflage::texture_colours(parameter_);
  }

  [[nodiscard]] camouflage::ViewStore<float>::Settings store_settings() const {
    return {
        .height = height(), .width = width(), .keep_bytes = std::size_t{512} << 20U, .fit = detector_.fit()};
  }

  [[nodiscard]] std::vector<camouflage::ViewStore<float>::Loader> loaders(std::size_t count) const {
    std::vector<camouflage::ViewStore<float>::Loader> loaders;
    for (std::size_t i = 0; i < count; ++i)
      loaders.push_back([this, i, count] { return training_frame(i, count); });
    return loaders;
  }

  /// A street as those that camouflage draws by default.
  [[nodiscard]] scenes::SceneOptions street_options() const {
    scenes::SceneOptions options;
    options.vehicle = &vehicle_;
    for (std::size_t face = 0; face < vehicle_.painted.size() && !options.colour; ++face)
      if (vehicle_.painted[face] != 0) options.colour = geometry::material_colour(vehicle_.mesh, face);
    options.aspect = aspect();
    options.occluder_chance = 0;
    options.aim_jitter = 0;
    options.ground_contrast = 0.03;
    options.sensor_noise = 0;
    return options;
  }

  /// The place, in which the car turns and the camera comes nearer.
  [[nodiscard]] scenes::Scene scene_of(Random& random, double heading_rad, double distance_m) const {
    if (photograph_.size() > 0)
      return scenes::make_scene_in_photograph(
          random, photograph_, vehicle_,
          {.distance_m = {distance_m, distance_m}, .yaw_rad = {heading_rad, heading_rad}});
    auto options = street_options();
    options.heading_rad = heading_rad;
    options.azimuth_rad = {camera_azimuth_rad, camera_azimuth_rad};
    options.elevation_deg = {elevation_deg, elevation_deg};
    options.fov_deg = {fov_deg, fov_deg};
    options.distance_m = {farthest_m, farthest_m};  // so that nothing stands between
    auto scene = scenes::make_scene(random, options);
    scene.camera = geometry::orbit_camera(camera_azimuth_rad, elevation_deg * rad_per_deg, distance_m,
                                          {0, 0, options.aim_height_m}, fov_deg * rad_per_deg);
    scene.camera.tan_half_fov_y = scene.camera.tan_half_fov_x / aspect();
    return scene;
  }

  /// A view of the place, from farther away where the car would not lie in the picture as a whole.
  [[nodiscard]] io::Frame frame_from(double heading_rad, double distance_m) const {
    for (double distance = distance_m; distance < 3 * farthest_m; ++distance) {
      Random random = Random(seed_).fork(2);
      const auto make = [&](Random& numbers) { return scene_of(numbers, heading_rad, distance); };
      if (auto frame = scenes::find_frame(random, make, 0.01, 2, height(), width(), true, 1)) return *frame;
    }
    throw DomainError("the car lies in no picture as a whole");
  }

  /// A view to optimise in: all headings, at distances by chance.
  [[nodiscard]] io::Frame training_frame(std::size_t index, std::size_t count) const {
    Random random = Random(seed_).fork(1).fork(index);
    const double turns = (static_cast<double>(index) + random.uniform()) / static_cast<double>(count);
    return frame_from(2 * std::numbers::pi * turns, random.uniform(nearest_m, farthest_m));
  }

  [[nodiscard]] View view_from(double heading_deg, double distance_m) const {
    return camouflage::make_view<float>(frame_from(heading_deg * rad_per_deg, distance_m), car_, height(),
                                        width(), 2, detector_.fit());
  }

  std::uint64_t seed_;
  detect::Detector<float> detector_;
  std::size_t class_index_;
  std::string material_;
  scenes::Vehicle vehicle_;
  raster::PaintedMesh car_;
  raster::TextureChart whole_;
  Array<float, 3> photograph_{};
  camouflage::ViewStore<float> store_;
  camouflage::Objective<float> objective_;
  evaluate::Meter meter_;
  Array<float, 2> parameter_, noise_{};
  std::vector<std::size_t> usable_{};
  std::optional<camouflage::Training<float>> training_{};
  std::optional<View> view_{};
  std::array<std::optional<View>, 12> sides_{};
  double sides_distance_ = 0;
  std::array<std::vector<std::uint8_t>, panel_names.size()> pixels_{};
};

std::unique_ptr<Workshop> workshop;

Json answer_to(const Json& request) {
  const std::string what = request.at("do");
  if (what == "load") {
    workshop.reset();  // before its memory is needed again
    workshop = std::make_unique<Workshop>(request);
    return workshop->load();
  }
  if (!workshop) throw DomainError("load first");
  if (what == "prepare") return workshop->prepare(request.at("index"));
  if (what == "step") return workshop->step();
  if (what == "look") return workshop->look(request.at("heading"), request.at("distance"));
  if (what == "see") return workshop->see(request.at("panel"));
  if (what == "side") return workshop->side(request.at("index"), request.at("distance"));
  if (what == "match") return workshop->match();
  if (what == "digest") return workshop->digest();
  throw DomainError({"no request ", what});
}
}  // namespace

/// Answers a request; {"error": …} if it fails. The text lives until the next call.
extern "C" const char* answer(const char* request) {
  static std::string text;
  Json found;
  try {
    found = answer_to(Json::parse(request));
  } catch (const std::exception& error) {
    found = {{"error", error.what()}};
  }
  text = found.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.c_str();
}

/// Pixels of what see() drew last for a panel: red, green, blue and opacity, from the upper left.
extern "C" const std::uint8_t* pixels(std::size_t panel) { return workshop->pixels(panel); }

int main() {
  limit_threads(1);
#if !defined(__EMSCRIPTEN__)
  for (std::string line; std::getline(std::cin, line);) std::cout << answer(line.c_str()) << std::endl;
#endif
}
