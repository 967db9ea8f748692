// export_detector FOLDER: writes small detectors with random weights as ONNX models, for scripts.
#include <fstream>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/small_exports.hpp"

int main(int argc, char** argv) {
  namespace test = tapestry::test;
  if (argc != 2) return 2;
  const std::string folder(argv[1]);
  constexpr std::size_t size = 64;
  auto normalised = test::yolox_like(size);
  test::normalise_first(normalised);
  test::hide_constants(normalised);
  tapestry::io::write_onnx(folder + "/yolox.onnx", test::yolox_like(size));
  tapestry::io::write_onnx(folder + "/normalised.onnx", normalised);
  auto sharing = test::yolox_like(size);
  test::share_slope(sharing);
  tapestry::io::write_onnx(folder + "/sharing.onnx", sharing);
  tapestry::io::write_onnx(folder + "/nanodet.onnx", test::nanodet_like(size));
  tapestry::io::write_onnx(folder + "/yolov5.onnx",
                           test::yolov5_like(size, tapestry::detect::known_description("yolov5").anchors));
  std::ofstream(folder + "/yolov5.json") << R"({"head": "yolov5"})";
  const auto decoded = test::boxes_and_scores(size, 11);
  tapestry::io::write_onnx(folder + "/decoded.onnx", decoded);
  std::ofstream(folder + "/decoded.json")
      << R"({"head": "boxes_and_scores", "outputs": {"form": "corners_yx", "unit": "share", "score": "softmax", )"
      << R"("background": "first", "boxes": ")" << decoded.outputs[0] << R"(", "scores": ")"
      << decoded.outputs[1] << "\"}}\n";
}
