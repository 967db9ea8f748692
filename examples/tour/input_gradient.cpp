// Shows what a detector's belief in a car rests on: the gradient of its surest box's score with respect to a
// photograph, saved as a picture.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/detect/box_decode_variable.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/colour.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/read_detector.hpp>

using namespace tapestry;

int main() {
  const std::string assets = TAPESTRY_ASSETS "/";
  const auto detector =
      io::read_detector<float>({.weights = assets + "detector.weights", .config = assets + "detector.cfg"});
  const auto photograph = image::from_bytes<float>(io::read_frame(assets + "frames/test/027.npz").image);
  Tape<float> tape;
  const auto scope = tape.activate();
  const auto picture = tape.input(detector.input(photograph));
  Variable<float> score = 0;  // the largest objectness · class of all candidates
  for (const auto& head : detect::decode(detector, detect::forward(detector, picture))) {
    const ArrayVariable<float, 3> scores = detect::confidences(head);
    score = max(score, element(largest_along(largest_along(scores, 2), 1), {0}));
  }
  tape.reverse(score);
  auto gradient = image::picture_of(picture.adjoint(), 0);
  float largest = 0;
  for (const float value : gradient.storage()) largest = std::max(largest, std::abs(value));
  for (float& value : gradient.storage())
    value = 0.5F + 0.5F * std::cbrt(value / largest);  // grey: no effect
  io::write_image("input_gradient.png", gradient);
  std::printf("score %.3f, its gradient in input_gradient.png\n", static_cast<double>(score.value()));
}
