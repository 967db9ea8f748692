#include "detector_inputs.hpp"

#include <cctype>
#include <sstream>

#include "ranks.hpp"
#include "verbosity.hpp"

namespace tapestry::shell {
namespace {
/// The classes of COCO 2017, in the order of the categories of its annotations.
std::vector<std::string> coco_names() {
  std::istringstream list(
      "person,bicycle,car,motorcycle,airplane,bus,train,truck,boat,traffic light,fire hydrant,"
      "stop sign,parking meter,bench,bird,cat,dog,horse,sheep,cow,elephant,bear,zebra,giraffe,backpack,"
      "umbrella,handbag,tie,suitcase,frisbee,skis,snowboard,sports ball,kite,baseball bat,"
      "baseball glove,skateboard,surfboard,tennis racket,bottle,wine glass,cup,fork,knife,spoon,bowl,"
      "banana,apple,sandwich,orange,broccoli,carrot,hot dog,pizza,donut,cake,chair,couch,potted plant,"
      "bed,dining table,toilet,tv,laptop,mouse,remote,keyboard,cell phone,microwave,oven,toaster,sink,"
      "refrigerator,book,clock,vase,scissors,teddy bear,hair drier,toothbrush");
  std::vector<std::string> names;
  for (std::string name; std::getline(list, name, ',');) names.push_back(name);
  return names;
}

/// Refuses weights without the name of an ONNX file whose content is of another known kind.
/// \throws FileError (malformed) with the kind
void require_detector_format(const std::string& weights) {
  const io::RegularFile file(weights);
  std::vector<std::byte> beginning(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), 256)));
  file.read_at(0, beginning);
  const std::string_view format = io::recognised_format(beginning);
  if (!format.empty())
    throw malformed_file({weights, "@0", "not a detector",
                          "an .onnx model, such as torch.onnx.export writes, or Darknet weights",
                          std::string(format)});
}

/// Gives 80 classes without names COCO's names, unless --class is a number.
void name_coco_classes(const DetectorSettings& settings, detect::Detector<float>& detector,
                       std::vector<std::string>& warnings) {
  const bool is_counted =
      !settings.class_name.empty() &&
      std::ranges::all_of(settings.class_name, [](unsigned char c) { return std::isdigit(c); });
  if (!detector.names().empty() || is_counted || detector.heads().empty() ||
      detector.heads().front().classes != coco_names().size())
    return;
  detector.set_names(coco_names());
  warnings.push_back(settings.weights +
                     ": 80 classes and no --names; they are taken for those of COCO, in its order");
}

/// Prints once, except with --quiet, how pictures enter a detector, and the source of that.
void print_input(const DetectorSettings& settings, const detect::Detector<float>& detector,
                 const std::string& source) {
  static std::set<std::string> printed;
  const auto three = [](const std::array<double, 3>& values) {
    return std::ranges::count(values, values[0]) == 3
               ? formatted("%g", values[0])
               : formatted("(%g, %g, %g)", values[0], values[1], values[2]);
  };
  const detect::InputEncoding& encoding = detector.description().encoding;
  const std::string line = "input of " + settings.weights + ": " + std::to_string(detector.input_width()) +
                           " x " + std::to_string(detector.input_height()) + ", " +
                           (encoding.order == detect::ColourOrder::rgb ? "rgb" : "bgr") + ", 0 to " +
                           formatted("%g", 255 * encoding.scale) + ", mean " + three(encoding.mean) +
                           ", std " + three(encoding.deviation) + ", by " + source + "; " +
                           std::string(image::name_of(detector.fit().kind)) + ", by " +
                           (settings.fit.empty() ? source : "--fit");
  if (verbosity() != Verbosity::quiet && Ranks::all().is_first() && printed.insert(line).second)
    std::cerr << for_terminal(line) << '\n';
}
}  // namespace

detect::Detector<float> load_detector(const DetectorSettings& settings, std::vector<std::string>& warnings,
                                      const std::vector<std::string>& layers) {
  const bool is_onnx = io::is_onnx(settings.weights);
  if (!is_onnx) require_detector_format(settings.weights);
  if (!is_onnx && !settings.detector.empty())
    throw Error(ErrorKind::usage, "--detector describes .onnx weights; those of " + settings.weights +
                                      " are described by a cfg");
  if (!is_onnx && settings.cfg.empty())
    throw Error(ErrorKind::usage, "--cfg is missing, which " + settings.weights + " needs");
  std::string source;
  auto detector = io::read_detector<float>({.weights = settings.weights,
                                            .config = settings.cfg,
                                            .names = settings.names,
                                            .description = settings.detector,
                                            .decode = settings.decode,
                                            .size = settings.size,
                                            .precision = settings.precision,
                                            .fit = settings.fit,
                                            .layers = layers},
                                           &warnings, &source);
  print_input(settings, detector, source);
  name_coco_classes(settings, detector, warnings);
  return detector;
}
}  // namespace tapestry::shell
