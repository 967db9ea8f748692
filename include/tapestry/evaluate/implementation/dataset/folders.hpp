#pragma once
#include <map>
#include <tapestry/evaluate/dataset/readers.hpp>
#include <tapestry/evaluate/detail/dataset/xml_reader.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::evaluate {
namespace detail {
/// The label file of a picture: beside it, or in the path with its last folder `images` replaced by `labels`.
/// \returns empty if there is no such file
[[nodiscard]] inline std::string yolo_label_path(const std::string& picture) {
  namespace fs = std::filesystem;
  const fs::path beside = io::path_of(picture).replace_extension(".txt");
  if (io::is_regular_file(beside.string())) return beside.string();
  std::vector<fs::path> parts(beside.begin(), beside.end());
  const auto last = std::find(parts.rbegin(), parts.rend(), fs::path("images"));
  if (last == parts.rend()) return "";
  *last = "labels";
  fs::path other;
  for (const auto& part : parts) other /= part;
  return io::is_regular_file(other.string()) ? other.string() : "";
}

/// Adds the next picture with its labels, or without any if it has no label file.
/// \returns whether it has one
inline bool add_yolo_picture(Dataset& dataset, const std::string& path, std::size_t class_count) {
  constexpr std::uint64_t largest = std::uint64_t(4) << 20U;
  LabelledPicture picture{path, dataset.pictures.size() + 1, 0, 0, true};
  const std::string labels = yolo_label_path(path);
  if (!labels.empty())
    picture.objects = parse_yolo_labels(io::read_text_file(labels, largest), labels, class_count);
  dataset.pictures.push_back(std::move(picture));
  return !labels.empty();
}

/// \param labelled  pictures with a file of labels
inline void require_labels(Dataset& dataset, const std::string& path, std::size_t labelled) {
  if (labelled == 0)
    throw file_mismatch(
        {path, "", "no picture has labels", "a .txt beside it, or below labels/ for images/", "none"});
  const std::size_t empty = dataset.pictures.size() - labelled;
  if (empty > 0)
    dataset.warnings.push_back(path + ": " + std::to_string(empty) + " of " +
                               std::to_string(dataset.pictures.size()) +
                               " pictures have no file of labels; they count as empty");
}

/// An element of an annotation whose members are read by name and type.
class VocElement {
 public:
  VocElement(const XmlElement& element, const std::string& path) : element_(element), path_(path) {}

  [[noreturn]] void fail(std::size_t line, const std::string& what, const std::string& expected,
                         const std::string& found) const {
    throw malformed_file({path_, std::to_string(line), what, expected, found});
  }
  [[nodiscard]] VocElement child(std::string_view name) const {
    std::size_t count = 0;
    const XmlElement* found = element_.child(name, &count);
    if (found == nullptr)
      fail(element_.line, "<" + printable(element_.name) + "> of labels",
           "one <" + std::string(name) + "> in it", std::to_string(count));
    return {*found, path_};
  }
  [[nodiscard]] bool has(std::string_view name) const { return element_.child(name) != nullptr; }
  [[nodiscard]] const std::string& text() const {
    if (element_.text.empty())
      fail(element_.line, "<" + printable(element_.name) + "> makes no sense", "a text", "none");
    return element_.text;
  }
  [[nodiscard]] double number(double low, double high) const {
    double value = 0;
    if (!io::parse_number(element_.text, value) || !(value >= low && value <= high))
      fail(element_.line, "<" + printable(element_.name) + "> makes no sense",
           "a number from " + std::to_string(static_cast<long>(low)) + " to " +
               std::to_string(static_cast<long>(high)),
           in_quotes(element_.text));
    return value;
  }
  [[nodiscard]] std::size_t line() const { return element_.line; }
  [[nodiscard]] const XmlElement& xml() const { return element_; }

 private:
  const XmlElement& element_;
  const std::string& path_;
};

/// Columns and rows count from 1, and a box includes its last ones.
inline detect::Box voc_box(const VocElement& bounds) {
  constexpr double largest = 1 << 20;
  const double left = bounds.child("xmin").number(-largest, largest) - 1;
  const double top = bounds.child("ymin").number(-largest, largest) - 1;
  const double right = bounds.child("xmax").number(-largest, largest);
  const double bottom = bounds.child("ymax").number(-largest, largest);
  if (!(right > left && bottom > top))
    bounds.fail(bounds.line(), "<bndbox> of negative extent", "xmin <= xmax and ymin <= ymax",
                std::to_string(right - left) + " columns and " + std::to_string(bottom - top) + " rows");
  return detect::box_from_corners(left, top, right, bottom);
}

inline void number_classes(Dataset& dataset, const std::vector<std::vector<std::string>>& names) {
  std::map<std::string, std::size_t> index_of;
  for (const auto& of_picture : names)
    for (const auto& name : of_picture) index_of.emplace(name, 0);
  for (auto& [name, index] : index_of) {
    index = dataset.class_names.size();
    dataset.class_names.push_back(name);
    dataset.class_ids.push_back(index);
  }
  for (std::size_t p = 0; p < names.size(); ++p)
    for (std::size_t i = 0; i < names[p].size(); ++i)
      dataset.pictures[p].objects[i].class_index = index_of.at(names[p][i]);
}
}  // namespace detail

std::vector<LabelledObject> parse_yolo_labels(std::string_view text, const std::string& path,
                                              std::size_t class_count) {
  constexpr const char* form = "class cx cy w h";
  io::TextLines lines(text, path, 1000);
  std::vector<LabelledObject> objects;
  while (lines.next()) {
    const std::string_view first = lines.word();
    if (first.empty()) continue;
    LabelledObject object;
    if (!io::parse_integer(first, object.class_index))
      lines.fail("class is no whole number", "0 to " + std::to_string(class_count - 1), in_quotes(first));
    if (object.class_index >= class_count)
      lines.fail("class out of range", "0 to " + std::to_string(class_count - 1), std::string(first),
                 ErrorKind::mismatch);
    double values[4];
    for (std::size_t i = 0; i < 4; ++i) {
      const std::string_view word = lines.word();
      if (word.empty()) lines.fail("label ends early", form, std::to_string(i + 1) + " words");
      const bool is_number = io::parse_number(word, values[i]);
      if (i < 2 && !(is_number && values[i] >= 0 && values[i] <= 1))
        lines.fail("centre of a box", "a share of the picture, 0 to 1", in_quotes(word));
      if (i >= 2 && !(is_number && values[i] > 0 && values[i] <= 1))
        lines.fail("extent of a box", "a share of the picture, above 0 and at most 1", in_quotes(word));
    }
    if (const std::string_view more = lines.word(); !more.empty())
      lines.fail("more than a box in a label", form, in_quotes(more) + " behind it");
    object.box = {values[0], values[1], values[2], values[3]};
    object.area = values[2] * values[3];
    objects.push_back(object);
  }
  return objects;
}

Dataset read_yolo_folder(const std::string& folder, std::size_t class_count) {
  namespace fs = std::filesystem;
  const std::string images = folder + "/images";
  const std::string from = io::is_folder(images) ? images : folder;
  const auto paths = io::listed_paths(from, io::has_picture_name);
  if (paths.empty()) throw file_mismatch({from, "", "no pictures", io::picture_endings() + " files", "none"});
  const auto stem_of = [](const std::string& path) { return io::path_of(path).stem(); };
  const auto twin = std::ranges::adjacent_find(paths, {}, stem_of);  // sorted by name
  if (twin != paths.end())
    throw file_mismatch({*twin, "", "two pictures would have the same labels", "other names",
                         in_quotes(io::path_of(twin[1]).filename().string())});
  Dataset dataset;
  std::size_t labelled = 0;
  for (const auto& path : paths)
    if (detail::add_yolo_picture(dataset, path, class_count)) ++labelled;
  detail::require_labels(dataset, from, labelled);
  return dataset;
}

Dataset read_darknet_list(const std::string& path, std::size_t class_count) {
  constexpr std::uint64_t largest = std::uint64_t(256) << 20U;
  const std::string text = io::read_text_file(path, largest);
  io::TextLines lines(text, path, 8192);
  Dataset dataset;
  std::map<std::string, std::size_t> line_of;
  std::size_t labelled = 0;
  while (lines.next()) {
    const std::string name(lines.rest_of_line());
    if (name.empty()) continue;
    const std::string picture = (io::path_of(path).parent_path() / io::path_of(name)).string();
    detail::require_picture(picture, path, std::to_string(lines.number()));
    const auto [first, is_new] = line_of.try_emplace(picture, lines.number());
    if (!is_new)
      lines.fail("picture is listed twice", "", "line " + std::to_string(first->second), ErrorKind::mismatch);
    if (detail::add_yolo_picture(dataset, picture, class_count)) ++labelled;
  }
  if (dataset.pictures.empty()) lines.fail_at(0, "no pictures", "a path a line", "none", ErrorKind::mismatch);
  detail::require_labels(dataset, path, labelled);
  return dataset;
}

VocAnnotation parse_voc(std::string_view text, const std::string& path) {
  constexpr double largest_side = 1 << 20;
  const XmlElement root = parse_xml(text, path);
  const detail::VocElement annotation(root, path);
  if (root.name != "annotation")
    annotation.fail(root.line, "not labels of Pascal VOC", "<annotation>", in_quotes("<" + root.name + ">"));
  VocAnnotation result;
  const auto filename = annotation.child("filename");
  result.filename = filename.text();
  if (result.filename.size() > io::longest_path)
    annotation.fail(filename.line(), "<filename> is too long",
                    "at most " + std::to_string(io::longest_path) + " bytes",
                    std::to_string(result.filename.size()));
  if (!io::stays_below(result.filename))
    annotation.fail(filename.line(), "<filename> lies outside the folder of the pictures", "a name in it",
                    in_quotes(result.filename));
  const auto size = annotation.child("size");
  result.picture.height = static_cast<std::size_t>(size.child("height").number(1, largest_side));
  result.picture.width = static_cast<std::size_t>(size.child("width").number(1, largest_side));
  for (const XmlElement& each : root.children) {
    if (each.name != "object") continue;
    const detail::VocElement element(each, path);
    LabelledObject object;
    object.box = detail::voc_box(element.child("bndbox"));
    object.area = object.box.area();
    object.is_difficult = element.has("difficult") && element.child("difficult").number(0, 1) > 0;
    result.class_names.push_back(element.child("name").text());
    result.picture.objects.push_back(object);
  }
  return result;
}

Dataset read_voc(const std::string& folder, const std::string& images) {
  namespace fs = std::filesystem;
  constexpr std::uint64_t largest = std::uint64_t(4) << 20U;
  const bool is_root = io::is_folder(folder + "/Annotations");
  const std::string labels = is_root ? folder + "/Annotations" : folder;
  const std::string beside = is_root ? folder + "/JPEGImages" : folder;
  Dataset dataset;
  std::vector<std::vector<std::string>> names;
  std::map<std::string, std::string> labels_of;
  for (const auto& path : detail::xml_paths(labels)) {
    auto annotation = parse_voc(io::read_text_file(path, largest), path);
    auto& picture = annotation.picture;
    picture.path = (io::path_of(images.empty() ? beside : images) / annotation.filename).string();
    picture.id = dataset.pictures.size() + 1;
    detail::require_picture(picture.path, path, "");
    const auto [other, is_new] = labels_of.emplace(picture.path, path);
    if (!is_new)
      throw file_mismatch({path, "", "labels of a picture that has others", "a picture of its own",
                           printable(other->second)});
    names.push_back(std::move(annotation.class_names));
    dataset.pictures.push_back(std::move(picture));
  }
  if (dataset.pictures.empty()) throw file_mismatch({labels, "", "no labels", ".xml files", "none"});
  detail::number_classes(dataset, names);
  return dataset;
}
}  // namespace tapestry::evaluate
