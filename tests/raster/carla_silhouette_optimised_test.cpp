#include <iostream>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/visibility.hpp>

#include "../support/catch.hpp"
#include "../support/paths.hpp"

using tapestry::Array;

namespace {
/// First and last row and column of the pixels above 0.
std::array<long, 4> box_of(const Array<float, 2>& mask) {
  std::array<long, 4> box{1L << 30, -1, 1L << 30, -1};
  for (std::size_t row = 0; row < mask.shape(0); ++row) {
    for (std::size_t column = 0; column < mask.shape(1); ++column) {
      if (mask(row, column) <= 0) continue;
      box = {std::min(box[0], static_cast<long>(row)), std::max(box[1], static_cast<long>(row)),
             std::min(box[2], static_cast<long>(column)), std::max(box[3], static_cast<long>(column))};
    }
  }
  return box;
}

/// Intersection over union of the pixels above 0.
double overlap(const Array<float, 2>& a, const Array<float, 2>& b) {
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    both += a.data()[i] > 0 && b.data()[i] > 0 ? 1 : 0;
    either += a.data()[i] > 0 || b.data()[i] > 0 ? 1 : 0;
  }
  return static_cast<double>(both) / static_cast<double>(std::max<std::size_t>(either, 1));
}
}  // namespace

TEST_CASE("the CARLA camera reproduces the published masks", "[raster][carla]") {
  const std::string shared = tapestry::test::in_shared("");
  const std::string mesh_path = shared + "data/mesh/audi_et_te.obj";
  if (tapestry::test::is_absent(mesh_path)) return;
  const auto mesh = tapestry::geometry::normalise_mesh(tapestry::io::read_obj(mesh_path).mesh);
  for (const char* number : {"1", "12501", "12502", "12503", "12504", "12505"}) {
    const auto frame = tapestry::io::read_frame(shared + "data/carla/data" + number + ".npz");
    const auto mask = tapestry::io::read_mask(shared + "data/carla/mask" + number + ".png");
    const auto camera = tapestry::io::camera_of(frame);
    const auto silhouette = tapestry::raster::coverage_of(
        tapestry::raster::visibility(mesh, camera, mask.shape(0), mask.shape(1), 2));
    const auto found = box_of(silhouette), expected = box_of(mask);
    long off = 0;
    for (std::size_t side = 0; side < 4; ++side) off = std::max(off, std::labs(found[side] - expected[side]));
    INFO("frame " << number << ", box off by " << off << " px");
    CHECK(overlap(silhouette, mask) >= 0.995);
    CHECK(off <= 1);
    std::cout << "mask" << number << ": IoU " << overlap(silhouette, mask) << ", box off by " << off
              << " px\n";
  }
}
