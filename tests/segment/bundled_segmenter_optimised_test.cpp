#include <iostream>
#include <tapestry/image/resize.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/segment/u2_net.hpp>

#include "../../examples/scenes/segmented_scene.hpp"
#include "../support/catch.hpp"
#include "../support/paths.hpp"

// Results of the bundled network: in scenes that it was not trained on, and in photographs of a simulator.

using namespace tapestry;

namespace {
segment::U2Net bundled() {
  return segment::U2Net(io::read_onnx(test::in_sources("examples/assets/segmenter.onnx")));
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}
}  // namespace

TEST_CASE("the bundled network finds cars in scenes that are new to it", "[segment][bundled][long]") {
  const auto network = bundled();
  CHECK(std::filesystem::file_size(test::in_sources("examples/assets/segmenter.onnx")) <= 300000);
  scenes::SceneOptions options;
  options.occluder_chance = 0;
  const Random source(0x5E6E57);
  std::vector<double> overlap(40);
  tapestry::parallel_for(overlap.size(), [&](std::size_t i) {
    const auto scene = scenes::draw_segmented(source.fork(i), options, 256);
    const auto mask = network(image::from_bytes<float>(scene.colours));
    overlap[i] = segment::mask_iou(segment::car_component(mask, scene.box), scenes::silhouette_of(scene));
  });
  INFO("mean IoU " << mean(overlap));
  CHECK(mean(overlap) >= 0.85);
}

TEST_CASE("what the bundled network finds in the frames of a simulator is told",
          "[segment][bundled][carla]") {
  const std::string folder = test::in_shared("data/carla/");
  if (test::is_absent(folder)) return;
  const auto network = bundled();
  std::vector<double> overlap;
  for (const char* number : {"1", "12501", "12502", "12503", "12504", "12505"}) {
    const auto frame = io::read_frame(folder + "data" + number + ".npz");
    const auto grey = io::read_mask(folder + "mask" + number + ".png");
    const auto mask = network(image::from_bytes<float>(frame.image));
    Array<float, 3> map({mask.shape(0), mask.shape(1), 1});
    std::copy_n(mask.data(), mask.size(), map.data());
    const auto resized = image::resize_bilinear(map, grey.shape(0), grey.shape(1));
    Array<float, 2> at_mask({grey.shape(0), grey.shape(1)});
    std::copy_n(resized.data(), resized.size(), at_mask.data());
    overlap.push_back(segment::mask_iou(segment::car_component(at_mask), grey));
    std::cout << "data" << number << ": IoU " << overlap.back() << '\n';
  }
  std::cout << "mean IoU on six frames " << mean(overlap) << '\n';
  CHECK(mean(overlap) >= 0);  // printed, not required: it was trained on drawn scenes alone
}
