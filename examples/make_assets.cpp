// Makes the bundled default: car meshes, and frames of the sedan in street scenes to paint it in.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <optional>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/obj_writer.hpp>
#include <tapestry/raster/visibility.hpp>
#include <utility>

#include "procedural/car.hpp"
#include "procedural/make_scene.hpp"
#include "procedural/picture.hpp"
#include "support/program.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::examples;

struct Options {
  std::string output = TAPESTRY_ASSETS;
  std::uint64_t seed = 1;
  std::size_t size = 256;
  std::size_t train = 40;
  std::size_t test = 40;
};

void describe(CLI::App& app, Options& options) {
  app.add_option("--output", options.output, "folder to write to; files of the same names are replaced")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of the scenes")->capture_default_str();
  app.add_option("--size", options.size, "side of a frame, pixels")
      ->capture_default_str()
      ->check(CLI::Range(32, 2048));
  app.add_option("--train", options.train, "frames to optimise on")
      ->capture_default_str()
      ->check(CLI::Range(1, 9999));
  app.add_option("--test", options.test, "frames held out")
      ->capture_default_str()
      ->check(CLI::Range(1, 9999));
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw FileError(ErrorKind::write,
                    {.path = folder.string(), .what = "cannot make the folder: " + error.message()});
}

void write_cars(const std::string& folder) {
  const std::pair<const char*, BodyStyle> cars[]{{"car_sedan", BodyStyle::sedan},
                                                 {"car_hatchback", BodyStyle::hatchback},
                                                 {"car_suv", BodyStyle::suv},
                                                 {"van", BodyStyle::van}};
  for (const auto& [name, style] : cars) {
    CarOptions options;
    options.style = style;
    io::write_obj(folder + "/" + name + ".obj", make_car(options));
  }
}

/// One view out of `count`, evenly spread around the sedan in its material's own colour. Neither noise
/// nor strong grain, so that the files stay small.
SceneOptions frame_options(std::size_t index, std::size_t count) {
  const double step = 2 * std::numbers::pi / static_cast<double>(count);
  SceneOptions options;
  options.style = BodyStyle::sedan;
  options.paint = PaintKind::realistic;
  options.colour = CarOptions{}.colour;
  options.varied_shape = false;
  options.azimuth_rad = {step * static_cast<double>(index), step * static_cast<double>(index + 1)};
  options.fill = {0.32, 0.72};
  options.occluder_chance = index % 4 == 3 ? 1 : 0;
  options.ground_contrast = 0.03;
  options.sensor_noise = 0;
  return options;
}

/// Share of the car's samples that nothing hides, when none of the car lies outside the picture; else 0.
double share_in_view(const Scene& scene, const Picture& picture, const Array<float, 2>& alone) {
  const std::size_t height = alone.shape(0), width = alone.shape(1);
  double visible = 0, whole = 0;
  for (std::size_t row = 0; row < height; ++row)
    for (std::size_t column = 0; column < width; ++column) {
      const bool at_border = row == 0 || column == 0 || row + 1 == height || column + 1 == width;
      if (at_border && alone(row, column) > 0) return 0;
      visible += static_cast<double>(picture.car_mask(row, column));
      whole += static_cast<double>(alone(row, column));
    }
  const bool is_found = std::any_of(picture.boxes.begin(), picture.boxes.end(),
                                    [&](const PictureBox& box) { return box.object == scene.car_object; });
  return is_found ? visible / whole : 0;
}

io::Frame frame_of(const Scene& scene, const Picture& picture, const Array<float, 2>& alone) {
  const auto height = static_cast<double>(alone.shape(0)), width = static_cast<double>(alone.shape(1));
  io::Frame frame;
  frame.image = Array<std::uint8_t, 3>(picture.image.shape());
  for (std::size_t i = 0; i < picture.image.size(); ++i)
    frame.image.data()[i] = static_cast<std::uint8_t>(picture.image.data()[i] * 255 + 0.5F);
  frame.has_camera = frame.has_light = frame.has_mask = frame.has_label = true;
  frame.camera = scene.camera;
  const auto& light = scene.light;
  frame.light = {light.ambient,      light.directional, light.direction[0], light.direction[1],
                 light.direction[2], light.colour[0],   light.colour[1],    light.colour[2]};
  frame.mask = Array<std::uint8_t, 2>(alone.shape());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    const float visible = picture.car_mask.data()[i];  // of a pixel half hidden, the larger half decides
    frame.mask.data()[i] = visible > 0 && visible >= 0.5F * alone.data()[i] ? 255 : 0;
  }
  const auto box = std::find_if(picture.boxes.begin(), picture.boxes.end(),
                                [&](const PictureBox& found) { return found.object == scene.car_object; });
  frame.label = {static_cast<double>(box->class_index), (box->left + box->right) / (2 * width),
                 (box->top + box->bottom) / (2 * height), (box->right - box->left) / width,
                 (box->bottom - box->top) / height};
  return frame;
}

/// Draws scenes until the car is in the picture and at least 60 % of it shows, 97 % where no occluder
/// was asked for.
io::Frame make_frame(Random& random, const SceneOptions& options, std::size_t size) {
  while (true) {
    const Scene scene = make_scene(random, options);
    const Picture picture = draw_scene(scene, size, size);
    const auto alone = raster::coverage_of(raster::visibility(scene.car, scene.camera, size, size, 2));
    const double share = share_in_view(scene, picture, alone);
    if (options.occluder_chance > 0 ? share >= 0.6 && share < 0.97 : share >= 0.97)
      return frame_of(scene, picture, alone);
  }
}

void write_frames(const std::string& folder, std::size_t count, std::size_t size, const Random& parent) {
  make_folder(folder);
  for (std::size_t index = 0; index < count; ++index) {
    Random random = parent.fork(index);
    std::string number = std::to_string(index);
    number.insert(0, number.size() < 3 ? 3 - number.size() : 0, '0');
    io::write_frame(folder + "/" + number + ".npz", make_frame(random, frame_options(index, count), size));
  }
}

int make_assets(const Options& options) {
  make_folder(options.output);
  write_cars(options.output);
  const Random random(options.seed);
  write_frames(options.output + "/frames/train", options.train, options.size, random.fork(1));
  write_frames(options.output + "/frames/test", options.test, options.size, random.fork(2));
  std::cout << "wrote 4 meshes and " << options.train + options.test << " frames to " << options.output
            << '\n';
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes the bundled default: car meshes and frames of the sedan in street scenes."};
  Options options;
  describe(app, options);
  const int parsed = parse_arguments(app, argc, argv);
  return parsed >= 0 ? parsed : run_program([&] { return make_assets(options); });
}
