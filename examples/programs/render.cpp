// Draws a mesh, painted or in its own colours: one picture, or a turntable.
#include <tapestry/image/crop.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/npy.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/painted.hpp>

#include "../scenes/dark_parts.hpp"
#include "shell/mesh_axes.hpp"
#include "shell/mesh_inputs.hpp"
#include "shell/moving_picture.hpp"
#include "shell/own_texture.hpp"
#include "shell/panel_sheets.hpp"
#include "shell/program.hpp"
#include "shell/texture_description.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

constexpr double rad_per_deg = std::numbers::pi / 180;

struct Options {
  std::string mesh;
  geometry::MeshAxes axes;
  std::string object = "car";
  std::vector<std::string> material;
  std::string faces;
  std::string texture;
  std::vector<double> colour;
  std::string filter = "anisotropic";
  double u_extent = 0;
  std::string view = "colour";
  double azimuth = 45, elevation = 20, fov = 60;
  std::vector<double> distance;
  std::vector<double> target;
  std::string frame;
  std::vector<double> pose;
  bool normalise = false;
  std::size_t turntable = 0;
  double seconds = 0;
  std::vector<std::size_t> size{512};
  std::size_t samples = 4;
  std::vector<double> background{1, 1, 1};
  bool transparent = false;
  std::string lighting = "flat";
  std::string colour_space = "linear";
  bool ground = false;
  double ambient = 0.5, directional = 0.5;
  double coat = 0, roughness = 0.1;
  std::vector<double> light_direction{0, 0, 1};
  std::string output = "render.png";
  std::string exported;
  std::string panels;
  std::string paper = papers[0].name;
  double panel_scale = 1, length = 0;
};

void describe_scene(CLI::App& app, Options& o) {
  app.option_defaults()->group("Mesh and light");
  app.add_option("--mesh", o.mesh, "OBJ file; the bundled sedan when left out");
  app.add_option("--up", o.axes.up, up_help);
  app.add_option("--forward", o.axes.forward, forward_help);
  app.add_option("--object", o.object, object_help);
  app.add_option(
      "--material", o.material,
      "materials whose faces are painted; when this and --faces are left out, those of the texture's "
      "description, else all faces");
  app.add_option("--faces", o.faces,
                 "text file of painted faces, one 1-based number a line, instead of --material");
  app.add_option(
      "--texture", o.texture,
      "PNG that the uv of painted faces point into; the mesh's own textures (map_Kd) and colours when "
      "left out");
  app.add_option("--colour", o.colour, "one colour for painted faces, three numbers from 0 to 1")
      ->expected(3);
  app.add_option("--filter", o.filter, "of the texture: {bilinear}, {trilinear} or {anisotropic}");
  app.add_option("--u-extent", o.u_extent,
                 "the texture's width in u; 0: as its description says (x.json beside x.png), else 1");
  app.add_flag(
      "--normalise", o.normalise,
      "centre the mesh and scale it so that its longest side is 2, as poses of the simulator expect");
}

void describe_light(CLI::App& app, Options& o) {
  app.add_option("--light", o.lighting,
                 "{none}, {flat}, {smooth}, {sky} or {sun}: sky and sun are shaded by the mesh itself");
  app.add_flag("--ground", o.ground, "with --light sky or sun: the mesh's shadow on level ground below it");
  app.add_option(
      "--colour-space", o.colour_space,
      "how colours are lit, filtered and blended: {linear}, in proportion to light as a camera and a "
      "glTF viewer do, or {encoded}, by the numbers of the picture");
  app.add_option("--ambient", o.ambient, "light from everywhere");
  app.add_option("--directional", o.directional, "light from one direction");
  app.add_option("--light-direction", o.light_direction, "towards the light, z up")->expected(3);
  app.add_option(
      "--clear-coat", o.coat,
      "share of the surface under a clear coat that mirrors the light, 0 to 1; not part of --export");
  app.add_option("--roughness", o.roughness, "of the clear coat, 0.01 (a mirror) to 1 (matt)");
}

void describe(CLI::App& app, Options& o) {
  describe_scene(app, o);
  describe_light(app, o);
  app.option_defaults()->group("Camera and picture");
  app.add_option("--view", o.view, "{colour}, {normal}, {uv}, {face}, {depth}, {position} or {coverage}");
  app.add_option("--azimuth", o.azimuth, "degrees around the mesh; 0: in front of a car, 90: at its left");
  app.add_option("--elevation", o.elevation, "degrees above the horizon");
  app.add_option(
      "--distance", o.distance,
      "from the target, in units of the mesh; the whole mesh shows when left out. With --turntable "
      "several, one row each");
  app.add_option("--target", o.target, "point in the middle of the picture; left out, the mesh's middle")
      ->expected(3);
  app.add_option("--fov", o.fov, "field of view across, degrees");
  app.add_option("--frame", o.frame,
                 "frame (.npz) whose camera is used; one with a simulator's pose implies --normalise");
  app.add_option("--pose", o.pose,
                 "12 numbers: the rows of view_from_world [R | t], x to the right, y down, z forward")
      ->expected(12);
  app.add_option("--turntable", o.turntable, "views all around, on one sheet, instead of one picture");
  app.add_option(
      "--seconds", o.seconds,
      "of a turn: --turntable writes a moving picture (an animated PNG) instead of a sheet; its first "
      "view is the picture of programs that know none");
  app.add_option("--size", o.size, "pixels a side, or width and height")->expected(1, 2);
  app.add_option("--samples", o.samples,
                 "samples a pixel along each axis: 1, 2, 4 or 8; 0: by the length of the mesh's edges");
  app.add_option("--background", o.background, "colour behind the mesh, three numbers from 0 to 1")
      ->expected(3);
  app.add_flag("--transparent", o.transparent,
               "no background: the mesh's coverage as straight opacity (an RGBA PNG)");
  add_threads_option(app);
  app.add_option("--output", o.output,
                 "PNG to write; an older one is replaced. NAME.npy holds a depth, position or normal in the "
                 "units of the mesh as floats, 0 where it does not show");
  app.add_option("--export", o.exported,
                 "also write the painted mesh: NAME.glb, or NAME.obj with NAME.mtl and NAME.png");
}

void describe_panels(CLI::App& app, Options& o) {
  app.option_defaults()->group("Print");
  app.add_option(
      "--panels", o.panels,
      "PDF to write: the painted faces laid flat at true size, in panels that keep lengths, to print, "
      "cut out and put on the car");
  app.add_option("--length", o.length, "metres of the longest side of the mesh; 0: its units are metres");
  app.add_option("--panel-scale", o.panel_scale, "1: full size, 0.0556: a model of 1:18");
  app.add_option("--paper", o.paper, "{a4}, {a3}, {a0} or {letter}; larger panels are cut into tiles");
}

void require_colour(const char* option, const std::vector<double>& colour, ProblemList& list) {
  for (const double channel : colour)
    list.require(channel >= 0 && channel <= 1, std::string(option) + " takes numbers from 0 to 1");
}

void require_sound_camera(const Options& o, ProblemList& list) {
  list.require(o.fov > 0 && o.fov < 180, "--fov lies between 0 and 180 degrees");
  list.require(o.elevation >= -90 && o.elevation <= 90, "--elevation lies in -90 to 90 degrees");
  for (const double distance : o.distance) list.require(distance > 0, "--distance must be above 0");
  list.require(o.distance.size() < 2 || o.turntable > 0, "several --distance need --turntable");
  list.require(o.turntable <= 360, "--turntable must be at most 360");
  list.require(o.seconds == 0 || o.turntable > 0, "--seconds needs --turntable");
  const double shown = o.seconds / static_cast<double>(std::max<std::size_t>(o.turntable, 1));
  list.require(o.seconds == 0 || (shown >= 0.01 && shown <= 60),
               "--seconds gives each view " + formatted("%g", shown) + " s; expected 0.01 to 60");
  list.require(!o.transparent || o.turntable == 0 || o.seconds > 0,
               "--transparent with --turntable needs --seconds");
  const bool is_posed = !o.frame.empty() || !o.pose.empty();
  list.require(o.frame.empty() || o.pose.empty(), "--frame and --pose cannot be given together");
  list.require(!is_posed || (o.turntable == 0 && o.distance.empty() && o.target.empty()),
               "--frame and --pose set the camera; leave out --distance, --target and --turntable");
}

/// Requires that no output file is read or written twice: the files beside an exported OBJ must not overwrite
/// an input, nor its texture the picture.
void require_exported_files(const Options& o, const std::vector<std::string>& inputs, bool has_texture,
                            ProblemList& list) {
  const std::string stem = o.exported.substr(0, o.exported.size() - 4);
  for (const char* end : {".mtl", ".png"}) list.require_kept("--export", stem + end, inputs);
  list.require(!has_texture || place_of(stem + ".png") != place_of(o.output),
               "--export writes the texture to " + stem + ".png, which is --output");
}

void require_sound_files(const Options& o, ProblemList& list) {
  const std::vector<std::string> inputs{o.mesh, o.texture, o.faces, o.frame};
  const bool is_measured = o.turntable == 0 && std::ranges::count(measured_view_names, o.view) > 0;
  list.require(o.output.ends_with(".png") || (o.output.ends_with(".npy") && is_measured),
               "--output takes a name that ends with .png, or with .npy for one --view depth, position or "
               "normal");
  list.require(!o.transparent || o.output.ends_with(".png"),
               "--transparent needs an --output that ends with .png");
  list.require_kept("--output", o.output, inputs);
  if (o.exported.empty()) return;
  const bool is_obj = o.exported.ends_with(".obj");
  list.require(!is_obj || printable(o.exported) == o.exported,
               "--export: control character in a name that the OBJ would hold");
  list.require(is_obj || o.exported.ends_with(".glb"), "--export takes a name that ends with .glb or .obj");
  list.require_kept("--export", o.exported, inputs);
  if (is_obj && !o.texture.empty()) require_exported_files(o, inputs, true, list);
}

void require_sound_panels(const Options& o, ProblemList& list) {
  list.require_choice("--paper", o.paper, names_of(papers));
  list.require(o.panel_scale > 0 && o.panel_scale <= 10, "--panel-scale must be above 0 and at most 10");
  list.require(o.length >= 0 && o.length <= 20, "--length lies in 0 to 20 metres");
  if (o.panels.empty()) return;
  list.require(o.panels.ends_with(".pdf"), "--panels takes a name that ends with .pdf");
  list.require_kept("--panels", o.panels, {o.mesh, o.texture, o.faces, o.frame});
  list.require(o.length > 0 || (!o.normalise && o.frame.empty()),
               "--panels of a mesh in the simulator's units needs --length");
}

void require_sound_light(const Options& o, ProblemList& list) {
  list.require_choice("--light", o.lighting, lighting_names);
  list.require(!o.ground || is_outdoors(o.lighting), "--ground needs --light sky or sun");
  list.require_choice("--colour-space", o.colour_space, names_of(image::colour_spaces));
  list.require(o.ambient >= 0 && std::isfinite(o.ambient), "--ambient must be a number from 0 on");
  list.require(o.directional >= 0 && std::isfinite(o.directional),
               "--directional must be a number from 0 on");
  list.require(o.coat >= 0 && o.coat <= 1, "--clear-coat lies in 0 to 1");
  list.require(o.coat == 0 || o.lighting != "none", "--clear-coat needs a light; leave out --light none");
  list.require(o.roughness >= 0.01 && o.roughness <= 1, "--roughness lies in 0.01 to 1");
  const double length = tapestry::hypot(o.light_direction[0], o.light_direction[1], o.light_direction[2]);
  list.require(length > 0 && std::isfinite(length), "--light-direction takes three numbers, not all 0");
}

void require_sound(const Options& o) {
  ProblemList list;
  require_axes(o.axes, o.object, list);
  require_sound_files(o, list);
  require_sound_panels(o, list);
  require_sound_light(o, list);
  list.require_choice("--view", o.view, mesh_view_names);
  list.require_choice("--filter", o.filter, names_of(raster::texture_filters));
  list.require(o.samples == 0 || o.samples == 1 || o.samples == 2 || o.samples == 4 || o.samples == 8,
               "--samples is " + std::to_string(o.samples) + "; expected 0, 1, 2, 4 or 8");
  for (const std::size_t side : o.size)
    list.require(side >= 1 && side * std::max<std::size_t>(o.samples, 1) <= 32768,
                 "--size must be 1 to " + std::to_string(32768 / std::max<std::size_t>(o.samples, 1)) +
                     " pixels at this many samples");
  list.require(o.faces.empty() || o.material.empty(), "--faces and --material cannot be given together");
  list.require(o.texture.empty() || o.colour.empty(), "--texture and --colour cannot be given together");
  list.require(o.u_extent >= 0 && o.u_extent <= 1e6, "--u-extent lies in 0 to 1e6");
  require_colour("--colour", o.colour, list);
  require_colour("--background", o.background, list);
  require_sound_camera(o, list);
  list.throw_first();
}

void set_atlas(const Options& o, const Bitmap& bitmap, PaintedScene& scene) {
  const auto picture = image::from_bytes<float>(bitmap);
  scene.layout.height = picture.shape(0);
  scene.layout.width = picture.shape(1);
  scene.layout.filter = raster::texture_filter_by_name(o.filter);
  scene.pyramid = raster::pyramid_of(scene);
  scene.texels = Array<float, 2>(Extents<2>{picture.shape(0) * picture.shape(1), 3});
  std::copy_n(picture.data(), picture.size(), scene.texels.data());
}

/// A texture that an option names, and its description; neither without the option.
struct GivenTexture {
  std::optional<Bitmap> picture{};
  std::optional<Json> description{};
};

/// Takes what the description of the texture says and no option does; says what is assumed without one.
GivenTexture given_texture(const CLI::App& app, Options& o, std::vector<std::string>& warnings) {
  if (o.texture.empty()) return {};
  GivenTexture given{io::read_texture(o.texture, &warnings)};
  given.description = read_texture_description(o.texture, {given.picture->shape(0), given.picture->shape(1)});
  if (!given.description) {
    if (o.u_extent == 0)
      remark(o.texture + ": no description beside it; assumed: its width is 1 in u (--u-extent), " +
             o.filter + " lookup, " + o.colour_space + " colours");
    return given;
  }
  const auto& described = *given.description;
  const auto adopt = [&](const char* name, const char* option, std::string& value) {
    if (app.count(option) == 0) value = described[name].get<std::string>();
  };
  adopt("filter", "--filter", o.filter);
  adopt("colour_space", "--colour-space", o.colour_space);
  adopt("up", "--up", o.axes.up);
  adopt("forward", "--forward", o.axes.forward);
  if (o.u_extent == 0) o.u_extent = described["u_extent"].get<double>();
  if (const auto& painted = described["painted"];
      o.material.empty() && o.faces.empty() && painted.contains("materials"))
    o.material = painted["materials"].get<std::vector<std::string>>();
  return given;
}

/// \throws FileError (mismatch) for a texture on charts of the faces, unless the mesh has the material that
/// is
///         exported with them
void require_own_charts(const Options& o, const Json& described, const geometry::Mesh& mesh) {
  if (described.value("charts", Json()) != "of the faces" || !described["painted"].contains("materials"))
    return;
  for (const Json& name : described["painted"]["materials"])
    if (std::ranges::find(mesh.materials, name.get<std::string>(), &geometry::Material::name) ==
        mesh.materials.end())
      throw file_mismatch(
          {o.mesh, "",
           o.texture + ", of a run with --texture cube, lies on the mesh that the run wrote beside it, "
                       "not on the uv of this one",
           "--mesh " + io::path_of(o.texture).replace_filename("painted.obj").string(), ""});
}

/// \throws FileError (mismatch) unless mesh and options are those that the texture's description names
void require_described(const Options& o, const PaintedScene& scene, const Json& described,
                       std::vector<std::string>& warnings) {
  raster::PaintedMesh expected = scene;
  expected.layout.u_extent = raster::u_extent_of(scene);
  expected.space = image::colour_space_by_name(o.colour_space);
  Json json = description_of(expected, painted_part(o.material, o.faces, scene.painted), o.axes);
  if (has_face_charts(scene.mesh, scene.painted)) json["charts"] = described.value("charts", Json());
  const std::string path = description_path(o.texture);
  if (const auto word = require_same_layout(path, described, json); !word.empty()) warnings.push_back(word);
  if (o.u_extent != json["u_extent"].get<double>())
    throw file_mismatch(
        {path, "", "--u-extent is of another layout", json["u_extent"].dump(), Json(o.u_extent).dump()});
}

/// \param own  of the mesh
void set_texture(const Options& o, const GivenTexture& given, const std::vector<OwnTexture>& own,
                 PaintedScene& scene, std::vector<std::string>& warnings) {
  scene.layout.u_extent = o.u_extent > 0 ? o.u_extent : 1;
  if (given.picture) {
    require_uvs(o.mesh, scene.mesh, scene.painted, "--texture");
    set_atlas(o, *given.picture, scene);
    if (given.description) require_described(o, scene, *given.description, warnings);
    return;
  }
  if (o.colour.empty() && !own.empty()) {  // the first one is drawn like a paint, so that it can be printed
    scene.painted = own.front().faces;
    return set_atlas(o, own.front().picture, scene);
  }
  const auto& colours = scene.mesh.vertex_colours;
  if (o.colour.empty() && !colours.empty()) {
    scene.layout = raster::vertex_layout;
    scene.texels = Array<float, 2>(Extents<2>{colours.size(), 3});
    for (std::size_t i = 0; i < colours.size(); ++i) std::ranges::copy(colours[i], &scene.texels(i, 0));
    return;
  }
  scene.layout = raster::solid_layout;
  scene.texels = zeros<float, 2>({1, 3});
  if (o.colour.empty()) std::fill(scene.painted.begin(), scene.painted.end(), std::uint8_t{0});
  for (std::size_t c = 0; c < o.colour.size(); ++c) scene.texels(0, c) = static_cast<float>(o.colour[c]);
}

void require_kept(const Options& o, const io::LoadedMesh& loaded) {
  auto inputs = loaded.material_files;
  for (const auto& material : loaded.mesh.materials)
    if (!material.texture.empty()) inputs.push_back(material.texture);
  ProblemList list;
  list.require_kept("--output", o.output, inputs);
  list.require_kept("--panels", o.panels, inputs);
  const bool has_texture = inputs.size() > loaded.material_files.size() && o.colour.empty();
  if (o.exported.ends_with(".obj")) {
    require_exported_files(o, inputs, has_texture, list);
    for (std::size_t i = 1; i <= loaded.mesh.materials.size(); ++i)
      list.require_kept(
          "--export", o.exported.substr(0, o.exported.size() - 4) + "-" + std::to_string(i) + ".png", inputs);
  }
  list.throw_first();
}

PaintedScene load_scene(const CLI::App& app, Options& o, bool is_normalised) {
  if (o.mesh.empty()) o.mesh = BundledAssets{}.mesh();
  auto loaded = io::read_obj(o.mesh);
  const GivenTexture texture = given_texture(app, o, loaded.warnings);
  PaintedScene scene;
  scene.painted.assign(loaded.mesh.faces.size(), 1);
  if (texture.description) require_own_charts(o, *texture.description, loaded.mesh);
  if (!o.material.empty() || !o.faces.empty())
    scene.painted = selected_faces(o.mesh, loaded.mesh, o.material, o.faces, loaded.warnings);
  require_kept(o, loaded);
  const auto own = own_textures(loaded.mesh, loaded.warnings);
  scene.mesh = upright_object(o.mesh, scenes::with_dark_parts(std::move(loaded.mesh), scene.painted), o.axes,
                              o.object);
  if (is_normalised) scene.mesh = geometry::normalise_mesh(std::move(scene.mesh));
  set_texture(o, texture, own, scene, loaded.warnings);
  print_warnings(loaded.warnings);
  scene.space = image::colour_space_by_name(o.colour_space);
  scene.pictures = pictures_of(own, scene.mesh, raster::texture_filter_by_name(o.filter), scene.space,
                               o.texture.empty() && o.colour.empty() ? 1 : 0);
  scene.lighting = o.lighting;
  scene.light.ambient = o.ambient;
  scene.light.directional = o.directional;
  scene.coat = o.coat;
  scene.roughness = o.roughness;
  for (std::size_t axis = 0; axis < 3; ++axis) scene.light.direction[axis] = o.light_direction[axis];
  if (is_outdoors(o.lighting)) scene.outdoors = outdoor_light(scene);
  if (o.ground)
    scene.ground = std::make_shared<const raster::GroundShade>(
        scene.mesh, raster::Ground{geometry::bounds_of(scene.mesh.positions).low[2]});
  return scene;
}

/// Position of the camera if neither a frame nor a pose is given.
struct OrbitSettings {
  geometry::Vector3 centre;  ///< the middle of the mesh's box
  double radius;             ///< of the ball around it that holds the mesh
  geometry::Vector3 target;
  double fov_rad;
  double aspect;  ///< height over width

  [[nodiscard]] double whole_distance() const {
    const double across = std::min(fov_rad / 2, std::atan(std::tan(fov_rad / 2) * aspect));
    return 1.02 * radius / std::sin(across);
  }

  [[nodiscard]] geometry::Camera camera(double azimuth_deg, double elevation_deg, double distance) const {
    auto camera = geometry::orbit_camera(azimuth_deg * rad_per_deg, elevation_deg * rad_per_deg, distance,
                                         target, fov_rad);
    camera.tan_half_fov_y = camera.tan_half_fov_x * aspect;
    const double reach = distance + geometry::length(geometry::subtract(target, centre)) + radius;
    camera.far = 2 * reach;
    camera.near = std::min(1e-4 * reach, 0.01 * distance);
    return camera;
  }
};

OrbitSettings orbit_settings(const Options& o, const geometry::Mesh& mesh, const PictureSettings& picture) {
  const auto bounds = geometry::bounds_of(mesh.positions);
  const double radius = geometry::length(geometry::subtract(bounds.high, bounds.low)) / 2;
  const auto target =
      o.target.empty() ? bounds.middle() : geometry::Vector3{o.target[0], o.target[1], o.target[2]};
  return {bounds.middle(), radius > 0 ? radius : 1, target, o.fov * rad_per_deg,
          static_cast<double>(picture.height) / static_cast<double>(picture.width)};
}

geometry::Camera camera_of_pose(const Options& o, const PictureSettings& picture) {
  geometry::Camera camera;
  for (std::size_t row = 0; row < 3; ++row) {
    std::copy_n(&o.pose[4 * row], 3, camera.rotation[row].begin());
    camera.translation[row] = o.pose[4 * row + 3];
  }
  camera.tan_half_fov_x = std::tan(o.fov * rad_per_deg / 2);
  camera.tan_half_fov_y =
      camera.tan_half_fov_x * static_cast<double>(picture.height) / static_cast<double>(picture.width);
  if (!geometry::is_orthonormal(camera.rotation, 1e-3))
    throw Error(ErrorKind::usage, "--pose holds no rotation; expected three orthonormal rows [R | t]");
  return camera;
}

/// The pictures to draw, and the number of pictures in a row of the sheet.
struct Shots {
  std::vector<geometry::Camera> cameras;
  std::size_t columns = 1;
  std::vector<std::string> labels{};  ///< of a turntable: where each is seen from
};

/// Columns of a turntable's sheet: 3 to 8 with as few empty cells as can be, then nearest to half as many
/// again as rows.
std::size_t turntable_columns(std::size_t views) {
  const double good = std::sqrt(1.5 * static_cast<double>(views));
  const auto rank = [&](std::size_t columns) {
    return std::pair((columns - views % columns) % columns, std::abs(static_cast<double>(columns) - good));
  };
  std::size_t best = 3;
  for (std::size_t columns = 4; columns <= 8; ++columns)
    if (rank(columns) < rank(best)) best = columns;
  return std::min(best, views);
}

Shots shots_of(const Options& o, const PaintedScene& scene, const io::Frame& frame,
               const PictureSettings& picture) {
  if (!o.frame.empty()) return {{io::camera_of(frame)}};
  if (!o.pose.empty()) return {{camera_of_pose(o, picture)}};
  const auto orbit = orbit_settings(o, scene.mesh, picture);
  const auto distances = o.distance.empty() ? std::vector<double>{orbit.whole_distance()} : o.distance;
  if (o.turntable == 0) return {{orbit.camera(o.azimuth, o.elevation, distances[0])}};
  Shots shots{{}, distances.size() > 1 ? o.turntable : turntable_columns(o.turntable)};
  for (const double distance : distances) {
    for (std::size_t i = 0; i < o.turntable; ++i) {
      const double turn = 360 * static_cast<double>(i) / static_cast<double>(o.turntable);
      shots.cameras.push_back(orbit.camera(o.azimuth + turn, o.elevation, distance));
      shots.labels.push_back(
          formatted("azimuth %g, elevation %g", std::fmod(o.azimuth + turn + 360, 360), o.elevation));
    }
  }
  return shots;
}

/// Paint of one colour becomes a material, so that no texture and no uv are needed.
void export_scene(const std::string& path, const PaintedScene& scene) {
  const bool is_glb = path.ends_with(".glb");
  if (scene.layout.traits().is_picture) {
    Array<float, 3> texture(Extents<3>{scene.layout.height, scene.layout.width, 3});
    std::copy_n(scene.texels.data(), scene.texels.size(), texture.data());
    const auto write = is_glb ? io::write_painted_glb<float> : io::write_painted_obj<float>;
    write(path, scene, texture);
    return;
  }
  geometry::Mesh mesh = scene.mesh;
  if (!scene.layout.traits().is_one_colour) return (is_glb ? io::write_glb : io::write_obj)(path, mesh);
  mesh.face_materials.resize(mesh.faces.size(), -1);
  const auto paint = static_cast<std::int32_t>(mesh.materials.size());
  if (std::ranges::any_of(scene.painted, [](std::uint8_t is_painted) { return is_painted != 0; }))
    mesh.materials.push_back({io::unused_material_name(mesh, "paint"),
                              {scene.texels(0, 0), scene.texels(0, 1), scene.texels(0, 2)}});
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    if (scene.painted[face] != 0) mesh.face_materials[face] = paint;
  (is_glb ? io::write_glb : io::write_obj)(path, mesh);
}

/// The pixel nearest to the mean place of some; at least one.
std::size_t middle_of(const std::vector<std::size_t>& pixels, std::size_t width) {
  double x = 0, y = 0;
  for (const std::size_t pixel : pixels) {
    x += static_cast<double>(pixel % width) / static_cast<double>(pixels.size());
    y += static_cast<double>(pixel / width) / static_cast<double>(pixels.size());
  }
  return *std::ranges::min_element(pixels, {}, [&](std::size_t pixel) {
    return std::hypot(static_cast<double>(pixel % width) - x, static_cast<double>(pixel / width) - y);
  });
}

/// \throws FileError (mismatch) unless the mesh is as long as a car, and has a texture
PanelSettings panel_settings(const Options& o, const PaintedScene& scene) {
  if (!scene.layout.traits().is_picture)
    throw file_mismatch({o.mesh, "", "no texture of its own; --panels needs --texture"});
  PanelSettings settings{o.panels, io::path_of(o.mesh).filename().string()};
  settings.paper = *std::ranges::find(papers, o.paper, [](const Paper& paper) { return name_of(paper); });
  settings.scale = o.panel_scale;
  const double longest = 2 * geometry::bounds_of(scene.mesh.positions).half_length();
  if (o.length > 0) settings.metres_per_unit = o.length / longest;
  const double metres = longest * settings.metres_per_unit;
  if (!(longest > 0 && metres >= 1 && metres <= 20))
    throw file_mismatch({o.mesh, "",
                         "the mesh is " + std::to_string(longest > 0 ? metres : 0) +
                             " m long, expected 1 to 20; --length sets its metres"});
  return settings;
}

/// The car from one side, with the numbers of the panels where most of each shows.
CarView car_view(const PaintedScene& scene, const std::vector<std::int32_t>& panel_of_face, double azimuth,
                 double elevation) {
  const PictureSettings picture{640, 1152, 2, {1, 1, 1}};
  const auto orbit = orbit_settings(Options{}, scene.mesh, picture);
  const auto camera = orbit.camera(azimuth, elevation, 0.85 * orbit.whole_distance());
  const auto buffer = raster::visibility(scene.mesh, camera, picture.height, picture.width, 1);
  std::map<std::int32_t, std::vector<std::size_t>> pixels;
  std::array<std::size_t, 2> low{picture.height, picture.width}, high{};  // rows and columns of the car
  for (const auto& fragment : raster::fragments(buffer, scene.mesh, camera)) {
    const std::array at{fragment.pixel / picture.width, fragment.pixel % picture.width};
    for (const std::size_t axis : {0U, 1U}) {
      low[axis] = std::min(low[axis], at[axis]);
      high[axis] = std::max(high[axis], at[axis] + 1);
    }
    if (const auto panel = panel_of_face[static_cast<std::size_t>(fragment.face)]; panel >= 0)
      pixels[panel].push_back(fragment.pixel);
  }
  if (low[0] >= high[0]) low = {}, high = {picture.height, picture.width};  // edge-on: nothing shows
  const image::PixelWindow car{low[0], low[1], high[0] - low[0], high[1] - low[1]};
  CarView view{image::to_bytes(image::crop(mesh_view("colour", scene, camera, picture), car))};
  for (auto& [panel, seen] : pixels) {
    if (seen.size() < 100) continue;  // hidden, or too small for a number
    const std::size_t middle = middle_of(seen, picture.width);
    const auto share = [](std::size_t at, std::size_t from, std::size_t extent) {
      return (static_cast<double>(at - from) + 0.5) / static_cast<double>(extent);
    };
    view.labels.push_back({static_cast<std::size_t>(panel),
                           share(middle % picture.width, car.left, car.width),
                           share(middle / picture.width, car.top, car.height), seen.size()});
  }
  return view;
}

/// The shares of the painted area that are on no panel, by material; empty if there are none.
std::string word_on_left_out(const PaintedScene& scene, const std::vector<std::int32_t>& panel_of_face) {
  double all = 0;
  std::map<std::string, double> left_out;
  for (std::size_t face = 0; face < panel_of_face.size(); ++face) {
    const double area = scene.painted[face] == 0 ? 0 : shell::detail::own_plane(scene.mesh, face).area;
    const std::int32_t material = scene.mesh.face_materials[face];
    all += area;
    if (scene.painted[face] != 0 && panel_of_face[face] < 0)
      left_out[material < 0 ? "no material" : scene.mesh.materials[std::size_t(material)].name] += area;
  }
  std::string text;
  for (const auto& [name, area] : left_out)
    text += (text.empty() ? ": " : ", ") + formatted("%.2g %% of the paint in ", 100 * area / all) + name;
  return text;
}

/// \returns a description of the file written
std::string write_panels(const Options& o, const PaintedScene& scene) {
  PanelSheets sheets(scene, panel_settings(o, scene));
  const auto panel_of_face = sheets.panel_of_faces(scene.mesh.faces.size());
  std::vector<CarView> views;
  for (const auto& [azimuth, elevation] : {std::pair(0, 10), std::pair(90, 10), std::pair(40, 40),
                                           std::pair(180, 10), std::pair(270, 10), std::pair(90, 89)})
    views.push_back(car_view(scene, panel_of_face, azimuth, elevation));
  std::map<std::size_t, std::size_t> best;  // pixels of a panel in the view that shows most of it
  for (const auto& view : views)
    for (const auto& label : view.labels) best[label.panel] = std::max(best[label.panel], label.pixels);
  constexpr std::size_t plain = 800;
  for (auto& view : views)
    std::erase_if(view.labels, [&](const CarView::Label& label) {
      return label.pixels < std::min(plain, best[label.panel]);
    });
  const std::string file = sheets.drawn(views);
  io::write_file_atomically(o.panels, std::string_view(file));
  return sheets.summary() + word_on_left_out(scene, panel_of_face);
}

/// Writes a label at the lower left, if there is room for it.
void write_label(const std::string& label, Bitmap& picture) {
  const long scale = std::max(1L, static_cast<long>(picture.shape(1)) / 400), margin = 2 * scale;
  const long top = static_cast<long>(picture.shape(0)) - glyph_height * scale - margin;
  if (top < 0 || text_width(label, scale) + 2 * margin > static_cast<long>(picture.shape(1))) return;
  const std::uint8_t* const behind =
      &picture(static_cast<std::size_t>(top), static_cast<std::size_t>(margin), 0);
  draw_text(picture, margin, top, label, scale, text_colour_on({behind[0], behind[1], behind[2]}));
}

/// \returns a description of the files written
std::string write_view(const Options& o, const PaintedScene& scene, const Shots& shots,
                       const PictureSettings& picture) {
  if (o.output.ends_with(".npy")) {
    const auto measured = measured_view(o.view, scene, shots.cameras.front(), picture);
    io::write_file_atomically(o.output,
                              io::npy_bytes<float>(std::span(measured.shape), std::span(measured.values)));
    return std::to_string(picture.width) + " x " + std::to_string(picture.height) + " pixels, " + o.view;
  }
  std::vector<Bitmap> bitmaps;
  const bool is_sheet = o.turntable > 0 && o.seconds == 0;
  for (std::size_t i = 0; i < shots.cameras.size(); ++i) {
    const auto& camera = shots.cameras[i];
    bitmaps.push_back(o.transparent ? transparent_view(o.view, scene, camera, picture)
                                    : image::to_bytes(mesh_view(o.view, scene, camera, picture)));
    if (is_sheet) write_label(shots.labels[i], bitmaps.back());
  }
  const Bitmap bitmap = is_sheet ? contact_sheet(bitmaps, shots.columns) : bitmaps.front();
  if (o.seconds > 0)
    io::write_file_atomically(o.output,
                              moving_png(o.output, bitmaps, o.seconds / static_cast<double>(o.turntable)));
  else
    io::write_image(o.output, bitmap);
  return std::to_string(bitmap.shape(1)) + " x " + std::to_string(bitmap.shape(0)) + " pixels, " +
         std::to_string(bitmaps.size()) + (bitmaps.size() == 1 ? " view" : " views");
}

std::vector<std::string> outputs_of(const Options& o) {
  std::vector<std::string> outputs{o.output, o.exported, o.panels};
  if (o.exported.ends_with(".obj"))
    for (const char* end : {".mtl", ".png"})
      outputs.push_back(o.exported.substr(0, o.exported.size() - 4) + end);
  return outputs;
}

int run(const CLI::App& app, Options& o) {
  require_sound(o);
  const auto claims = claimed_files(outputs_of(o));
  const io::Frame frame = o.frame.empty() ? io::Frame{} : io::read_frame(o.frame);
  const auto scene = load_scene(app, o, o.normalise || (!o.frame.empty() && !frame.camera));
  const PictureSettings picture{
      o.size.back(), o.size.front(), o.samples, {o.background[0], o.background[1], o.background[2]}};
  const Shots shots = shots_of(o, scene, frame, picture);
  if (!o.panels.empty()) remark(o.panels + ": " + write_panels(o, scene));
  const std::string written = write_view(o, scene, shots, picture);
  if (!o.exported.empty()) export_scene(o.exported, scene);
  remark(o.output + ": " + written + " of " + std::to_string(scene.mesh.faces.size()) + " faces");
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  auto app = command_line("Draws a mesh, painted or in its own colours: one picture, or a turntable.");
  describe(app, options);
  describe_panels(app, options);
  app.footer(
      "  render --azimuth 30 --output car.png\n"
      "  render --mesh car.obj --turntable 8 --output sheet.png\n"
      "  render --turntable 48 --seconds 4 --transparent --output turning.png\n"
      "  render --mesh car.obj --texture run/texture.png --panels panels.pdf");
  return run_program(app, argc, argv, [&] { return run(app, options); });
}
