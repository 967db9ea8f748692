// Finds objects in pictures with a Darknet or ONNX detector.

#include "shell/heat_map_picture.hpp"
#include "shell/inputs.hpp"
#include "shell/network_profile.hpp"
#include "shell/picture_detections.hpp"
#include "shell/picture_list.hpp"
#include "shell/picture_sheet.hpp"
#include "shell/program.hpp"
#include "shell/wild_boxes.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

struct Options {
  DetectorSettings detector;
  bool json = false;
  std::string annotate;
  std::string sheet;
  std::string heat_map;
  std::string layer;
  std::string heat_map_kind = heat_maps.front().first;
  bool profile = false;
  std::vector<std::string> images;
};

void describe(CLI::App& app, Options& options) {
  add_options(app, options.detector, {"class"});
  app.option_defaults()->group("Output");
  add_threads_option(app);
  app.add_flag(
      "--json", options.json,
      "print a JSON array; boxes in pixels of the image, cut at its edge, x and y the top left corner");
  app.add_option("--annotate", options.annotate,
                 "folder for copies of the pictures with the boxes drawn in, each in the colour of its class "
                 "with name and confidence; none when left out");
  app.add_option(
      "--sheet", options.sheet,
      "PNG of all pictures side by side with the boxes drawn in, each under its name, at most 640 pixels "
      "wide, or 320 if there are more than 12; of more than 160, evenly spread ones; none when left out");
  app.add_option("--heat-map", options.heat_map,
                 "folder for copies of the pictures with a heat map: where in a layer the score of the "
                 "surest detection comes from; none when left out");
  app.add_option("--layer", options.layer,
                 "layer of --heat-map: the name of a value of an .onnx model, or the number of a layer of a "
                 "Darknet network, from 0; left out, the last one that all outputs depend on");
  app.add_option("--heat-map-kind", options.heat_map_kind,
                 "{layer_cam}, or {grad_cam} or {grad_cam_plus_plus}, which weigh whole channels");
  app.add_flag("--profile", options.profile,
               "print where the time of the network went, by operator, forward and backward to the picture; "
               "with --json on the standard error");
  app.add_option("IMAGE", options.images,
                 "PNG, JPEG, BMP, PGM or PPM pictures or frames (.npz), folders of them, or lists of them "
                 "(.txt, a path a line). One that cannot be read is reported and left out; the exit status "
                 "is then that of the first")
      ->required();
}

Json json_of(const std::string& path, const std::vector<detect::Detection>& detections,
             const detect::Detector<float>& detector, const std::string& precision) {
  Json list = Json::array();
  for (const auto& d : detections)
    list.push_back({{"class", d.class_index},
                    {"name", class_name(d.class_index, detector.names())},
                    {"confidence", d.confidence},
                    {"x", d.box.left()},
                    {"y", d.box.top()},
                    {"width", d.box.w},
                    {"height", d.box.h}});
  Json json{{"image", path}, {"fit", image::name_of(detector.fit().kind)}, {"detections", list}};
  if (precision != "float") json["precision"] = precision;
  return json;
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

constexpr const char* annotated_ending = "-detections.png";
constexpr const char* heat_map_ending = "-heat_map.png";

std::string annotated_path(const std::string& folder, const std::string& image, const char* ending) {
  return folder + "/" + io::path_of(image).stem().string() + ending;
}

/// Two pictures of the same name in two folders would become one file in the folder of copies, and a copy
/// could overwrite another picture.
void require_own_names(const std::string& folder, const std::vector<std::string>& pictures,
                       const char* ending) {
  std::set<std::filesystem::path> inputs;
  for (const auto& picture : pictures) inputs.insert(place_of(picture));
  std::map<std::string, std::string> taken;
  for (const auto& picture : pictures) {
    const std::string copy = annotated_path(folder, picture, ending);
    const auto [first, is_free] = taken.emplace(copy, picture);
    if (!is_free && first->second != picture)
      throw Error(ErrorKind::usage,
                  folder + ": " + first->second + " and " + picture + " would both become " + copy);
    if (inputs.contains(place_of(copy)))
      throw Error(ErrorKind::usage, folder + ": the copy of " + picture + " would be written over " + copy +
                                        ", which is one of the pictures; give another folder");
  }
}

/// Detects in pictures, some at a time, and goes on after one that cannot be read or detected in.
class Detection {
 public:
  Detection(const Options& options, const detect::Detector<float>& detector)
      : options_(options), detector_(detector), heat_map_(heat_map_by_name(options.heat_map_kind)) {}

  /// \throws Error (write) when a copy cannot be written
  void detect_in(const std::vector<std::string>& paths) {
    const auto start = std::chrono::steady_clock::now();
    PictureSheet sheet(options_.sheet.empty() ? 0 : paths.size());
    for_each_in_order(
        paths.size(), [&](std::size_t i) { return examine(paths[i], sheet.shows(i) ? sheet.side() : 0); },
        [&](std::size_t i, Examined examined) {
          if (!examined.error && sheet.shows(i))
            sheet.add(io::path_of(paths[i]).filename().string(), std::move(examined.small));
          tell(paths[i], examined);
        });
    if (!options_.sheet.empty() && sheet.count() > 0) io::write_image(options_.sheet, sheet.bitmap());
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  /// \returns the exit code
  int finish() const {
    if (options_.json)
      std::cout << report_text(all_);
    else if (!options_.profile && pictures_ > 0 && verbosity() != Verbosity::quiet)
      std::printf("fit %s, %.1f ms an image from file to result, %.0f MiB at most\n",
                  std::string(image::name_of(detector_.fit().kind)).c_str(),
                  1e3 * seconds_ / static_cast<double>(pictures_), peak_mib());
    if (options_.profile && pictures_ > 0) {
      std::FILE* const to = options_.json ? stderr : stdout;
      print_profile(to, "forward", times_.forward);
      print_profile(to, "backward to the picture", times_.adjoint);
    }
    if (failures_ > 0 && failures_ + pictures_ > 1)
      std::cerr << failures_ << " of " << failures_ + pictures_ << " pictures failed\n";
    return code_;
  }

 private:
  struct Examined {
    std::vector<detect::Detection> found{};
    std::vector<std::string> warnings{};
    std::optional<Error> error{};
    nn::PassTimes times{};
    MarkedPicture small{};  ///< for the sheet
  };

  /// \param side  largest side of the picture on the sheet; 0 leaves it out
  Examined examine(const std::string& path, std::size_t side) {
    try {
      std::vector<std::string> warnings;
      auto picture = io::read_picture(path, &warnings);
      const auto pass = passes_.take();
      auto boxes = detections_in(path, picture, options_.detector, detector_, *pass);
      WildBoxes wild;
      wild.add(boxes, picture.shape(0), picture.shape(1));
      if (const std::string word = wild.word(); !word.empty()) warnings.push_back(path + ": " + word);
      Examined examined{cut_at_picture(std::move(boxes), picture.shape(0), picture.shape(1))};
      examined.warnings = std::move(warnings);
      const auto& found = examined.found;
      if (options_.profile)
        examined.times =
            operation_times(detector_, detector_.input(image::from_bytes<float>(picture)), *pass);
      if (!options_.heat_map.empty())
        io::write_image(annotated_path(options_.heat_map, path, heat_map_ending),
                        found.empty()
                            ? picture
                            : heat_map_picture(picture, detector_, found.front().class_index, heat_map_));
      const auto with_boxes = marked(std::move(picture), found, detector_.names());
      if (!options_.annotate.empty())
        io::write_image(annotated_path(options_.annotate, path, annotated_ending), drawn(with_boxes));
      if (side > 0) examined.small = fitted_within(with_boxes, side);
      return examined;
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::write) throw;
      return {.error = error};
    }
  }

  void tell(const std::string& path, const Examined& examined) {
    if (examined.error) {
      std::cerr << "error: " << for_terminal(examined.error->what()) << '\n';
      if (failures_++ == 0) code_ = static_cast<int>(examined.error->kind());
      return;
    }
    print_warnings(examined.warnings);
    ++pictures_;
    times_.forward += examined.times.forward;
    times_.adjoint += examined.times.adjoint;
    if (options_.json)
      all_.push_back(json_of(path, examined.found, detector_, options_.detector.precision));
    else
      print_table(path, examined.found, detector_.names());
  }

  const Options& options_;
  const detect::Detector<float>& detector_;
  HeatMap heat_map_;
  detect::PassPool<float> passes_;
  Json all_ = Json::array();
  nn::PassTimes times_;
  double seconds_ = 0;
  std::size_t pictures_ = 0, failures_ = 0;
  int code_ = 0;
};

int run(const CLI::App& app, Options& options) {
  auto& settings = options.detector;
  ProblemList problems;
  require_sound(settings, problems);
  problems.attempt([&] { (void)heat_map_by_name(options.heat_map_kind); });
  problems.throw_first();
  fill_in_bundled(settings);
  for (const char* option : {"--layer", "--heat-map-kind"})
    if (options.heat_map.empty() && app.get_option(option)->count() > 0)
      throw Error(ErrorKind::usage, std::string(option) + " needs --heat-map");
  std::vector<std::string> warnings;
  const auto detector = load_detector(
      settings, warnings, options.heat_map.empty() ? std::vector<std::string>{} : std::vector{options.layer});
  print_warnings(warnings);
  const auto pictures = pictures_named(options.images);
  problems.require(options.sheet.empty() || options.sheet.ends_with(".png"),
                   "--sheet takes a name that ends with .png");
  problems.require_kept("--sheet", options.sheet, pictures);
  problems.throw_first();
  const auto claim_of_sheet = claimed_files({options.sheet});
  std::list<RunFolder> claims;  // two processes in one folder would mix their copies
  for (const auto& [folder, ending] :
       {std::pair(options.annotate, annotated_ending), std::pair(options.heat_map, heat_map_ending)}) {
    if (folder.empty()) continue;
    require_own_names(folder, pictures, ending);
    std::error_code absent;
    const bool is_claimed =
        !claims.empty() &&
        std::filesystem::equivalent(io::path_of(folder), io::path_of(options.annotate), absent);
    if (!is_claimed) claims.emplace_back(folder, !is_there(folder, ErrorKind::write));
  }
  Detection detection(options, detector);
  detection.detect_in(pictures);
  return detection.finish();
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  auto app = command_line("Finds objects in pictures with a Darknet or ONNX detector.");
  describe(app, options);
  app.footer(
      "  detect street.png\n"
      "  detect --weights yolox_nano.onnx --json --annotate boxes pictures/\n"
      "  detect --weights yolox_nano.onnx --sheet all.png pictures/");
  return run_program(app, argc, argv, [&] { return run(app, options); });
}
