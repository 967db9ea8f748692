// Paints a car so that a detector loses it: the whole pipeline on the tape, step by step.
#include <cstdio>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/image/over.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/optim/adam.hpp>
#include <tapestry/raster/painted.hpp>

using namespace tapestry;

int main() {
  const std::string assets = TAPESTRY_ASSETS "/";
  const auto detector =
      io::read_detector<float>({.weights = assets + "detector.weights", .config = assets + "detector.cfg"});
  const auto car = raster::painted(io::read_obj(assets + "car_sedan.obj").mesh, {.material = "body"});

  // Constants: for each photograph the map from paint to picture, the background, and the place of the car.
  std::vector<std::shared_ptr<const raster::CompactOperator<float>>> views;
  std::vector<image::Backdrop<float>> backdrops;
  std::vector<loss::Target> targets;
  for (const char* name : {"003", "027", "041", "058"}) {
    const auto frame = io::read_frame(assets + "frames/test/" + name + ".npz");
    views.push_back(std::make_shared<const raster::CompactOperator<float>>(raster::compacted(
        raster::texture_operator<float>(car, *frame.camera, detector.input_height(), detector.input_width(),
                                        io::frame_light(frame, car.space)))));
    backdrops.emplace_back(image::from_bytes<float>(frame.image), views.back());
    targets.push_back({frame.label->class_index, frame.label->box});
  }

  auto parameter = zeros<float, 2>({car.layout.texel_count(car.mesh), 3});  // mid grey
  optim::Adam<float> adam(parameter.size(), {});
  Tape<float> tape;
  for (int step = 0; step <= 40; ++step) {
    tape.clear();
    const auto scope = tape.activate();
    const auto paint = tape.input(parameter);
    const ArrayVariable<float, 2> colours = (tanh(paint) + 1.0F) / 2.0F;
    const auto light = image::linearised(colours);
    const auto pictures = image::over(raster::render(views, light), backdrops, car.space);
    const auto logits = detect::forward(detector, pictures);
    const auto found = loss::adversarial(detector, logits, targets);
    if (step % 20 == 0)
      std::printf("step %2d: objectness %.2f\n", step, static_cast<double>(found.objectness.value()));
    tape.reverse(found.total);
    adam.step(parameter, paint.adjoint());
  }
}
