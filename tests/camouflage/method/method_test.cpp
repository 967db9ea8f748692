#include <tapestry/camouflage/method/methods.hpp>

#include "../../support/random_array.hpp"
#include "../../support/refusal.hpp"
#include "../../support/stepped_car.hpp"

using namespace tapestry;
using Method = camouflage::Method<double>;

namespace {
/// Which of the six strips of an atlas of 24 × 48, see tiny_car().
std::size_t strip_of(std::size_t texel) { return texel % 48 / 8; }

std::size_t painted_count(const Method& method) {
  return static_cast<std::size_t>(std::count_if(method.row_of_texel->begin(), method.row_of_texel->end(),
                                                [](std::size_t row) { return row != Method::unpainted; }));
}

Array<double, 2> some_parameter(const Method& method, std::size_t texel_count) {
  return camouflage::first_parameter(method, test::random_array<double>({texel_count, 3}, 4, -1, 1));
}
}  // namespace

TEST_CASE("fca paints as there was no choice of methods, bit for bit", "[camouflage][method]") {
  const auto car = test::tiny_car();
  const auto start = test::random_array<float>({car.layout.texel_count(car.mesh), 3}, 1, -2, 2);
  const auto method = camouflage::method_by_name<float>("fca", car, 1);
  CHECK((camouflage::first_parameter(method, start) == start));
  CHECK((camouflage::method_colours(method, start) == camouflage::texture_colours(start)));
}

TEST_CASE("a solid is one colour, and begins as the first texel", "[camouflage][method]") {
  const auto car = test::tiny_car();
  const auto method = camouflage::method_by_name<double>("solid", car, 1);
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -2, 2);
  const auto parameter = camouflage::first_parameter(method, start);
  REQUIRE(parameter.shape() == Extents<2>{1, 3});
  const auto colours = camouflage::method_colours(method, parameter);
  for (std::size_t i = 0; i < colours.size(); ++i)
    REQUIRE(colours.data()[i] == Approx(0.5 * (std::tanh(start.data()[i % 3]) + 1)).epsilon(1e-15));
}

TEST_CASE("random is noise that no parameter moves, and the seed's", "[camouflage][method]") {
  const auto car = test::tiny_car();
  const auto method = camouflage::method_by_name<double>("random", car, 1);
  CHECK_FALSE(method.is_optimised);
  const auto count = car.layout.texel_count(car.mesh);
  const auto colours = camouflage::method_colours(method, test::random_array<double>({count, 3}, 2, -2, 2));
  CHECK((colours == camouflage::method_colours(method, tapestry::zeros<double, 2>({count, 3}))));
  CHECK(std::set<double>(colours.begin(), colours.end()).size() == colours.size());
  CHECK(*std::min_element(colours.begin(), colours.end()) >= 0.02);
  CHECK(*std::max_element(colours.begin(), colours.end()) <= 0.98);
  const auto other = camouflage::method_by_name<double>("random", car, 2);
  CHECK((other.least != method.least));
}

TEST_CASE("camou repeats 16 by 16 colours", "[camouflage][method]") {
  const std::size_t height =
      GENERATE(std::size_t(12), std::size_t(64), std::size_t(65), std::size_t(100), std::size_t(128));
  const std::size_t edge = height > 64 ? 2 : 1;  // texels a colour
  const auto car = test::tiny_car(height);
  const auto method = camouflage::method_by_name<double>("camou", car, 1);
  REQUIRE(method.row_count == 256);
  const auto& rows = *method.row_of_texel;
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < 2 * height; ++x)
      REQUIRE(rows[y * 2 * height + x] == y / edge % 16 * 16 + x / edge % 16);
}

TEST_CASE("panels are where a stepped car has them", "[camouflage][method]") {
  const auto car = test::stepped_car();
  std::vector<std::size_t> counts(camouflage::panel_count, 0);
  std::size_t before = 0;
  for (const auto& texel : camouflage::panel_texels("upc", car)) {
    REQUIRE((before == 0 || texel.texel > before));
    before = texel.texel;
    ++counts[static_cast<std::size_t>(texel.panel)];
    const auto [a, b, h] = texel.position;
    // Strips of the atlas: front, rear, left, right, top, and the roof's.
    const std::size_t strip = strip_of(texel.texel);
    switch (texel.panel) {
      case camouflage::Panel::roof:
        REQUIRE(strip == 5);
        REQUIRE(h == Approx(1));
        break;
      case camouflage::Panel::hood:
        REQUIRE(strip == 4);
        REQUIRE((a > 0.35 && a < 0.95));
        REQUIRE(texel.up == Approx(2 * a));
        REQUIRE(texel.right == Approx(-0.9 * b));
        break;
      case camouflage::Panel::left_doors:
        REQUIRE(strip == 2);
        REQUIRE(texel.right == Approx(-2 * a));
        REQUIRE(b == Approx(1));
        break;
      case camouflage::Panel::right_doors:
        REQUIRE(strip == 3);
        REQUIRE(texel.right == Approx(2 * a));
        REQUIRE(b == Approx(-1));
        break;
    }
  }
  for (const std::size_t count : counts) CHECK(count >= 24);
  CHECK(counts[2] == counts[3]);
}

TEST_CASE("a patch is the same square on every panel, and nothing else changes", "[camouflage][method]") {
  const auto car = test::stepped_car();
  const auto method = camouflage::method_by_name<double>("planar_patch", car, 1);
  const auto edge = static_cast<std::size_t>(std::lround(std::sqrt(method.row_count)));
  REQUIRE(edge * edge == method.row_count);
  CHECK(edge >= 3);
  const auto own = camouflage::own_colours<double>(car);
  const auto parameter = some_parameter(method, own.shape(0));
  const auto colours = camouflage::method_colours(method, parameter);
  const auto pixels = camouflage::texture_colours(parameter);
  std::vector<std::array<double, 4>> extents(camouflage::panel_count, {1e9, -1e9, 1e9, -1e9});
  std::vector<std::set<std::size_t>> seen(camouflage::panel_count);
  for (const auto& texel : camouflage::panel_texels("planar_patch", car)) {
    const std::size_t row = (*method.row_of_texel)[texel.texel];
    if (row == Method::unpainted) continue;
    auto& [left, right, bottom, top] = extents[static_cast<std::size_t>(texel.panel)];
    left = std::min(left, texel.right), right = std::max(right, texel.right);
    bottom = std::min(bottom, texel.up), top = std::max(top, texel.up);
    seen[static_cast<std::size_t>(texel.panel)].insert(row);
  }
  std::size_t on_panels = 0;
  for (const auto& texel : camouflage::panel_texels("planar_patch", car)) {
    const std::size_t row = (*method.row_of_texel)[texel.texel];
    if (row == Method::unpainted) continue;
    ++on_panels;
    const auto& [left, right, bottom, top] = extents[static_cast<std::size_t>(texel.panel)];
    const double middle = (left + right) / 2;  // upright: the upper rows above, the left columns on the left
    if (row / edge + 1 < edge / 2) REQUIRE(texel.up > (bottom + top) / 2);
    if (row % edge + 1 < edge / 2) REQUIRE(texel.right < middle);
  }
  CHECK(on_panels == painted_count(method));  // none off the panels
  for (const auto& rows : seen) CHECK(rows.size() >= 2);
  for (std::size_t texel = 0; texel < colours.shape(0); ++texel)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t row = (*method.row_of_texel)[texel];
      REQUIRE(colours(texel, c) == (row == Method::unpainted ? own(texel, c) : pixels(row, c)));
    }
}

TEST_CASE("upc stays within its bound of a picture, and off the panels nothing changes",
          "[camouflage][method]") {
  const auto car = test::stepped_car();
  const auto method = camouflage::method_by_name<double>("upc", car, 1);
  const auto own = camouflage::own_colours<double>(car);
  const auto texels = camouflage::panel_texels("upc", car);
  CHECK(painted_count(method) == texels.size());
  const auto picture = camouflage::method_colours(method, tapestry::zeros<double, 2>({method.row_count, 3}));
  const auto brightest =
      camouflage::method_colours(method, tapestry::filled<double, 2>({method.row_count, 3}, 30.0));
  const auto darkest =
      camouflage::method_colours(method, tapestry::filled<double, 2>({method.row_count, 3}, -30.0));
  for (std::size_t texel = 0; texel < own.shape(0); ++texel)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t row = (*method.row_of_texel)[texel];
      if (row == Method::unpainted) {
        REQUIRE(brightest(texel, c) == own(texel, c));
        continue;
      }
      REQUIRE(brightest(texel, c) - picture(texel, c) <= camouflage::upc_bound + 1e-12);
      REQUIRE(picture(texel, c) - darkest(texel, c) <= camouflage::upc_bound + 1e-12);
      REQUIRE(darkest(texel, c) >= 0);
    }
  CHECK((method.least == camouflage::method_by_name<double>("upc", car, 1).least));
  CHECK((method.least != camouflage::method_by_name<double>("upc", car, 2).least));
}

TEST_CASE("das paints the panels, each texel for itself, and das_full all", "[camouflage][method]") {
  const auto car = test::stepped_car();
  const auto method = camouflage::method_by_name<double>("das", car, 1);
  CHECK(method.attention == 1);
  std::size_t row = 0;
  for (const auto& texel : camouflage::panel_texels("das", car))
    REQUIRE((*method.row_of_texel)[texel.texel] == row++);
  CHECK(painted_count(method) == row);
  CHECK(method.row_count == row);
  const auto full = camouflage::method_by_name<double>("das_full", car, 1);
  CHECK(full.attention == 1);
  CHECK(full.row_of_texel == nullptr);
}

TEST_CASE("a method is refused a car that it cannot paint", "[camouflage][method][bad_input]") {
  const auto cubes = test::tiny_car(12, raster::TextureKind::cube);
  for (const auto& row : camouflage::methods<double>()) {
    INFO(row.name);
    CHECK_NOTHROW(row.make(test::stepped_car(), 1));
    if (row.traits.needs_atlas)
      CHECK_THROWS_WITH(row.make(cubes, 1), contains("the method " + row.name + " paints parts of an atlas"));
    else
      CHECK_NOTHROW(row.make(cubes, 1));
  }
  auto front = test::stepped_car();
  std::fill(front.painted.begin() + 2, front.painted.end(), std::uint8_t(0));
  test::check_refused(ErrorKind::mismatch,
                      "the method upc paints roof, hood and doors, of which no painted face is one",
                      [&] { (void)camouflage::method_by_name<double>("upc", front, 1); });
  auto coarse = test::stepped_car();
  coarse.layout.height = 2;  // a line of texels a side of the car
  coarse.layout.width = 6;
  test::check_refused(ErrorKind::mismatch, "the method planar_patch needs a panel of more than a line",
                      [&] { (void)camouflage::method_by_name<double>("planar_patch", coarse, 1); });
  Method beyond = camouflage::method_by_name<double>("solid", cubes, 1);
  beyond.row_count = 0;
  CHECK_THROWS_WITH(camouflage::require_sound(beyond), "a method paints texel 0 by row 0 of 0");
  Method loose = camouflage::method_by_name<double>("random", cubes, 1);
  loose.greatest = tapestry::zeros<double, 2>({1, 3});
  CHECK_THROWS_AS(camouflage::require_sound(loose), ShapeError);
  CHECK_THROWS_WITH(camouflage::method_by_name<double>("dta", cubes, 1), "no method is called 'dta'");
  CHECK_THROWS_AS(camouflage::first_parameter(camouflage::method_by_name<double>("solid", cubes, 1),
                                              tapestry::zeros<double, 2>({3, 3})),
                  ShapeError);
}

TEST_CASE("a method is as its row says", "[camouflage][method]") {
  for (const auto& row : camouflage::methods<double>()) {
    INFO(row.name);
    const auto method = row.make(test::stepped_car(), 1);
    CHECK((method.attention > 0) == row.traits.maps_attention);
    CHECK((method.shape != nullptr) == row.traits.moves_shape);
    CHECK(method.is_optimised == row.traits.is_optimised);
  }
}
