#pragma once
#include <cctype>
#include <tapestry/io/detail/exported_names.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/io/text_lines.hpp>
#include <tapestry/io/text_lists.hpp>

namespace tapestry::io {
namespace detail {
[[nodiscard]] inline nn::Engine engine_of(const std::string& precision) {
  if (precision == "bfloat16") return nn::Engine::bfloat16;
  if (precision == "float") return nn::Engine::automatic;
  throw DomainError({"read_detector: precision is ", in_quotes(precision), ", expected float or bfloat16"});
}

[[nodiscard]] inline FileError no_common_layer(const std::string& path) {
  return file_mismatch({path, "", "there is no layer that all heads see, to map attention over"});
}

/// The value of a Darknet model's layer with this number or, if empty, of the last layer that all heads
/// depend on.
template <std::floating_point T>
[[nodiscard]] std::string darknet_layer(const detect::DarknetModel<T>& model, const std::string& layer) {
  if (layer.empty()) {
    const auto network = model.description();
    const auto common = detect::common_layer(network, network.outputs);
    return common.empty() ? throw no_common_layer(network.path) : common;
  }
  const bool is_number =
      layer.size() < 6 && std::ranges::all_of(layer, [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!is_number)
    throw Error(ErrorKind::usage, {"layer '", layer, "': layers of Darknet networks are numbers, from 0"});
  return model.value_name(std::stoul(layer));
}

/// \param network  of an ONNX model; null for Darknet weights
template <std::floating_point T>
[[nodiscard]] detect::Detector<T> read_darknet_detector(const DetectorFiles& files,
                                                        const nn::NetworkDescription* network,
                                                        std::vector<std::string>* warnings) {
  const std::string other = files.description.empty() ? description_beside(files.weights) : files.description;
  if (!other.empty())
    throw Error(ErrorKind::usage, {files.weights, ": is described by its cfg, not by ", other});
  std::optional<detect::DecodeFamily> decode;
  if (!files.decode.empty()) decode = detect::decode_family_by_name(files.decode);
  const auto [model, remarks] =
      network == nullptr ? read_darknet_model<T>(files.config, files.weights, files.size, files.size, decode)
                         : darknet_model<T>(*network, files.config, files.size, files.size, decode);
  if (warnings != nullptr) *warnings = remarks;
  if (model.heads().empty())
    throw file_mismatch({model.config().name, "", "the network has no [yolo] or [region] section"});
  std::vector<std::string> layers;
  for (const std::string& layer : files.layers) layers.push_back(darknet_layer(model, layer));
  return model.detector(layers);
}

/// Classes that the names in files or in the model's metadata have; 0 where there are none.
[[nodiscard]] inline std::size_t class_count_of(const DetectorFiles& files,
                                                const nn::NetworkDescription& network) {
  constexpr std::size_t most = 4096;
  if (!files.names.empty()) return read_class_names(files.names).size();
  const auto found = network.metadata.find("names");
  if (found == network.metadata.end()) return 0;
  try {
    const auto names = parse_exported_names(found->second, most);
    const auto last =
        std::find_if(names.rbegin(), names.rend(), [](const auto& name) { return !name.empty(); });
    return static_cast<std::size_t>(names.rend() - last);
  } catch (const DomainError&) {  // take_exported_names() says so
    return 0;
  }
}

/// The names of families that a network's layers fit, for messages.
[[nodiscard]] inline std::string fitting_words(const nn::NetworkDescription& network, std::size_t size) {
  const std::string words = listed(detect::fitting_exports(network, size));
  return words.empty() ? "its layers fit no family that --detector names"
                       : "its layers fit --detector " + words;
}

/// A description by the name of a family, with a note of what it reads.
[[nodiscard]] inline detect::DetectorDescription description_by_name(const DetectorFiles& files,
                                                                     const nn::NetworkDescription& network,
                                                                     std::string_view name,
                                                                     std::vector<std::string>* warnings) {
  auto description = detect::named_export(network, name, class_count_of(files, network), files.size);
  const detect::DecodedOutputs& read = description.decoded;
  if (warnings != nullptr && !read.boxes.empty())
    warnings->push_back(files.weights + ": as of the family " + std::string(name) + ", boxes are " +
                        in_quotes(read.boxes) + " and scores " + in_quotes(read.scores));
  return description;
}

struct SourcedDescription {
  detect::DetectorDescription description{};
  std::string source{};
};

/// Description of an ONNX model by the file or the word that is given.
[[nodiscard]] inline SourcedDescription given_description(const DetectorFiles& files,
                                                          const nn::NetworkDescription& network,
                                                          const std::string& file,
                                                          std::vector<std::string>* warnings) {
  if (detect::is_export_name(file))
    return {description_by_name(files, network, file, warnings), "the word " + file};
  const std::string nearest = nearest_word(file, detect::export_names);
  if (!nearest.empty() && !std::filesystem::exists(path_of(file)))
    throw Error(ErrorKind::usage,
                {files.weights, ": ", in_quotes(file),
                 " is neither a file nor a family of exports; did you mean ", nearest, "?"});
  std::vector<std::string> assumed;
  SourcedDescription found{read_detector_description(file, &assumed), file};
  if (!assumed.empty()) found.source += ", which leaves the input to be assumed";
  if (warnings != nullptr) warnings->insert(warnings->end(), assumed.begin(), assumed.end());
  return found;
}

[[nodiscard]] inline SourcedDescription description_for(const DetectorFiles& files,
                                                        const nn::NetworkDescription& network,
                                                        std::vector<std::string>* warnings) {
  const std::string file = files.description.empty() ? description_beside(files.weights) : files.description;
  std::optional<SourcedDescription> given;
  if (!file.empty()) given = given_description(files, network, file, warnings);
  if (const auto found = network.metadata.find(description_key); found != network.metadata.end()) {
    const std::string source = files.weights + ":" + description_key;
    auto own = parse_detector_description(found->second, source);
    if (given && own != given->description)
      throw file_mismatch({file, "", "contradicts the description within " + files.weights,
                           "the same one, or no such file", ""});
    return {std::move(own), source};
  }
  if (given) return *given;
  if (const auto known = detect::recognised_detector(network)) return {*known, "the family of its layers"};
  if (const auto name = detect::recognised_export(network); !name.empty()) {
    if (warnings != nullptr)
      warnings->push_back(files.weights + ": taken for an export of the family " + std::string(name) +
                          " by its nodes; a description takes precedence");
    return {description_by_name(files, network, name, warnings),
            "the family " + std::string(name) + ", by its nodes"};
  }
  throw Error(ErrorKind::usage, {files.weights,
                                 ": its outputs are not those of a detector that is known by its layers "
                                 "(YOLOX, NanoDet, torchvision's); a description must define them: the name "
                                 "of a family, such as yolov5 or yolov8, or a file, which may also stand "
                                 "beside the model, of its name with the ending .json; ",
                                 fitting_words(network, files.size)});
}

/// Gives a detector the class names that its model's metadata have, see parse_exported_names(). A class
/// without one is named by its number.
/// \returns their source, or the reason why they are not used
template <std::floating_point T>
[[nodiscard]] std::string take_exported_names(const std::string& path, const std::string& text,
                                              detect::Detector<T>& detector) try {
  std::vector<std::string> names = parse_exported_names(text, detector.heads().front().classes);
  std::size_t unnamed = 0;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (names[k].empty()) {
      names[k] = std::to_string(k);
      ++unnamed;
    }
  const std::string gaps = unnamed == 0 ? ""
                                        : "; " + std::to_string(unnamed) + " of " +
                                              std::to_string(names.size()) + " classes have numbers there";
  detector.set_names(std::move(names));
  return path + ": class names are from the model's metadata" + gaps;
} catch (const DomainError& error) {
  return path + ": class names in the model's metadata are left out: " + error.what();
}

/// Sets a detector's facts from the metadata of its model.
/// \param without_names  whether no file has the names of the classes
/// \returns warnings: what is taken from the metadata, and what contradicts the network
template <std::floating_point T>
[[nodiscard]] std::vector<std::string> remarks_on(const nn::NetworkDescription& network, bool without_names,
                                                  detect::Detector<T>& detector) {
  std::vector<std::string> remarks;
  if (const auto untrue = nn::untrue_shape(network)) remarks.push_back(*untrue);
  if (const auto task = network.metadata.find("task");
      task != network.metadata.end() && task->second != "detect")
    remarks.push_back(network.path + ": the model's metadata name the task " + in_quotes(task->second) +
                      "; its outputs are read as those of a detector");
  const auto names = network.metadata.find("names");
  if (without_names && names != network.metadata.end())
    remarks.push_back(take_exported_names(network.path, names->second, detector));
  return remarks;
}

/// \throws FileError (mismatch) unless the metadata of a model name as many classes as its heads have
inline void require_class_count(const DetectorFiles& files, const nn::NetworkDescription& network,
                                std::size_t classes) {
  const std::size_t named = class_count_of(files, network);
  if (named != 0 && named != classes)
    throw file_mismatch({network.path, "", "not a detector of the classes that the model's metadata name",
                         std::to_string(named), std::to_string(classes)});
}

/// \param source  receives the description's origin
template <std::floating_point T>
[[nodiscard]] detect::Detector<T> described_detector(const DetectorFiles& files,
                                                     const nn::NetworkDescription& network,
                                                     std::string& source,
                                                     std::vector<std::string>* warnings) {
  auto found = description_for(files, network, warnings);
  source = std::move(found.source);
  const auto& description = found.description;
  auto layers = files.layers;
  for (std::string& layer : layers) {
    if (layer.empty()) layer = detect::common_layer(network, description);
    if (layer.empty()) throw no_common_layer(files.weights);
  }
  detect::Detector<T> detector(network, description, files.size, layers);
  if (files.names.empty()) require_class_count(files, network, detector.heads().front().classes);
  const std::vector<std::string> remarks = remarks_on(network, files.names.empty(), detector);
  if (warnings != nullptr) warnings->insert(warnings->end(), remarks.begin(), remarks.end());
  return detector;
}

template <std::floating_point T>
[[nodiscard]] detect::Detector<T> read_onnx_detector(const DetectorFiles& files, std::string& source,
                                                     std::vector<std::string>* warnings) {
  const auto network = read_onnx(files.weights);
  if (is_of_darknet(network)) return read_darknet_detector<T>(files, &network, warnings);
  for (const std::string& other : {files.config, files.decode})
    if (!other.empty())
      throw Error(ErrorKind::usage, {files.weights, ": an ONNX model takes no cfg and no decode family, but ",
                                     other, " was given"});
  source = (detect::is_export_name(files.description) ? "the word " : "") + files.description;
  try {
    return described_detector<T>(files, network, source, warnings);
  } catch (const FileError& error) {
    FileError::Details details = error.details();
    if (!details.what.starts_with("not a")) throw;
    details.what = "read by " + source + ": " + details.what;
    details.found += "; " + fitting_words(network, files.size);
    throw FileError(error.kind(), details);
  }
}
}  // namespace detail

template <std::floating_point T>
detect::Detector<T> read_detector(const DetectorFiles& files, std::vector<std::string>* warnings,
                                  std::string* input_source) {
  const nn::Engine engine = detail::engine_of(files.precision);
  std::string source = "Darknet's convention";
  auto detector = is_onnx(files.weights) ? detail::read_onnx_detector<T>(files, source, warnings)
                                         : detail::read_darknet_detector<T>(files, nullptr, warnings);
  if (input_source != nullptr) *input_source = std::move(source);
  detector.set_engine(engine);
  if (!files.fit.empty()) detector.set_fit(image::fit_by_name(files.fit));
  if (!files.names.empty())
    detector.set_names(read_class_names(files.names, detector.heads().front().classes));
  return detector;
}

template <std::floating_point T>
Array<T, 4> read_input(const detect::Detector<T>& detector, const std::string& path) {
  return detector.input(image::from_bytes<T>(read_picture(path)));
}
}  // namespace tapestry::io
