// Finds objects in pictures with a Darknet detector.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/image/letterbox.hpp>
#include <vector>

#include "support/contact_sheet.hpp"
#include "support/finite_logits.hpp"
#include "support/inputs.hpp"
#include "support/program.hpp"
#include "support/run_folder.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::examples;

struct Options {
  std::string cfg;
  std::string weights;
  std::string names;
  std::size_t size = 0;
  double confidence = 0.25;
  double nms = 0.45;
  int threads = 0;
  bool json = false;
  std::string annotate;
  std::vector<std::string> images;
};

void describe(CLI::App& app, Options& options) {
  app.add_option(
      "--cfg", options.cfg,
      "Darknet network description; left out, the one inside converted --weights, or the bundled one");
  app.add_option("--weights", options.weights,
                 "Darknet weights that belong to --cfg, or a detector that convert_weights made; the bundled "
                 "one's when both are left out");
  app.add_option("--names", options.names,
                 "class names, one a line; left out, those of the bundled detector, or for others none");
  app.add_option("--size", options.size, "side of the network's square input, pixels; 0: as the cfg says")
      ->capture_default_str();
  app.add_option("--confidence", options.confidence, "least objectness x class probability, 0 to 1")
      ->capture_default_str();
  app.add_option("--nms", options.nms,
                 "overlap (IoU) above which the weaker of two boxes of a class is dropped, 0 to 1")
      ->capture_default_str();
  app.add_option("--threads", options.threads, "threads; 0: all cores")->capture_default_str();
  app.add_flag("--json", options.json,
               "print a JSON array; boxes in pixels of the image, x and y the top left corner");
  app.add_option("--annotate", options.annotate,
                 "folder for copies of the pictures with the boxes drawn in; none when left out");
  app.add_option("IMAGE", options.images, "PNG pictures or frames (.npz)")->required();
}

Array<std::uint8_t, 3> read_picture(const std::string& path) {
  return std::filesystem::path(path).extension() == ".npz" ? io::read_frame(path).image
                                                           : io::read_image(path);
}

/// Boxes in pixels of the image.
std::vector<detect::Detection> detect_in(const std::string& path, const Array<std::uint8_t, 3>& picture,
                                         const Options& options, const detect::Network<float>& network,
                                         detect::Pass<float>& pass) {
  const std::size_t height = network.input_height();
  const std::size_t width = network.input_width();
  Array<float, 3> values(picture.shape());
  for (std::size_t i = 0; i < values.size(); ++i)
    values.data()[i] = static_cast<float>(picture.data()[i]) / 255;
  const auto canvas = image::letterboxed(values, height, width, 0.5F);
  Array<float, 4> planes(Extents<4>{1, 3, height, width});
  for (std::size_t pixel = 0; pixel < height * width; ++pixel)
    for (std::size_t c = 0; c < 3; ++c)
      planes.data()[c * height * width + pixel] = canvas.data()[3 * pixel + c];
  network.forward(planes, pass);
  require_finite_logits(pass.logits, path);
  auto detections = detect::suppress(
      detect::decode(network.heads(), pass.logits, 0, options.confidence, height, width), options.nms);
  const auto box = image::letterbox(picture.shape(0), picture.shape(1), height, width);
  const double x_scale = static_cast<double>(picture.shape(1)) / static_cast<double>(box.width);
  const double y_scale = static_cast<double>(picture.shape(0)) / static_cast<double>(box.height);
  for (auto& detection : detections) {
    auto& b = detection.box;
    b = {(b.cx - static_cast<double>(box.left)) * x_scale, (b.cy - static_cast<double>(box.top)) * y_scale,
         b.w * x_scale, b.h * y_scale};
  }
  return detections;
}

std::string name_of(std::size_t class_index, const std::vector<std::string>& names) {
  return class_index < names.size() ? names[class_index] : std::to_string(class_index);
}

Json json_of(const std::string& path, const std::vector<detect::Detection>& detections,
             const std::vector<std::string>& names) {
  Json list = Json::array();
  for (const auto& d : detections)
    list.push_back({{"class", d.class_index},
                    {"name", name_of(d.class_index, names)},
                    {"confidence", d.confidence},
                    {"x", d.box.cx - d.box.w / 2},
                    {"y", d.box.cy - d.box.h / 2},
                    {"width", d.box.w},
                    {"height", d.box.h}});
  return {{"image", path}, {"detections", list}};
}

void print_table(const std::string& path, const std::vector<detect::Detection>& detections,
                 const std::vector<std::string>& names) {
  std::printf("%s\n", path.c_str());
  for (const auto& d : detections)
    std::printf("  %-16s %.3f  x %7.1f  y %7.1f  width %7.1f  height %7.1f\n",
                name_of(d.class_index, names).c_str(), d.confidence, d.box.cx - d.box.w / 2,
                d.box.cy - d.box.h / 2, d.box.w, d.box.h);
  if (detections.empty()) std::printf("  nothing found\n");
}

std::string annotated_path(const std::string& folder, const std::string& image) {
  return folder + "/" + std::filesystem::path(image).stem().string() + "-detections.png";
}

/// Everything that can be known to fail is tried before the first detection.
void require_sound_pictures(const Options& options) {
  std::map<std::string, std::string> taken;
  for (const auto& image : options.images) {
    const auto [first, is_free] = taken.emplace(annotated_path(options.annotate, image), image);
    if (!options.annotate.empty() && !is_free && first->second != image)
      throw Error(ErrorKind::usage,
                  "--annotate: " + first->second + " and " + image + " would both become " + first->first);
  }
  for (const auto& image : options.images) (void)read_picture(image);
}

int run(const Options& options) {
  DetectorSettings settings;
  settings.cfg = options.cfg;
  settings.weights = options.weights;
  settings.names = options.names;
  settings.size = options.size;
  settings.confidence = options.confidence;
  settings.nms = options.nms;
  ProblemList problems;
  require_sound(settings, problems);
  require_sound_thread_count(options.threads, problems);
  problems.throw_first();
  fill_in_bundled(settings);
  if (options.threads > 0) limit_threads(options.threads);
  const auto detector = load_detector(settings);
  for (const auto& warning : detector.warnings) std::cerr << "warning: " << warning << '\n';
  require_sound_pictures(options);
  if (!options.annotate.empty()) make_writable_folder(options.annotate);
  detect::Pass<float> pass;
  Json all = Json::array();
  double seconds = 0;
  for (const auto& path : options.images) {
    auto picture = read_picture(path);
    const auto start = std::chrono::steady_clock::now();
    const auto detections = detect_in(path, picture, options, detector.network, pass);
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (options.json)
      all.push_back(json_of(path, detections, detector.names));
    else
      print_table(path, detections, detector.names);
    if (options.annotate.empty()) continue;
    for (const auto& detection : detections) draw_box(picture, detection.box, {40, 220, 60});
    io::write_image(annotated_path(options.annotate, path), picture);
  }
  if (options.json)
    std::cout << report_text(all);
  else
    std::printf("%.1f ms an image, %.0f MiB at most\n",
                1e3 * seconds / static_cast<double>(options.images.size()), peak_mib());
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Finds objects in pictures with a Darknet detector with YOLO-V3 heads.");
  describe(app, options);
  return run_program(app, argc, argv, [&] { return run(options); });
}
