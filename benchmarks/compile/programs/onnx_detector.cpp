// Finds objects in a photograph with a detector from an ONNX file, then changes the photograph until the
// surest of them is no longer found.
#include <cstdio>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/optim/adam.hpp>

using namespace tapestry;

int main(int count, char** arguments) {
  if (count != 3) {
    std::fprintf(stderr, "usage: onnx_detector MODEL PHOTOGRAPH\n");
    return 2;
  }
  const auto detector = io::read_detector<float>({.weights = arguments[1]});
  const auto photograph = image::from_bytes<float>(io::read_image(arguments[2]));
  auto pictures = detector.input(photograph);
  const auto found = detector.detections(detect::forward(detector, pictures));
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
  const auto left = detector.detections(detect::forward(detector, pictures));
  std::printf("%zu found afterwards\n", left.size());
}
