// Finds objects in a photograph with a detector from an ONNX file, then changes the photograph until the
// surest of them is no longer found.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/graph_detector.hpp>
#include <tapestry/detect/network_variable.hpp>
#include <tapestry/detect/recognised_detector.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/colour.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/loss/adversarial_variable.hpp>
#include <tapestry/optim/adam.hpp>
#include <vector>

using namespace tapestry;

std::vector<detect::Detection> detections(const detect::GraphDetector<float>& detector,
                                          const Array<float, 4>& pictures) {
  detect::Pass<float> pass;
  detector.forward(pictures, pass);
  return detect::suppress(
      detect::decode(detector.heads(), pass.logits, 0, 0.3, detector.input_height(), detector.input_width()),
      0.5);
}

int main(int count, char** arguments) {
  if (count != 3) {
    std::fprintf(stderr, "usage: onnx_detector MODEL PHOTOGRAPH\n");
    return 2;
  }
  const auto description = io::read_onnx(arguments[1]);
  const auto kind = detect::recognised_detector(description);
  if (!kind) {
    std::fprintf(stderr, "%s: no detector that is known\n", arguments[1]);
    return 1;
  }
  const detect::GraphDetector<float> detector(description, *kind);
  const auto photograph = image::from_bytes<float>(io::read_image(arguments[2]));
  auto pictures =
      image::batch_of(image::letterboxed(photograph, detector.input_height(), detector.input_width(), 0.5F));
  const auto found = detections(detector, pictures);
  for (const auto& one : found)
    std::printf("class %zu, %.2f, at %.0f, %.0f\n", one.class_index, one.confidence, one.box.cx, one.box.cy);
  if (found.empty()) return 0;

  const std::vector<loss::Target> targets{{found.front().class_index, found.front().box}};
  optim::Adam<float> adam(pictures.size(), {.learning_rate = 0.01});
  const auto pass = std::make_shared<detect::Pass<float>>();
  Tape<float> tape;
  for (int step = 0; step < 20; ++step) {
    tape.clear();
    const auto scope = tape.activate();
    const auto picture = tape.input(pictures);
    const ArrayVariable<float, 4> change = picture - pictures;
    const auto terms = loss::adversarial(detector, detect::forward(detector, picture, pass), targets);
    const Variable<float> total = terms.total + 1e-4F * sum(change * change);
    tape.reverse(total);
    adam.step(pictures, picture.adjoint());
    for (float& value : pictures.storage()) value = std::clamp(value, 0.0F, 1.0F);
    std::printf("step %2d: %.3f\n", step, static_cast<double>(total.value()));
  }
  io::write_image("hidden.png", image::picture_of(pictures, 0));
  std::printf("%zu found afterwards\n", detections(detector, pictures).size());
}
