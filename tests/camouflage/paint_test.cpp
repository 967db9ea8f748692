#include <tapestry/camouflage/paint.hpp>
#include <tapestry/raster/bake.hpp>

#include <tapestry/autodiff/gradient_check.hpp>
#include <tapestry/camouflage/method/methods.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/mesh_writers.hpp>
#include <tapestry/io/npy.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/face_charts.hpp>
#include <tapestry/raster/painted.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"
#include "../support/stepped_car.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using Paint = camouflage::Paint<float>;

namespace {
image::ColourChange some_print() {
  return image::draw_print(image::conditions_by_names({"print"}), Random(3));
}
}  // namespace

TEST_CASE("of a paint on parts of a car only these are printed", "[camouflage][paint]") {
  const auto colours = test::random_array<float>({4, 3}, 1, 0, 1);
  const auto all = camouflage::printed<float>({colours}, some_print());
  CHECK((all == image::transformed(colours, some_print())));
  const auto some = camouflage::printed<float>({colours, {1, 0, 0, 1}}, some_print());
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(some(0, c) == all(0, c));
    CHECK(some(1, c) == colours(1, c));
    CHECK(some(2, c) == colours(2, c));
    CHECK(some(3, c) == all(3, c));
    CHECK(all(1, c) != colours(1, c));
  }
  CHECK((camouflage::printed(camouflage::without_paint(colours), some_print()) == colours));
  CHECK_THROWS_AS(camouflage::printed<float>({colours, {1, 0, 1}}, some_print()), ShapeError);
}

TEST_CASE("a method prints what it paints, with that slope", "[camouflage][paint][gradient]") {
  const auto name = GENERATE(as<std::string>(), "fca", "das");
  const auto car = test::stepped_car();
  const auto method = camouflage::method_by_name<double>(name, car, 1);
  const std::size_t texels = car.layout.texel_count(car.mesh);
  const auto painted = camouflage::painted_texels(method);
  CHECK(painted.empty() == (name == "fca"));
  const auto parameter =
      camouflage::first_parameter(method, test::random_array<double>({texels, 3}, 4, -1, 1));
  const auto colours = camouflage::method_colours(method, parameter);
  const auto on_tape = camouflage::printed(method, ArrayVariable<double, 2>(colours), some_print()).value();
  CHECK((on_tape == camouflage::printed<double>({colours, painted}, some_print())));
  const auto weights = test::random_array<double>({texels, 3}, 5, -1, 1);
  const auto sum_of = [&](const auto& x) {
    return tapestry::sum(ArrayVariable<double, 2>(weights) *
                         camouflage::printed(method, camouflage::method_colours(method, x), some_print()));
  };
  const auto report = tapestry::check_tape_gradient(sum_of, parameter, {.subset = 60});
  INFO(report.to_text());
  CHECK(report.passed());
  CHECK(report.checked > 0);
}

TEST_CASE("a paint is read as it was written", "[camouflage][paint][io]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("texture.npz");
  const auto parameter = test::random_array<float>({2, 3}, 2);
  const auto paint = GENERATE(Paint{test::random_array<float>({3, 3}, 1, 0, 1)},
                              Paint{test::random_array<float>({3, 3}, 1, 0, 1), {0, 1, 0}});
  camouflage::write_paint(path, parameter, paint);
  CHECK(camouflage::read_paint(path, 3) == paint);
  const auto file = io::NpzFile::read(path);
  CHECK((file.array<float, 2>("parameter") == parameter));
  CHECK(camouflage::read_offsets(path, 5).size() == 0);
  const auto offsets = test::random_array<float>({5, 3}, 4, -1, 1);
  camouflage::write_paint(path, parameter, paint, offsets);
  CHECK(camouflage::read_paint(path, 3) == paint);
  CHECK((camouflage::read_offsets(path, 5) == offsets));
  CHECK(camouflage::read_layout(path).empty());
  camouflage::write_paint(path, parameter, paint, {}, "laid like this");
  CHECK(camouflage::read_layout(path) == "laid like this");
  CHECK(camouflage::read_paint(path, 3) == paint);
}

TEST_CASE("offsets that do not fit, or are none, are refused by name", "[camouflage][paint][io][error]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("texture.npz");
  const Paint paint{test::random_array<float>({3, 3}, 1, 0, 1)};
  auto offsets = test::random_array<float>({5, 3}, 4, -1, 1);
  camouflage::write_paint(path, paint.colours, paint, offsets);
  CHECK_THROWS_WITH(camouflage::read_offsets(path, 6),
                    contains(path) && contains("the shape does not fit the car") && contains("(6, 3)"));
  for (const float bad : {1.5F, std::nanf("")}) {
    offsets(1, 2) = bad;
    camouflage::write_paint(path, paint.colours, paint, offsets);
    CHECK_THROWS_WITH(camouflage::read_offsets(path, 5), contains(path) && contains("offset 5"));
  }
}

TEST_CASE("all is paint in a file that does not say what is", "[camouflage][paint][io]") {
  const test::TemporaryFolder folder;
  const auto colours = test::random_array<float>({3, 3}, 1, 0, 1);
  io::NpzWriter file;
  file.add("colours", colours);
  file.write(folder.path("texture.npz"));
  CHECK(camouflage::read_paint(folder.path("texture.npz"), 3) == Paint{colours});
}

TEST_CASE("a paint that does not fit, or is none, is refused by name", "[camouflage][paint][io][error]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("texture.npz");
  const auto colours = test::random_array<float>({3, 3}, 1, 0, 1);
  const auto read = [&](const Array<float, 2>& of, std::vector<std::uint8_t> painted) {
    io::NpzWriter file;
    file.add("colours", of);
    Array<std::uint8_t, 1> entries(Extents<1>{painted.size()});
    std::copy(painted.begin(), painted.end(), entries.begin());
    file.add("painted", entries);
    file.write(path);
    return camouflage::read_paint(path, 3);
  };
  CHECK(read(colours, {1, 1, 1}) == Paint{colours});
  CHECK_THROWS_WITH(read(colours, {1, 1}), contains(path) && contains("painted does not fit the car"));
  CHECK_THROWS_WITH(read(colours, {1, 2, 0}), contains("painted, texel 1; expected 0 or 1, found 2"));
  CHECK_THROWS_WITH(read(test::random_array<float>({4, 3}, 1, 0, 1), {1, 1, 1}),
                    contains("the texture does not fit the car"));
  for (const float colour :
       {1.5F, -0.25F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    CHECK_THROWS_WITH(read(tapestry::filled<float, 2>({3, 3}, colour), {1, 1, 1}),
                      contains("colour 0; expected a number in 0 to 1"));  // T03
  CHECK_THROWS_AS(camouflage::write_paint(path, colours, {colours, {1, 1, 1, 0}}), ShapeError);
}

TEST_CASE("own colours of a solid texture are the mean over the painted faces", "[camouflage][paint]") {
  auto car = test::tiny_car(12, raster::TextureKind::solid);
  car.mesh.materials.push_back({"stripe", {0.9F, 0.1F, 0.3F}});
  car.mesh.face_materials[0] = 2;  // one of ten painted faces
  const auto colours = camouflage::own_colours<float>(car);
  REQUIRE(colours.shape() == Extents<2>{1, 3});
  CHECK(std::abs(colours(0, 0) - 0.36F) < 1e-6F);
  CHECK(std::abs(colours(0, 1) - 0.46F) < 1e-6F);
  CHECK(std::abs(colours(0, 2) - 0.66F) < 1e-6F);
}

TEST_CASE("a cube's paint is exported as it is, without texture coordinates or with shared ones",
          "[camouflage][paint]") {
  auto car = test::tiny_car(12, raster::TextureKind::cube);
  if (GENERATE(true, false)) {
    car.mesh.uvs.clear();
    for (auto& corners : car.mesh.face_uvs) corners = {-1, -1, -1};
  } else {
    for (auto& corners : car.mesh.face_uvs) corners = {0, 1, 2};
  }
  const std::size_t texels = car.layout.texel_count(car.mesh) / car.mesh.faces.size();
  Array<float, 2> colours(Extents<2>{car.layout.texel_count(car.mesh), 3});
  for (std::size_t i = 0; i < colours.shape(0); ++i)  // a colour for each face
    for (std::size_t c = 0; c < 3; ++c) colours(i, c) = static_cast<float>((i / texels * (c + 2)) % 7) / 7;
  const auto exported = raster::with_atlas(car);
  const auto atlas = camouflage::atlas_of<float>(car, colours);
  REQUIRE(exported.layout.height == atlas.shape(0));
  for (std::size_t face = 0; face < car.mesh.faces.size(); ++face) {
    if (car.painted[face] == 0) continue;
    raster::for_each_atlas_texel(
        exported.mesh, exported.layout, face, [&](std::size_t row, std::size_t column, const auto&) {
          for (std::size_t c = 0; c < 3; ++c)
            CHECK(std::abs(atlas(row, column, c) - colours(face * texels, c)) < 1e-6F);
        });
  }
}

TEST_CASE("cars painted by cubes, vertices or one colour are written as they are drawn",
          "[camouflage][paint][io]") {
  const auto kind =
      GENERATE(raster::TextureKind::cube, raster::TextureKind::vertex, raster::TextureKind::solid);
  const auto car = test::tiny_car(12, kind);
  Array<float, 2> colours(Extents<2>{car.layout.texel_count(car.mesh), 3});
  for (std::size_t i = 0; i < colours.size(); ++i)  // smooth, so that charts of 16 texels hold it
    colours.data()[i] = 0.5F + 0.4F * std::sin(0.7F * static_cast<float>(i % 97));
  if (kind == raster::TextureKind::cube) colours = tapestry::filled<float, 2>(colours.shape(), 0.3F);
  const test::TemporaryFolder folder;
  const std::string path = folder.path("painted.obj");
  io::write_painted_obj(path, car, camouflage::atlas_of<float>(car, colours));
  auto written = raster::painted(io::read_obj(path).mesh, {.material = "paint"});
  CHECK(written.painted == car.painted);
  const auto atlas = image::from_bytes<float>(io::read_image(folder.path("painted.png")));
  written.layout.height = atlas.shape(0);
  written.layout.width = atlas.shape(1);
  written.layout.filter = raster::TextureFilter::bilinear;
  written.pyramid = nullptr;
  written.space = car.space;
  Array<float, 2> texels(Extents<2>{atlas.shape(0) * atlas.shape(1), 3});
  std::copy_n(atlas.data(), atlas.size(), texels.data());
  const auto drawn = [](const raster::PaintedMesh& body, const Array<float, 2>& paint) {
    const auto camera = geometry::orbit_camera(0.7, 0.4, 6, {0, 0, 0}, 1);
    const auto view = raster::texture_operator<float>(body, camera, 64, 64, raster::Light{}, 2);
    return raster::render(view, image::in_space(body.space, paint));
  };
  const auto own = drawn(car, colours), other = drawn(written, texels);
  double most = 0, brightest = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    most = std::max(most, static_cast<double>(std::abs(own.data()[i] - other.data()[i])));
    brightest = std::max(brightest, static_cast<double>(own.data()[i]));
  }
  CHECK(brightest > 0.1);
  CHECK(most < 0.02);  // bytes, and lookups in charts of 16 texels
  CHECK_THROWS_WITH(
      io::write_painted_glb(folder.path("painted.glb"), car, tapestry::zeros<float, 3>({4, 4, 3})),
      contains("texture is [4, 4, 3], expected [") && contains("the charts of the faces"));
  CHECK_NOTHROW(io::write_painted_glb(folder.path("painted.glb"), car, atlas));
}
