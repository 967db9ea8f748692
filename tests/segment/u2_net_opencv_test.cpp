#include <tapestry/segment/u2_net.hpp>

#include <opencv2/dnn.hpp>

#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/segment/u2_net_description.hpp>

#include "../support/paths.hpp"
#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("OpenCV computes the same masks from the files that are written", "[segment][u2_net][opencv]") {
  const TemporaryFolder folder;
  const std::string random = folder.path("random.onnx");
  const auto small = segment::u2_net_description({64, {{4, 4, 8}, {3, 4, 8}}, 4, 8}, 3);
  std::map<std::string, nn::Shape> shapes;
  for (const std::string& output : small.outputs) shapes[output] = {1, 1, 64, 64};
  io::write_onnx(random, small, shapes);
  for (const std::string& path : {random, test::in_sources("examples/assets/segmenter.onnx")}) {
    INFO(path);
    const auto description = io::read_onnx(path);
    const nn::Network<float> network(description);
    const std::size_t side = network.input_shape(0)[2];
    auto values = random_array<float>({1, 3, side, side}, 4, -2, 2);
    nn::Buffer<float> input(values.size());
    std::copy_n(values.data(), values.size(), input.data());
    nn::NetworkPass<float> pass;
    network.forward({input.data()}, pass);

    auto net = cv::dnn::readNetFromONNX(path);
    const int extents[] = {1, 3, static_cast<int>(side), static_cast<int>(side)};
    net.setInput(cv::Mat(4, extents, CV_32F, values.data()));
    for (std::size_t i = 0; i < description.outputs.size(); ++i) {
      const cv::Mat expected = net.forward(description.outputs[i]);
      REQUIRE(expected.total() == side * side);
      const std::vector<float> own(pass.output(i), pass.output(i) + side * side);
      const std::vector<float> theirs(expected.ptr<float>(), expected.ptr<float>() + side * side);
      CHECK(relative_distance(own, theirs) <= 1e-5);
    }
  }
}
