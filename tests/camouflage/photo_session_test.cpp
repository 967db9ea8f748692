#include <tapestry/camouflage/photo_session.hpp>

#include <tapestry/image/over.hpp>

#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
image::Conditions moving_camera(double turn, double roll, double zoom) {
  image::Conditions conditions;
  conditions.turn_degrees = turn;
  conditions.roll_degrees = roll;
  conditions.zoom = zoom;
  return conditions;
}

/// The box around the pixels that are not black in a picture of a white car on black.
detect::Box box_of_white(const Array<double, 3>& picture) {
  double left = 1e9, right = -1, top = 1e9, bottom = -1;
  for (std::size_t y = 0; y < picture.shape(0); ++y)
    for (std::size_t x = 0; x < picture.shape(1); ++x) {
      if (picture(y, x, 0) <= 0.02) continue;
      left = std::min(left, static_cast<double>(x)), right = std::max(right, static_cast<double>(x + 1));
      top = std::min(top, static_cast<double>(y)), bottom = std::max(bottom, static_cast<double>(y + 1));
    }
  return detect::box_from_corners(left, top, right, bottom);
}
}  // namespace

TEST_CASE("a shot's target surrounds the car in the shot's picture", "[camouflage][conditions]") {
  const auto car = test::tiny_car();
  auto store = test::tiny_store<double>(car, 3);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const auto view = store.view(i);
      const auto shot = camouflage::draw_shot(*view, moving_camera(6, 8, 0.2), Random(seed), true);
      const auto& coverage = view->paint_to_picture->coverage;
      Array<double, 3> white(Extents<3>{coverage.shape(0), coverage.shape(1), 3});
      for (std::size_t p = 0; p < white.size(); ++p) white.data()[p] = coverage.data()[p / 3] > 0 ? 1 : 0;
      const Array<double, 3> black = xt::zeros_like(view->background);
      const auto picture = image::transformed(
          image::over(white, tapestry::filled<double, 2>({coverage.shape(0), coverage.shape(1)}, 1.0), black,
                      view->window.top, view->window.left),
          shot.chain);
      const auto seen = box_of_white(picture);
      INFO("view " << i << ", seed " << seed);
      CHECK(std::abs(seen.left() - shot.target.left()) <= 1.5);
      CHECK(std::abs(seen.right() - shot.target.right()) <= 1.5);
      CHECK(std::abs(seen.top() - shot.target.top()) <= 1.5);
      CHECK(std::abs(seen.bottom() - shot.target.bottom()) <= 1.5);
      if (std::abs(seen.cx - view->target.cx) > 1) ++moved;
    }
  CHECK(moved > 10);
}

TEST_CASE("a camera that would lose the car is held still", "[camouflage][conditions][hard]") {
  const auto car = test::tiny_car();
  auto store = test::tiny_store<double>(car, 1);
  const auto view = store.view(0);
  std::size_t held = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const auto shot = camouflage::draw_shot(*view, moving_camera(60, 0, 0), Random(seed), true);
    if (shot.chain.empty()) {
      ++held;
      CHECK(shot.target.cx == view->target.cx);
    }
    CHECK(shot.target.area() > 0);
    CHECK(shot.target.left() >= 0);
    CHECK(shot.target.right() <= static_cast<double>(view->background.shape(1)));
  }
  CHECK(held > 3);
}

TEST_CASE("sessions are the same for a seed and other for another", "[camouflage][conditions]") {
  const auto car = test::tiny_car();
  auto store = test::tiny_store<float>(car, 2);
  const std::vector<std::shared_ptr<const camouflage::View<float>>> views{store.view(0), store.view(1)};
  const auto draw = [&](std::uint64_t seed) {
    return camouflage::draw_session<float>(views, image::physical_conditions, Random(seed), true);
  };
  const auto one = draw(1), again = draw(1), other = draw(2);
  REQUIRE(one.shots.size() == 2);
  CHECK(one.shots[1].target.cx == again.shots[1].target.cx);
  CHECK(one.print->matrix == again.print->matrix);
  CHECK(one.print->matrix != other.print->matrix);
  CHECK(one.shots[0].target.cx != other.shots[0].target.cx);
}
