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
#include "shell/picture_list.hpp"
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
  app.add_option("IMAGE", options.images,
                 "PNG or JPEG pictures or frames (.npz), folders of them, or lists of them (.txt, a path a "
                 "line). One that "
                 "cannot be read is told and left out; the exit status is then that of the first")
      ->required();
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

/// Pictures of one name in two folders would become one in --annotate.
void require_own_names(const std::string& folder, const std::vector<std::string>& pictures) {
  std::map<std::string, std::string> taken;
  for (const auto& picture : pictures) {
    const auto [first, is_free] = taken.emplace(annotated_path(folder, picture), picture);
    if (!is_free && first->second != picture)
      throw Error(ErrorKind::usage,
                  "--annotate: " + first->second + " and " + picture + " would both become " + first->first);
  }
}

/// Detects in one picture after the other, and goes on after one that cannot be read or detected in.
class Detection {
 public:
  Detection(const Options& options, const Detector& detector) : options_(options), detector_(detector) {}

  void detect_in(const std::string& path) {
    try {
      auto picture = read_picture(path);
      const auto start = std::chrono::steady_clock::now();
      const auto found = detections_in(path, picture, options_.detector, detector_, pass_);
      seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      ++pictures_;
      if (options_.json)
        all_.push_back(json_of(path, found, detector_));
      else
        print_table(path, found, detector_.names);
      if (options_.annotate.empty()) return;
      for (const auto& detection : found) draw_box(picture, detection.box, {40, 220, 60});
      io::write_image(annotated_path(options_.annotate, path), picture);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::write) throw;
      std::cerr << "error: " << printable(error.what()) << '\n';
      if (failures_++ == 0) code_ = static_cast<int>(error.kind());
    }
  }

  /// \returns the exit code
  int finish() const {
    if (options_.json)
      std::cout << report_text(all_);
    else if (pictures_ > 0)
      std::printf("fit %s, %.1f ms an image, %.0f MiB at most\n",
                  std::string(image::name_of(detector_.fit.kind)).c_str(),
                  1e3 * seconds_ / static_cast<double>(pictures_), peak_mib());
    if (failures_ > 0 && failures_ + pictures_ > 1)
      std::cerr << failures_ << " of " << failures_ + pictures_ << " pictures failed\n";
    return code_;
  }

 private:
  const Options& options_;
  const Detector& detector_;
  detect::Pass<float> pass_;
  Json all_ = Json::array();
  double seconds_ = 0;
  std::size_t pictures_ = 0, failures_ = 0;
  int code_ = 0;
};

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
  const auto pictures = pictures_named(options.images);
  if (!options.annotate.empty()) {
    require_own_names(options.annotate, pictures);
    make_writable_folder(options.annotate);
  }
  Detection detection(options, detector);
  for (const auto& path : pictures) {
    detection.detect_in(path);
  }
  return detection.finish();
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Finds objects in pictures with a Darknet detector with YOLO-V3 heads.");
  describe(app, options);
  return run_program(app, argc, argv, [&] { return run(options); });
}
