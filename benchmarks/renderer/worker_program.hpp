#pragma once

#include "../../examples/programs/shell/program.hpp"
#include "../support/numbers_file.hpp"
#include "../support/serve.hpp"
#include "scene.hpp"

namespace tapestry::benchmarks {

struct WorkerOptions {
  std::string mesh{};  ///< OBJ file, or empty for the procedural car
  double distance = 5;
  std::size_t size = 256;  ///< width and height of the picture in pixels
  int threads = 1;
  std::string stage{};
  std::string variant{};
};

/// A renderer set up for one stage. run() does the stage for every camera of the scene.
///
/// first_answer() is of the scene's first camera for visibility, the face of each sample as a number, −1 for
/// none, and for a frame, [size, size, 3]. Of scored_camera and scoring_weights() it is for texture-backward
/// and step, the derivative with respect to the red of each face, and for vertex-gradient, the derivatives
/// along scored_motions().
template <class R>
concept Renderer = std::constructible_from<R, const Scene&, const WorkerOptions&> && requires(R& renderer) {
  { renderer.name() } -> std::convertible_to<std::string>;
  renderer.run();
  { renderer.first_answer() } -> std::convertible_to<std::vector<float>>;
};

template <Renderer R>
class RendererEngine {
 public:
  RendererEngine(const Scene& scene, const WorkerOptions& options) : renderer_(scene, options) {}
  [[nodiscard]] std::string name() const { return renderer_.name(); }
  void run() { renderer_.run(); }
  [[nodiscard]] double working_mib() requires requires(R& renderer) { renderer.working_mib(); }
  { return renderer_.working_mib(); }
  void save(const std::string& path) {
    const std::vector<float> answer = renderer_.first_answer();
    write_numbers(path, answer);
  }

 private:
  R renderer_;
};

/// The main function of a program that runs one renderer.
/// \param variants  the values of --variant, for the help
template <Renderer R>
int run_worker(int argc, char** argv, const std::string& variants) {
  auto app = shell::command_line(
      "Renders a car again and again, for the benchmark that starts it. Reads requests from the standard "
      "input unless --seconds is given.");
  WorkerOptions options;
  double seconds = 0;
  app.add_option("--mesh", options.mesh, "OBJ file; a procedural car if not given");
  app.add_option("--distance", options.distance, "Of the camera")->capture_default_str();
  app.add_option("--size", options.size, "Width and height of the picture, in pixels")->capture_default_str();
  app.add_option("--threads", options.threads, "Threads")->capture_default_str();
  app.add_option("--stage", options.stage, "visibility, frame, texture-backward, vertex-gradient or step")
      ->required();
  app.add_option("--variant", options.variant, variants);
  app.add_option("--seconds", seconds, "Run that long, print the times and leave");
  return shell::run_program(app, argc, argv, [&] {
    Replies replies;
    shell::keep_freed_memory();
    const Scene scene = make_scene(options.mesh, options.distance);
    RendererEngine<R> engine(scene, options);
    run_or_serve(engine, replies, seconds);
    return 0;
  });
}

}  // namespace tapestry::benchmarks
