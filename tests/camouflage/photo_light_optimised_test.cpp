#include <tapestry/camouflage/view_store.hpp>

#include <iostream>
#include <tapestry/geometry/shapes.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/obj_file.hpp>

#include "../support/paint.hpp"
#include "../support/paths.hpp"
#include "../support/threads.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
constexpr std::array<double, 3> paint{0.2, 0.5, 0.7};
constexpr std::size_t side = 200;

raster::PaintedMesh ball() {
  raster::PaintedMesh body{geometry::icosphere(4), {}, test::solid, image::ColourSpace::linear};
  body.painted = test::every_face(body.mesh);
  return body;
}

/// A sky above, a ground below and a sun, which make white paint at most white, under a coat that mirrors
/// them.
raster::PhotographedLight afternoon(const geometry::Mesh& mesh) {
  raster::PhotographedLight light;
  light.sun = 0.6;
  light.direction = geometry::normalised({0.6, -0.5, 0.6});
  light.sky = {0.5, 0, 0.2, 0, 0, 0, 0, 0, 0};
  light.shadow = std::make_shared<const raster::ParallelView>(mesh, light.direction, 512);
  light.coat = raster::NeutralCoat{5, {1.5, 0, 0.6, 0, 0, 0, 0, 0, 0}, light.sun, {}};
  return light;
}

template <class Light>
Array<double, 3> drawn(const raster::PaintedMesh& body, const geometry::Camera& camera, const Light& light,
                       const std::array<double, 3>& colour, std::size_t height, std::size_t width) {
  Array<double, 2> texel(Extents<2>{1, 3});
  for (std::size_t c = 0; c < 3; ++c) texel(0, c) = colour[c];
  auto picture = raster::render_textured(body, camera, height, width, light, texel).colour;
  for (double& value : picture.storage()) value = image::encoded(value);
  return picture;
}

template <class Light>
io::Frame photographed(const raster::PaintedMesh& body, const Light& light,
                       const geometry::Vector3& eye = {2, -3, 1.5}) {
  io::Frame frame;
  frame.name = "ball";
  frame.camera = geometry::look_at(eye, {0, 0, 0}, {0, 0, 1}, 0.6);
  const auto picture = drawn(body, *frame.camera, light, paint, side, side);
  frame.image = Array<std::uint8_t, 3>(Extents<3>{side, side, 3});
  for (std::size_t i = 0; i < picture.size(); ++i)
    frame.image.data()[i] = static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, picture.data()[i])));
  return frame;
}

/// Settings of photographs of the known paint.
camouflage::PhotoLight of_paint() {
  camouflage::PhotoLight settings;
  settings.paint = paint;
  return settings;
}

std::optional<raster::EstimatedLight> light_of(const io::Frame& frame, const raster::PaintedMesh& body,
                                               const camouflage::PhotoLight& settings = {}) {
  return camouflage::photo_light({&frame, 1}, body, settings);
}

/// Mean and greatest difference of two lights over the points of a frame.
std::array<double, 2> difference(const raster::PaintedMesh& body, const io::Frame& frame,
                                 const raster::PhotographedLight& a, const raster::PhotographedLight& b) {
  const auto first = raster::prepare(body.mesh, *frame.camera, a);
  const auto second = raster::prepare(body.mesh, *frame.camera, b);
  double sum = 0, greatest = 0;
  const auto points = camouflage::lit_points(frame, body, {});
  for (const auto& point : points) {
    const std::array<double, 3> middle{1.0 / 3, 1.0 / 3, 1.0 / 3};
    const double off =
        std::abs(first.at(point.face, middle) * a.colour[0] - second.at(point.face, middle) * b.colour[0]);
    sum += off / static_cast<double>(points.size());
    greatest = std::max(greatest, off);
  }
  return {sum, greatest};
}

/// Mean absolute difference of the car in its observed colours, a texel a face, from the photograph: over all
/// of it, over pixels that show paint, over the rest.
std::array<double, 3> errors_over(const camouflage::View<float>& view) {
  const auto& estimate = *view.photo_light;
  Array<float, 2> colours(Extents<2>{estimate.others.size(), 3});
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const std::size_t other = estimate.others[i / 3];
    const auto& observed = other > 0 ? estimate.other[other - 1] : estimate.product;
    colours.data()[i] = static_cast<float>(image::encoded(std::min(1.0, observed[i % 3])));
  }
  const auto picture = camouflage::picture_of(view, colours);
  const auto& drawn = *view.paint_to_picture;
  std::array<double, 3> sums{0, 0, 0}, counts{0, 0, 0};
  for (std::size_t pixel = 0; pixel < drawn.coverage.size(); ++pixel) {
    if (!(drawn.coverage.data()[pixel] > 0)) continue;
    const bool is_paint = std::binary_search(drawn.pixels.begin(), drawn.pixels.end(), pixel);
    const std::size_t row = pixel / drawn.width + view.window.top,
                      column = pixel % drawn.width + view.window.left;
    for (std::size_t c = 0; c < 3; ++c)
      for (const std::size_t part : {std::size_t{0}, is_paint ? std::size_t{1} : std::size_t{2}}) {
        sums[part] +=
            static_cast<double>(std::abs(picture(row, column, c) - view.background(row, column, c)));
        ++counts[part];
      }
  }
  for (std::size_t part = 0; part < 3; ++part) sums[part] /= std::max(1.0, counts[part]);
  return sums;
}

/// The picture of a car with a texel a face, all of them of one grey.
Array<float, 3> painted(const camouflage::View<float>& view, float level) {
  const std::size_t face_count = view.photo_light->others.size();
  return camouflage::picture_of(view, tapestry::filled<float, 2>(Extents<2>{face_count, 3}, level));
}

/// How much lighter white paint shows than black, encoded: the first quartile of the pixels that show paint
/// alone.
double white_beyond_black(const camouflage::View<float>& view) {
  const auto white = painted(view, 1), black = painted(view, 0);
  const auto& drawn = *view.paint_to_picture;
  std::vector<double> steps;
  for (const std::size_t pixel : drawn.pixels) {
    if (drawn.coverage.data()[pixel] < 1) continue;
    const std::size_t row = pixel / drawn.width + view.window.top,
                      column = pixel % drawn.width + view.window.left;
    double step = 0;
    for (std::size_t c = 0; c < 3; ++c)
      step += static_cast<double>(white(row, column, c) - black(row, column, c)) / 3;
    steps.push_back(step);
  }
  const auto quartile = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 4);
  std::nth_element(steps.begin(), quartile, steps.end());
  return *quartile;
}

double angle(const geometry::Vector3& a, const geometry::Vector3& b) {
  return std::acos(std::clamp(geometry::dot(geometry::normalised(a), geometry::normalised(b)), -1.0, 1.0));
}
}  // namespace

TEST_CASE("sun and sky are found again from a photograph of known paint", "[camouflage][light]") {
  const auto body = ball();
  const auto light = afternoon(body.mesh);
  const auto frame = photographed(body, light);
  const auto estimate = light_of(frame, body, of_paint());
  REQUIRE(estimate);
  CHECK(angle(estimate->light.direction, light.direction) <= 0.05);
  CHECK(estimate->error <= 0.01);
  CHECK(difference(body, frame, estimate->light, light)[0] <= 0.02);
  for (std::size_t c = 1; c < 3; ++c)
    CHECK(estimate->light.colour[c] == Approx(estimate->light.colour[0]).epsilon(0.02));
}

TEST_CASE("trim and dirt over a fifth of the car hardly change its light", "[camouflage][light]") {
  const auto body = ball();
  const auto light = afternoon(body.mesh);
  auto frame = photographed(body, light);
  Random random(5);
  for (std::size_t pixel = 0; pixel < side * side; ++pixel)
    if (random.index(5) == 0)
      for (std::size_t c = 0; c < 3; ++c) frame.image.data()[3 * pixel + c] = 8;
  const auto estimate = light_of(frame, body, of_paint());
  REQUIRE(estimate);
  CHECK(angle(estimate->light.direction, light.direction) <= 0.08);
  CHECK(difference(body, frame, estimate->light, light)[0] <= 0.04);
}

TEST_CASE("without the paint a photograph's light is white, and as strong as exposure makes it",
          "[camouflage][light]") {
  const auto body = ball();
  auto light = afternoon(body.mesh);
  const auto full = light_of(photographed(body, light), body);
  light.sun /= 4;
  light.coat->glint /= 4;
  for (std::size_t k = 0; k < 9; ++k) {
    light.sky[k] /= 4;
    light.coat->surroundings[k] /= 4;
  }
  const auto quarter = light_of(photographed(body, light), body);
  REQUIRE(full);
  REQUIRE(quarter);
  CHECK(full->light.colour == std::array<double, 3>{1, 1, 1});
  CHECK(quarter->light.sun == Approx(full->light.sun).epsilon(0.1));
  for (std::size_t c = 0; c < 3; ++c) CHECK(quarter->product[c] == Approx(full->product[c] / 4).epsilon(0.1));
  CHECK(full->product[1] / full->product[2] == Approx(paint[1] / paint[2]).epsilon(0.01));
}

TEST_CASE("points come from painted faces inside the mask; light from those that are not overexposed",
          "[camouflage][light]") {
  auto body = ball();
  auto frame = photographed(body, afternoon(body.mesh));
  const auto whole = camouflage::lit_points(frame, body, {});
  CHECK(whole.size() > 5000);
  CHECK(camouflage::lit_points(frame, body, {{}, 100}).size() <= 100);
  frame.mask = Array<std::uint8_t, 2>(Extents<2>{side, side});
  std::fill(frame.mask->begin(), frame.mask->end(), std::uint8_t{0});
  CHECK(camouflage::lit_points(frame, body, {}).empty());
  CHECK_FALSE(light_of(frame, body));
  const auto view = camouflage::make_view<float>(frame, body, 64, 64, 2, {}, camouflage::PhotoLight{});
  CHECK(view.photo_light == nullptr);
  frame.mask.reset();
  std::fill(body.painted.begin(), body.painted.end(), std::uint8_t{0});
  CHECK(camouflage::lit_points(frame, body, {}).empty());
  body.painted = test::every_face(body.mesh);
  std::fill(frame.image.begin(), frame.image.end(), std::uint8_t{255});
  CHECK(camouflage::lit_points(frame, body, {}).at(0).colour == std::array<double, 3>{1, 1, 1});  // a bound
  CHECK_FALSE(light_of(frame, body));
  std::fill(frame.image.begin(), frame.image.end(), std::uint8_t{0});  // a black car: no light at all
  const auto dark = light_of(frame, body);
  REQUIRE(dark);
  CHECK(dark->light.sun == 0);
  CHECK(dark->error == 0);
}

TEST_CASE("a view under a photograph's light keeps it, and has the same bits for any number of threads",
          "[camouflage][light]") {
  const auto body = ball();
  const auto frame = photographed(body, afternoon(body.mesh));
  test::same_by_threads({1, 2}, [&] {
    const auto view = camouflage::make_view<float>(frame, body, 64, 64, 2, {}, camouflage::PhotoLight{});
    REQUIRE(view.photo_light != nullptr);
    CHECK(view.photo_light->light.shadow == nullptr);
    return std::pair(view.photo_light->light.sky, view.paint_to_picture->weights);
  });
  CHECK(camouflage::make_view<float>(frame, body, 64, 64).photo_light == nullptr);
}

namespace {
double mean_difference(const Array<double, 3>& a, const Array<double, 3>& b) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a.data()[i] == 0 && b.data()[i] == 0) continue;
    sum += std::abs(std::min(1.0, a.data()[i]) - std::min(1.0, b.data()[i]));
    ++count;
  }
  return sum / count;
}
}  // namespace

TEST_CASE("a photograph tells how black, white and red paint look in its light", "[camouflage][light]") {
  const auto body = ball();
  const auto truth = afternoon(body.mesh);
  const io::Frame frame = photographed(body, truth);
  const auto estimate = light_of(frame, body, of_paint());
  const auto unknown = light_of(frame, body);
  REQUIRE(estimate);
  REQUIRE(unknown);
  const auto under = [&](const raster::PhotographedLight& light, const std::array<double, 3>& colour) {
    return drawn(body, *frame.camera, light, colour, side, side);
  };
  for (const std::array<double, 3>& colour :
       {std::array<double, 3>{0, 0, 0}, {1, 1, 1}, {0.7, 0.1, 0.05}, paint}) {
    const double off = mean_difference(under(estimate->light, colour), under(truth, colour));
    std::cout << "mean colour error in paint " << colour[0] << " " << colour[1] << " " << colour[2] << ": "
              << off << "\n";
    CHECK(off <= 0.02);
  }
  const auto black = under(unknown->light, {0, 0, 0});
  CHECK(mean_difference(black, under(truth, {0, 0, 0})) <= 0.02);
  for (std::size_t i = 0; i < black.size(); i += 3) CHECK(black.data()[i] == black.data()[i + 2]);
}

TEST_CASE("photographs of one place have one light, judged on those that are left out",
          "[camouflage][light]") {
  const auto body = ball();
  const auto truth = afternoon(body.mesh);
  std::vector<io::Frame> frames;
  for (const geometry::Vector3& eye : {geometry::Vector3{2, -3, 1.5}, {-2, -3, 1}, {3, 2, 1.5}})
    frames.push_back(photographed(body, truth, eye));
  const auto estimate = camouflage::photo_light(frames, body, {});
  REQUIRE(estimate);
  REQUIRE(estimate->held_out);
  CHECK(estimate->views == 3);
  CHECK(angle(estimate->light.direction, truth.direction) <= 0.05);
  CHECK(estimate->held_out->error <= 0.02);
  CHECK(estimate->held_out->sun_turn_rad <= 0.087);  // 5 degrees
  CHECK(estimate->held_out->sun_change <= 0.1);
  CHECK_FALSE(light_of(frames[0], body)->held_out);
  std::vector<camouflage::ViewStore<float>::Loader> loaders;
  for (const io::Frame& frame : frames) loaders.push_back([&frame] { return frame; });
  for (const bool is_one_place : {false, true}) {
    camouflage::PhotoLight settings;
    settings.is_one_place = is_one_place;
    camouflage::ViewStore<float> store(body, {64, 64, 2, 0, {}, settings}, loaders);
    const auto first = store.view(0)->photo_light, last = store.view(2)->photo_light;
    REQUIRE(first);
    REQUIRE(last);
    CHECK(first->views == (is_one_place ? 3 : 1));
    CHECK((first->light.direction == last->light.direction) == is_one_place);
  }
}

TEST_CASE("frames of a simulator are of one place where the vehicle stands still", "[camouflage][light]") {
  io::Frame a;
  a.pose = geometry::CarlaPose{{10, 20, 0.6}, {0, 90, 0}, {4, 0, 2}, {-20, 180, 0}};
  io::Frame b = a;
  b.pose->camera_translation = {0, 4, 2};
  CHECK(camouflage::place_of(a, {}) == camouflage::place_of(b, {}));
  b.pose->vehicle_translation[0] = 11;
  CHECK(camouflage::place_of(a, {}) != camouflage::place_of(b, {}));
  b = a;
  b.camera = geometry::Camera{};
  CHECK_FALSE(camouflage::place_of(b, {}));
}

TEST_CASE("faces of another colour do not count, and an even sky leaves the sun unknown",
          "[camouflage][light]") {
  const auto body = ball();
  auto light = afternoon(body.mesh);
  auto frame = photographed(body, light);
  const auto trim = drawn(body, *frame.camera, light, {0.1, 0.1, 0.1}, side, side);
  const auto seen = raster::visibility(body.mesh, *frame.camera, side, side, 1);
  std::size_t others = 0, all = 0;
  for (std::size_t i = 0; i < side * side; ++i) {
    if (seen.face[i] < 0) continue;
    ++all;
    if (body.mesh.positions[static_cast<std::size_t>(
            body.mesh.faces[static_cast<std::size_t>(seen.face[i])][0])][2] > -0.3)
      continue;
    ++others;
    for (std::size_t c = 0; c < 3; ++c)
      frame.image.data()[3 * i + c] = static_cast<std::uint8_t>(255 * std::min(1.0, trim.data()[3 * i + c]));
  }
  const auto estimate = light_of(frame, body);
  REQUIRE(estimate);
  CHECK(std::abs(estimate->other_share - static_cast<double>(others) / static_cast<double>(all)) <= 0.05);
  CHECK(estimate->error <= 0.02);
  light.sun = 0;
  light.sky = raster::uniform_sky(0.8);
  light.coat = raster::NeutralCoat{5, raster::uniform_sky(0.8), 0, {}};
  const auto even = light_of(photographed(body, light), body);
  REQUIRE(even);
  CHECK((even->light.sun <= 0.05 || even->sun_within_rad > raster::unknown_sun_rad));
}

TEST_CASE("faces without paint show the photograph where its mask is the car's silhouette",
          "[camouflage][light][long]") {
  auto body = ball();
  auto frame = photographed(body, afternoon(body.mesh));
  for (std::size_t face = 0; face < body.mesh.faces.size(); ++face)
    body.painted[face] = body.mesh.positions[static_cast<std::size_t>(body.mesh.faces[face][0])][2] > 0;
  for (std::size_t i = 0; i < frame.image.size(); i += 7) frame.image.data()[i] = 200;  // dirt
  const Array<float, 2> white = tapestry::filled<float, 2>(Extents<2>{1, 3}, 1.0F);
  auto light = GENERATE(std::optional<camouflage::PhotoLight>{}, camouflage::PhotoLight{});
  const auto view_of = [&] { return camouflage::make_view<float>(frame, body, side, side, 2, {}, light); };
  const auto unpainted_off = [&](const camouflage::View<float>& view) {  // largest difference off the paint
    const auto picture = camouflage::picture_of(view, white);
    std::vector<bool> painted(side * side);
    for (const auto pixel : view.paint_to_picture->pixels)
      painted[(pixel / view.window.width + view.window.top) * side + pixel % view.window.width +
              view.window.left] = true;
    double largest = 0;
    for (std::size_t i = 0; i < picture.size(); ++i)
      if (!painted[i / 3])
        largest =
            std::max(largest, static_cast<double>(std::abs(picture.data()[i] - view.background.data()[i])));
    return largest;
  };
  const auto without_mask = view_of();  // nothing confirms that the photograph holds the car
  CHECK_FALSE(without_mask.keeps_photograph);
  CHECK_FALSE(without_mask.registration);
  CHECK_FALSE(without_mask.shows_car);
  CHECK((without_mask.photo_light != nullptr) == light.has_value());
  CHECK(unpainted_off(without_mask) > 0.05);
  if (light) {
    const bool is_found = GENERATE(true, false);
    light->shows_car = [&](const Array<float, 3>& picture, const std::string& name, const detect::Box& box) {
      CHECK(picture == without_mask.background);
      CHECK(name == frame.name);
      CHECK(box.w == without_mask.target.w);
      CHECK(box.cx == without_mask.target.cx);
      return is_found;
    };
    const auto asked = view_of();
    CHECK(asked.shows_car == is_found);
    CHECK(asked.keeps_photograph == is_found);
    CHECK((asked.photo_light != nullptr) == is_found);
    CHECK((unpainted_off(asked) <= 1e-5) == is_found);
  }

  const auto silhouette = raster::visibility(body.mesh, *frame.camera, side, side, 1);
  frame.mask = Array<std::uint8_t, 2>(Extents<2>{side, side});
  for (std::size_t i = 0; i < side * side; ++i) frame.mask->data()[i] = silhouette.face[i] >= 0 ? 255 : 0;
  const auto registered = view_of();
  CHECK(registered.registration.value() == 1);
  CHECK(unpainted_off(registered) <= 1e-5);
  const auto in_materials = camouflage::make_view<float>(frame, body, side, side, 2, {}, light, false);
  CHECK_FALSE(in_materials.keeps_photograph);
  CHECK(unpainted_off(in_materials) > 0.05);

  for (std::size_t i = 0; i < side * side; ++i)
    if (i % side < side / 2 + 10) frame.mask->data()[i] = 0;  // something stands before the car
  const auto hidden = view_of();
  CHECK(hidden.registration.value() < 0.6);
  CHECK_FALSE(hidden.keeps_photograph);
  CHECK(unpainted_off(hidden) > 0.05);  // its material
}

TEST_CASE("light from no points, of black paint, or from points that are not finite is refused",
          "[camouflage][light][bad_input]") {
  const auto mesh = geometry::icosphere(1);
  CHECK_THROWS_AS(raster::estimated_light(mesh, {}), DomainError);
  raster::LitPoint point;
  CHECK_THROWS_AS(raster::estimated_light(mesh, {point}, std::array<double, 3>{0, 1, 1}), DomainError);
  CHECK_NOTHROW(raster::estimated_light(mesh, {point}));  // one black point
  point.colour[1] = std::nan("");
  CHECK_THROWS_AS(raster::estimated_light(mesh, {point}), DomainError);
  point.colour[1] = 1;
  point.face = mesh.faces.size();
  CHECK_THROWS_AS(raster::estimated_light(mesh, {point}), DomainError);
}

TEST_CASE("the car of the real frames looks more like its photograph under the photograph's light",
          "[camouflage][light][carla][long]") {
  const std::string shared = test::in_shared("data/");
  if (test::is_absent(shared + "mesh/audi_et_te.obj")) return;
  raster::PaintedMesh car{geometry::normalise_mesh(io::read_obj(shared + "mesh/audi_et_te.obj").mesh),
                          {},
                          raster::cube_layout(1),
                          image::ColourSpace::linear};
  car.painted = geometry::faces_by_material(car.mesh, {"MI_CarExterior_Etron"});
  camouflage::PhotoLight settings{
      std::make_shared<const raster::AmbientOcclusion>(raster::ambient_occlusion(car.mesh, 256, 256))};
  settings.shows_car = [](const auto&...) { return true; };  // the frames are known to
  std::array<double, 3> errors{0, 0, 0};  // of the car, its paint, the rest; mean of the frames
  std::vector<io::Frame> place;           // the last five; the first is of another place
  for (const char* number : {"12501", "12502", "12503", "12504", "12505"})
    place.push_back(io::read_frame(shared + "carla/data" + number + ".npz"));
  for (const io::Frame& frame : place)
    CHECK(camouflage::place_of(frame, settings) == camouflage::place_of(place[0], settings));
  const auto estimate = camouflage::photo_light(place, car, settings);
  REQUIRE(estimate);
  REQUIRE(estimate->held_out);
  const auto& held_out = *estimate->held_out;
  std::cout << "held-out photographs, mean colour error of paint " << held_out.error << ", of all "
            << held_out.error_of_all << ", sun turns by " << held_out.sun_turn_rad << ", changes by "
            << held_out.sun_change << "; fitted " << estimate->error << ", " << estimate->error_of_all
            << "\n";
  CHECK(held_out.error <= 0.08);
  CHECK(held_out.sun_turn_rad <= 0.22);  // 0.19: without the hood's front the sun is not known to 5 degrees
  CHECK(held_out.sun_change <= 0.1);
  CHECK(estimate->error <= 0.09);
  settings.known = std::make_shared<const raster::EstimatedLight>(*estimate);
  for (const io::Frame& frame : place) {
    const std::size_t height = frame.image.shape(0), width = frame.image.shape(1);
    const auto view = camouflage::make_view<float>(frame, car, height, width, 2, {}, settings);
    CHECK(white_beyond_black(view) >= 0.3);
    const auto dark = painted(view, 0.02F);
    const auto seen = raster::visibility(car.mesh, io::camera_of(frame), 2 * height, 2 * width, 1);
    float sum = 0, count = 0;
    for (const std::size_t pixel : view.paint_to_picture->pixels) {
      const std::size_t row = pixel / view.window.width + view.window.top,
                        column = pixel % view.window.width + view.window.left;
      const auto [least, most] =
          std::minmax({dark(row, column, 0), dark(row, column, 1), dark(row, column, 2)});
      sum += most - least;
      ++count;
      bool is_paint_alone = true;  // else glass or the street show their colours beside it
      for (std::size_t sample = 0; sample < 4; ++sample) {
        const auto face = seen.face[(2 * row + sample / 2) * 2 * width + 2 * column + sample % 2];
        is_paint_alone &= face >= 0 && car.painted[static_cast<std::size_t>(face)] != 0;
      }
      if (is_paint_alone) CHECK(most - least <= 1e-5F);
    }
    std::cout << "black paint, mean of largest minus smallest channel: " << sum / count << "\n";
    CHECK(sum / count <= 15.0F / 255);
    const auto of_frame = errors_over(view);
    for (std::size_t part = 0; part < 3; ++part) errors[part] += of_frame[part] / 5;
  }
  std::cout << "mean colour error, five frames: of the car " << errors[0] << ", its paint with trim "
            << errors[1] << ", the rest " << errors[2] << "\n";
  CHECK(errors[0] <= 0.06);
  CHECK(errors[1] <= 0.09);
  CHECK(errors[2] <= 0.001);
}
