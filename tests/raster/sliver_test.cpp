// Faces so thin in a picture that a sample on one stands for far more than the face's area.
#include <tapestry/raster/detail/vertex_gradient/sliver.hpp>
#include <tapestry/raster/geometry_picture.hpp>

#include "../support/catch.hpp"
#include "../support/vertex_gradient_scene.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Mesh, geometry::Vector3;

namespace {
/// A square over the whole picture, and before it a face that is 2·half_width px wide, by the grid of 4 x 4
/// samples placed so that it still owns a column of samples: coordinates are rounded to 1/256 of a sample,
/// the face's left edge falls on the samples' centres and its third corner beside it.
/// \param depth  of the third corner; 2, as the others have: a needle; else a face seen edge-on
Mesh square_behind_sliver(double half_width, double depth) {
  const double between = (20 + 128.5 / 256) / 4;  // px, where rounding changes direction
  const auto at = [](double column, double row, double z) {
    const double half = side / 2.0;
    return Vector3{(column / half - 1) * z, (row / half - 1) * z, z};
  };
  return triangle_soup({{Vector3{-9, -9, 5}, Vector3{27, -9, 5.5}, Vector3{-9, 27, 6}},
                        {at(between - half_width, 3, 2), at(between + half_width, 8, depth),
                         at(between - half_width, 13, 2)}});
}

template <class Gradient>
void check_largest(const Gradient& gradient) {
  const double finest = largest_component(gradient(8));
  REQUIRE(finest > 0);
  for (const std::size_t samples : {1U, 2U, 4U}) {
    CAPTURE(samples);
    CHECK(largest_component(gradient(samples)) <= 3 * finest);
  }
}
}  // namespace

// The sliver owns the samples of one column in the grid of 4 x 4, and none in any other grid.
TEST_CASE("a face edge-on or as thin as a needle that owns samples outweighs no other",
          "[raster][vertex_gradient][hard_case]") {
  for (const double half_width : {1e-4, 1e-7, 1e-10}) {
    for (const double depth : {2.0, 3.5}) {
      CAPTURE(half_width, depth);
      const Mesh mesh = square_behind_sliver(half_width, depth);
      const auto buffer = raster::visibility(mesh, Camera{}, side, side, 4);
      REQUIRE(std::count(buffer.face.begin(), buffer.face.end(), 1) >= 20);
      const auto check = [&](const auto& scene) {
        check_largest([&](std::size_t samples) {
          return scene.gradient(smooth_weights(), raster::BoundaryIntegral{samples});
        });
      };
      for (const auto& layout : {vertex, small_atlas, cube}) {
        check(Scene<>{mesh, layout});
        check(Scene<raster::Light>{mesh, layout, warm});
      }
    }
  }
}

TEST_CASE("depth, position and normal of a sliver that owns samples outweigh no other",
          "[raster][geometry_picture][hard_case]") {
  Array<double, 2> depth_weights(Extents<2>{side, side});
  const auto weights = smooth_weights();
  for (std::size_t i = 0; i < depth_weights.size(); ++i) depth_weights.data()[i] = weights.data()[3 * i];
  for (const double half_width : {1e-4, 1e-7, 1e-10}) {
    for (const double depth : {2.0, 3.5}) {
      CAPTURE(half_width, depth);
      const Mesh mesh = square_behind_sliver(half_width, depth);
      const auto check = [&](auto output, const auto& picture_adjoint) {
        check_largest([&](std::size_t samples) {
          std::vector<Vector3> gradient(mesh.positions.size(), Vector3{0, 0, 0});
          raster::geometry_picture_adjoint<decltype(output)>(mesh, Camera{}, picture_adjoint, gradient,
                                                             samples);
          return gradient;
        });
      };
      check(raster::Depth{}, depth_weights);
      check(raster::SurfacePosition{}, weights);
      check(raster::Normal{}, weights);
    }
  }
}

TEST_CASE("the factor of a sliver is the square of ten times its height over the distance of samples",
          "[raster][vertex_gradient]") {
  // A right triangle with legs w and 1 at depth 2, its height w/√(1 + w²); rays half as far apart as points.
  const auto factor = [](double w, double step) {
    return raster::detail::sliver_factor({Vector3{0, 0, 2}, Vector3{w, 0, 2}, Vector3{0, 1, 2}}, {1, 2, 1},
                                         {step / 2, step / 2});
  };
  for (const double w : {1e-9, 1e-3, 0.01})
    CHECK(factor(w, 0.5) == Approx(std::pow(10 * w / 0.5, 2) / (1 + w * w)).epsilon(1e-12));
  CHECK(factor(0.06, 0.5) == 1);
  CHECK(factor(0, 0.5) == 0);  // without area
  // Tilted by the angle whose cosine is c about its longer leg, before the eye: c times as thin.
  const double c = 1e-3, sine = std::sqrt(1 - c * c);
  const double tilted = raster::detail::sliver_factor(
      {Vector3{0, -0.5, 2}, Vector3{0, 0.5, 2}, Vector3{1e-6 * c, 0, 2 + 1e-6 * sine}}, {1, 1, 1},
      {0.5, 0.5});
  CHECK(tilted == Approx(1e-16).epsilon(1e-5));
}

TEST_CASE("a face of a hundredth of a sample's cell, but no sliver, counts as its samples do",
          "[raster][vertex_gradient]") {
  // Faces that samples hit stand for faces that none hits.
  const std::array<Vector3, 3> small{Vector3{0, 0, 1}, Vector3{0.0145, 0, 1}, Vector3{0, 0.0145, 1}};
  CHECK(raster::detail::sliver_factor(small, {0, 0, 1}, {0.1, 0.1}) == 1);
}
