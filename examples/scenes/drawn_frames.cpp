#include "drawn_frames.hpp"

#include "car.hpp"
#include "make_scene.hpp"
#include "picture.hpp"

namespace tapestry::scenes {
namespace {
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
  options.fill = {0.4, 0.75};
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
  const bool is_found = std::ranges::count(picture.boxes, scene.car_object, &PictureBox::object) > 0;
  return is_found ? visible / whole : 0;
}

io::Frame frame_of(const Scene& scene, const Picture& picture, const Array<float, 2>& alone) {
  io::Frame frame;
  const CarView seen(scene);
  frame.image = image::to_bytes(picture.image);
  frame.camera = seen.camera;
  frame.light = seen.light;
  auto& mask = frame.mask.emplace(alone.shape());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    const float visible = picture.car_mask.data()[i];  // for a partly hidden pixel the larger part decides
    mask.data()[i] = visible > 0 && visible >= 0.5F * alone.data()[i] ? 255 : 0;
  }
  const auto box = std::ranges::find(picture.boxes, scene.car_object, &PictureBox::object);
  frame.label = {box->class_index, detect::box_from_corners(box->left, box->top, box->right, box->bottom)};
  return frame;
}

/// The scene with its main car's faces shrunk to points.
Scene without_car(Scene scene) {
  const SceneObject& car = scene.objects[scene.car_object];
  for (std::size_t face = car.face_begin; face < car.face_end; ++face)
    scene.mesh.faces[face].fill(scene.mesh.faces[face][0]);
  return scene;
}
}  // namespace

std::optional<io::Frame> find_frame(Random& random, const std::function<Scene(Random&)>& make, double least,
                                    double most, std::size_t height, std::size_t width, bool shows_car,
                                    std::size_t attempts) {
  for (std::size_t attempt = 0; attempt < attempts; ++attempt) {
    const Scene scene = make(random);
    const Picture picture = draw_scene(scene, height, width);
    const auto alone =
        raster::coverage_of(raster::visibility(scene.car, CarView(scene).camera, height, width, 2));
    const double share = share_in_view(scene, picture, alone);
    if (share < least || share >= most) continue;
    io::Frame frame = frame_of(scene, picture, alone);
    if (!shows_car) frame.image = image::to_bytes(draw_scene(without_car(scene), height, width).image);
    return frame;
  }
  return std::nullopt;
}

io::Frame make_frame(Random& random, const std::function<Scene(Random&)>& make, double least, double most,
                     std::size_t height, std::size_t width) {
  if (auto frame = find_frame(random, make, least, most, height, width, true, 1000)) return std::move(*frame);
  throw DomainError("of a thousand views the car lies in none as a whole; let the camera stand farther away");
}

io::Frame make_frame(Random& random, const SceneOptions& options, std::size_t size) {
  const bool is_occluded = options.occluder_chance > 0;
  return make_frame(
      random, [&](Random& numbers) { return make_scene(numbers, options); }, is_occluded ? 0.6 : 0.97,
      is_occluded ? 0.97 : 2, size, size);
}

io::Frame DrawnFrames::operator()(std::size_t index) const {
  Random random = Random(seed).fork(static_cast<std::uint64_t>(stream)).fork(index);
  return make_frame(random, frame_options(index, count), size);
}
}  // namespace tapestry::scenes
