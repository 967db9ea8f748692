// Saves the gradient of a detector's surest score with respect to a photograph as a picture: the pixels that
// decide it. Takes an .onnx or a .weights file, the latter with its .cfg beside it, and a photograph.
#include <cstdio>
#include <tapestry/detect/box_decode_variable.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/read_detector.hpp>

using namespace tapestry;

int main(int argc, char** argv) {
  const std::filesystem::path weights = argc > 1 ? argv[1] : TAPESTRY_ASSETS "/detector.weights";
  const std::string photograph = argc > 2 ? argv[2] : TAPESTRY_ASSETS "/frames/test/027.npz";
  auto config = weights;
  const auto detector = io::read_detector<float>(
      {.weights = weights, .config = io::is_onnx(weights) ? "" : config.replace_extension("cfg")});
  Tape<float> tape;
  const auto scope = tape.activate();
  const auto picture = tape.input(io::read_input(detector, photograph));
  const auto score = detect::best_score(detector, detect::forward(detector, picture));
  tape.reverse(score);
  io::write_gradient("input_gradient.png", picture.adjoint());
  std::printf("score %.3f, its gradient in input_gradient.png\n", static_cast<double>(score.value()));
}
