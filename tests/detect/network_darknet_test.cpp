#pragma GCC diagnostic ignored "-Wshadow"  // darknet.h has global names such as image and layer

#include <tapestry/detect/network.hpp>
#include <tapestry/image/planes.hpp>
#include <tapestry/io/darknet/cfg_file.hpp>
#include <tapestry/io/darknet/weight_file.hpp>

#include <cmath>
#include <filesystem>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"
#include "../support/random_detector.hpp"
#include "../support/relative_distance.hpp"
#include "../support/temporary_folder.hpp"

extern "C" {
#include <darknet.h>
}

namespace detect = tapestry::detect;
namespace io = tapestry::io;
using namespace tapestry::test;

namespace {
/// Raw inputs of Darknet's yolo layers for the same files and pictures, compared head by head.
///
/// Darknet on a CPU divides by √variance + 1e-6 where Tapestry takes √(variance + 1e-5); with variances of
/// at least ½ the factor differs by at most 1e-5, so the written variances are moved to make up for it.
void check_against_darknet(const detect::Network<float>& network, const std::string& cfg_path,
                           double tolerance) {
  const TemporaryFolder folder;
  const std::string weights_path = folder.path("random.weights");
  auto moved = network;
  for (const auto& block : network.layout().blocks) {
    if (block.role != detect::ParameterRole::variance) continue;
    for (std::size_t i = 0; i < block.count; ++i) {
      const double variance = static_cast<double>(network.parameters()[block.offset + i]);
      const double root = std::sqrt(variance + network.config().batch_norm_epsilon) - 1e-6;
      moved.parameters()[block.offset + i] = static_cast<float>(root * root);
    }
  }
  io::write_weight_file(weights_path, moved);
  const auto images = random_array<float>({1, network.input_height(), network.input_width(), 3}, 7);
  detect::Pass<float> pass;
  network.forward(images, pass);

  std::string cfg_name = cfg_path;
  std::string weights_name = weights_path;
  ::network* darknet = load_network(cfg_name.data(), weights_name.data(), 0);
  set_batch_network(darknet, 1);
  auto planes = tapestry::image::planes_of(images);
  network_predict(darknet, planes.data());
  std::size_t head = 0;
  for (int i = 0; i < darknet->n; ++i) {
    if (darknet->layers[i].type != YOLO) continue;
    const ::layer& before = darknet->layers[i - 1];  // a linear convolution, whose output are the logits
    REQUIRE(static_cast<std::size_t>(before.outputs) == pass.logits[head].size());
    const double distance =
        relative_distance(pass.logits[head].data(), before.output, pass.logits[head].size());
    INFO("head " << head << ": relative L2 distance " << distance);
    CHECK(distance <= tolerance);
    ++head;
  }
  CHECK(head == pass.logits.size());
  free_network(darknet);
}
}  // namespace

TEST_CASE("logits equal those of Darknet for every common layer", "[detect][darknet]") {
  const TemporaryFolder folder;
  const std::string path = folder.write("some.cfg", common_layers);
  check_against_darknet(random_detector<float>(io::read_network_config(path), 3), path, 5e-6);
}

TEST_CASE("unequal shortcuts and scaled upsampling equal those of Darknet", "[detect][darknet]") {
  const TemporaryFolder folder;
  std::string cfg = unequal_layers;
  cfg.insert(cfg.find("[upsample]") + 11, "scale=-.75\n");  // which OpenCV passes over
  const std::string path = folder.write("some.cfg", cfg);
  check_against_darknet(random_detector<float>(io::read_network_config(path), 3), path, 5e-6);
}

TEST_CASE("logits of yolov3-tiny equal those of Darknet", "[detect][darknet]") {
  const std::string path = "/usr/share/darknet/cfg/yolov3-tiny.cfg";
  if (!std::filesystem::exists(path)) {
    WARN("skipped: no " << path);
    return;
  }
  check_against_darknet(random_detector<float>(io::read_network_config(path), 3), path, 5e-6);
}
