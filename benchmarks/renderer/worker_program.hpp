#pragma once
#include "../../examples/programs/shell/program.hpp"
#include "../support/serve.hpp"
#include "scene.hpp"

namespace tapestry::benchmarks {
struct WorkerOptions {
  std::string mesh{};  ///< OBJ file, or empty for the procedural car
  double distance = 5;
  std::size_t size = 256;  ///< width and height of the picture in pixels
  int threads = 1;
  std::string stage{}, variant{};
};

/// The main function of a program that runs one renderer, which is set up for one stage. run() does the stage
/// for every camera of the scene.
///
/// answer() is of the scene's first camera for visibility, the face of each sample as a number, −1 for none,
/// and for a frame, [size, size, 3]. Of scored_camera and scoring_weights() it is for texture-backward and
/// step, the derivative with respect to the red of each face, and for vertex-gradient, the derivatives along
/// scored_motions().
/// \param variants  the values of --variant, for the help
template <Engine Renderer>
int run_worker(int argc, char** argv, const std::string& variants) {
  auto app = shell::command_line(
      "Renders a car again and again, for the benchmark that starts it. Reads requests from the standard "
      "input unless --seconds is given.");
  WorkerOptions options;
  double seconds = 0;
  app.add_option("--mesh", options.mesh, "OBJ file; a procedural car if not given");
  app.add_option("--distance", options.distance, "Of the camera");
  app.add_option("--size", options.size, "Width and height of the picture, in pixels");
  app.add_option("--threads", options.threads, "Threads");
  app.add_option("--stage", options.stage, "visibility, frame, texture-backward, vertex-gradient or step")
      ->required();
  app.add_option("--variant", options.variant, variants);
  app.add_option("--seconds", seconds, "Run that long, print the times and leave");
  return shell::run_program(app, argc, argv, [&] {
    Replies replies;
    const Scene scene = make_scene(options.mesh, options.distance);
    Renderer engine(scene, options);
    run_or_serve(engine, replies, seconds);
    return 0;
  });
}
}  // namespace tapestry::benchmarks
