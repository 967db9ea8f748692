// Finds objects in pictures with a Darknet detector.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <tapestry/core/parallel.hpp>
#include <tapestry/image/letterbox.hpp>
#include <vector>

#include "shell/contact_sheet.hpp"
#include "shell/inputs.hpp"
#include "shell/picture_detections.hpp"
#include "shell/program.hpp"
#include "shell/run_folder.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

struct Options {
  DetectorSettings detector;
  int threads = 0;
  bool json = false;
  std::string annotate;
  std::vector<std::string> images;
};

void describe(CLI::App& app, Options& options) {
  add_options(app, options.detector, {"class"});
  app.add_option("--threads", options.threads, "threads; 0: all cores")->capture_default_str();
  app.add_flag("--json", options.json,
               "print a JSON array; boxes in pixels of the image, x and y the top left corner");
  app.add_option("--annotate", options.annotate,
                 "folder for copies of the pictures with the boxes drawn in; none when left out");
  app.add_option("IMAGE", options.images, "PNG or JPEG pictures, or frames (.npz)")->required();
}

Array<std::uint8_t, 3> read_picture(const std::string& path) {
  return std::filesystem::path(path).extension() == ".npz" ? io::read_frame(path).image
                                                           : io::read_image(path);
}

Json json_of(const std::string& path, const std::vector<detect::Detection>& detections,
             const Detector& detector) {
  Json list = Json::array();
  for (const auto& d : detections)
    list.push_back({{"class", d.class_index},
                    {"name", class_name(d.class_index, detector.names)},
                    {"confidence", d.confidence},
                    {"x", d.box.left()},
                    {"y", d.box.top()},
                    {"width", d.box.w},
                    {"height", d.box.h}});
  return {{"image", path}, {"fit", image::name_of(detector.fit.kind)}, {"detections", list}};
}

void print_table(const std::string& path, const std::vector<detect::Detection>& detections,
                 const std::vector<std::string>& names) {
  std::printf("%s\n", printable(path).c_str());
  for (const auto& d : detections)
    std::printf("  %-16s %.3f  x %7.1f  y %7.1f  width %7.1f  height %7.1f\n",
                printable(class_name(d.class_index, names)).c_str(), d.confidence, d.box.left(), d.box.top(),
                d.box.w, d.box.h);
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

int run(Options& options) {
  auto& settings = options.detector;
  ProblemList problems;
  require_sound(settings, problems);
  require_sound_thread_count(options.threads, problems);
  problems.throw_first();
  fill_in_bundled(settings);
  if (options.threads > 0) limit_threads(options.threads);
  const auto detector = load_detector(settings);
  print_warnings(detector.warnings);
  require_sound_pictures(options);
  if (!options.annotate.empty()) make_writable_folder(options.annotate);
  detect::Pass<float> pass;
  Json all = Json::array();
  double seconds = 0;
  for (const auto& path : options.images) {
    auto picture = read_picture(path);
    const auto start = std::chrono::steady_clock::now();
    const auto detections = detections_in(path, picture, settings, detector, pass);
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (options.json)
      all.push_back(json_of(path, detections, detector));
    else
      print_table(path, detections, detector.names);
    if (options.annotate.empty()) continue;
    for (const auto& detection : detections) draw_box(picture, detection.box, {40, 220, 60});
    io::write_image(annotated_path(options.annotate, path), picture);
  }
  if (options.json)
    std::cout << report_text(all);
  else
    std::printf("fit %s, %.1f ms an image, %.0f MiB at most\n",
                std::string(image::name_of(detector.fit.kind)).c_str(),
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
