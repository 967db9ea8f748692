#pragma once
#include <tapestry/evaluate/dataset/readers.hpp>
#include <tapestry/io/json.hpp>

/// \file
/// The compiled part of the COCO reader.

namespace tapestry::evaluate {
namespace detail {
/// One entry of a list of COCO's, whose members are read by name and type.
class CocoEntry {
 public:
  CocoEntry(const nlohmann::json& value, const std::string& path, std::string position, std::string place)
      : value_(value), path_(path), position_(std::move(position)), place_(std::move(place)) {
    if (!value.is_object()) refuse("", "an object", value);
  }

  [[noreturn]] void fail(const std::string& key, const std::string& what, const std::string& expected,
                         const std::string& found, ErrorKind kind = ErrorKind::malformed) const {
    const std::string member = key.empty() ? place_ : place_ + "." + key;
    throw FileError(kind, {path_, position_, member + " " + what, expected, found});
  }
  [[noreturn]] void refuse(const std::string& key, const std::string& expected,
                           const nlohmann::json& value) const {
    const bool is_short = !value.is_structured() && !value.is_string();
    fail(key, "makes no sense", expected,
         value.is_string() ? in_quotes(value.get_ref<const std::string&>())
                           : in_quotes(is_short ? value.dump() : value.type_name()));
  }

  [[nodiscard]] bool has(const char* key) const { return value_.contains(key); }
  [[nodiscard]] const nlohmann::json& member(const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end()) fail(key, "is missing", "", "");
    return *found;
  }

  [[nodiscard]] std::uint64_t integer(const char* key, std::uint64_t low, std::uint64_t high) const {
    const auto& value = member(key);
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() < low || value.get<std::uint64_t>() > high)
      refuse(key, "a whole number from " + std::to_string(low) + " to " + std::to_string(high), value);
    return value.get<std::uint64_t>();
  }
  [[nodiscard]] std::string text(const char* key) const {
    const auto& value = member(key);
    if (!value.is_string() || value.get_ref<const std::string&>().empty())
      refuse(key, "a text that is not empty", value);
    return value.get<std::string>();
  }
  /// A number from −largest (or, for an extent, from 0) to largest.
  [[nodiscard]] double number(const char* key, const nlohmann::json& value, bool is_extent) const {
    constexpr double largest = 1e10;
    const double low = is_extent ? 0 : -largest;
    if (!value.is_number() || !(value.get<double>() >= low && value.get<double>() <= largest))
      refuse(key, is_extent ? "a number from 0 to 1e10" : "a number from -1e10 to 1e10", value);
    return value.get<double>();
  }

  [[nodiscard]] const std::string& place() const { return place_; }
  [[nodiscard]] const std::string& position() const { return position_; }

 private:
  const nlohmann::json& value_;
  const std::string& path_;
  std::string position_, place_;
};

/// Index of the entry with a given id.
using IndexOfId = std::map<std::uint64_t, std::size_t>;

class CocoReader {
 public:
  CocoReader(const io::JsonText& json, const std::string& path, std::string images)
      : json_(json), path_(path), images_(std::move(images)) {}

  [[nodiscard]] Dataset read() {
    if (!json_.value.is_object())
      throw malformed_file({path_, "", "not a COCO data set", "a JSON object", json_.value.type_name()});
    read_categories();
    read_pictures();
    read_annotations();
    return std::move(dataset_);
  }

 private:
  static constexpr std::uint64_t largest_id = std::uint64_t(1) << 53U;

  /// Calls visit(entry, id) for each entry of a list.
  template <class Visit>
  void for_each_entry(const char* list, Visit visit) const {
    const auto found = json_.value.find(list);
    if (found == json_.value.end())
      throw malformed_file({path_, "", "not a COCO data set of instances",
                            "lists images, annotations and categories", std::string("no ") + list});
    const std::string& position = json_.positions.at(list);
    if (!found->is_array())
      throw malformed_file(
          {path_, position, std::string(list) + " makes no sense", "a list", found->type_name()});
    IndexOfId first;
    for (std::size_t i = 0; i < found->size(); ++i) {
      const CocoEntry entry((*found)[i], path_, position, std::string(list) + "[" + std::to_string(i) + "]");
      const std::uint64_t id = entry.integer("id", 0, largest_id);
      const auto [other, is_new] = first.emplace(id, i);
      if (!is_new)
        entry.fail("id", "is given twice", "an id of its own",
                   std::to_string(id) + ", that of " + list + "[" + std::to_string(other->second) + "]");
      visit(entry, id);
    }
  }

  void read_categories() {
    std::map<std::uint64_t, std::string> names;
    std::map<std::string, std::uint64_t> id_of;
    for_each_entry("categories", [&](const CocoEntry& entry, std::uint64_t id) {
      const std::string name = entry.text("name");
      const auto [other, is_new] = id_of.emplace(name, id);
      if (!is_new)
        entry.fail("name", "is given twice", "a name of its own",
                   in_quotes(name) + ", that of id " + std::to_string(other->second));
      names.emplace(id, name);
    });
    for (const auto& [id, name] : names) {
      class_of_.emplace(id, dataset_.class_names.size());
      dataset_.class_names.push_back(name);
      dataset_.class_ids.push_back(id);
    }
  }

  void read_pictures() {
    constexpr std::uint64_t largest_side = std::uint64_t(1) << 20U;
    for_each_entry("images", [&](const CocoEntry& entry, std::uint64_t id) {
      const std::string name = entry.text("file_name");
      if (name.size() > io::longest_path)
        entry.fail("file_name", "is too long", "at most " + std::to_string(io::longest_path) + " bytes",
                   std::to_string(name.size()));
      if (!io::stays_below(name))
        entry.fail("file_name", "lies outside the folder of the pictures", "a name in it", in_quotes(name));
      LabelledPicture picture{(io::path_of(images_) / io::path_of(name)).string(), id,
                              static_cast<std::size_t>(entry.integer("height", 1, largest_side)),
                              static_cast<std::size_t>(entry.integer("width", 1, largest_side))};
      if (picture.path.find('\0') != std::string::npos || !io::is_regular_file(picture.path))
        entry.fail("file_name", "is missing", printable(picture.path), "no such file", ErrorKind::mismatch);
      dataset_.pictures.push_back(std::move(picture));
    });
    if (dataset_.pictures.empty())
      throw file_mismatch({path_, "", "no pictures", "entries of images", "none"});
    std::sort(dataset_.pictures.begin(), dataset_.pictures.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
    for (std::size_t i = 0; i < dataset_.pictures.size(); ++i)
      picture_of_.emplace(dataset_.pictures[i].id, i);
  }

  void read_annotations() {
    for_each_entry("annotations", [&](const CocoEntry& entry, std::uint64_t) {
      LabelledObject object;
      object.class_index = index_of(entry, "category_id", class_of_, "categories");
      auto& picture = dataset_.pictures[index_of(entry, "image_id", picture_of_, "images")];
      const auto& box = entry.member("bbox");
      if (!box.is_array() || box.size() != 4) entry.refuse("bbox", "[x, y, width, height]", box);
      double values[4];
      for (std::size_t i = 0; i < 4; ++i) values[i] = entry.number("bbox", box[i], i >= 2);
      object.box = {values[0] + values[2] / 2, values[1] + values[3] / 2, values[2], values[3]};
      object.area =
          entry.has("area") ? entry.number("area", entry.member("area"), true) : values[2] * values[3];
      object.is_crowd = entry.has("iscrowd") && entry.integer("iscrowd", 0, 1) == 1;
      picture.objects.push_back(object);
    });
  }

  [[nodiscard]] static std::size_t index_of(const CocoEntry& entry, const char* key, const IndexOfId& indices,
                                            const char* list) {
    const auto found = indices.find(entry.integer(key, 0, largest_id));
    if (found == indices.end())
      entry.fail(key, "is unknown", std::string("an id of ") + list, entry.member(key).dump(),
                 ErrorKind::mismatch);
    return found->second;
  }

  const io::JsonText& json_;
  const std::string& path_;
  std::string images_;
  Dataset dataset_;
  IndexOfId class_of_, picture_of_;
};
}  // namespace detail

Dataset parse_coco(std::string_view text, const std::string& path, const std::string& images) {
  const io::JsonText json = io::read_json(text, path);
  return detail::CocoReader(json, path, images).read();
}
}  // namespace tapestry::evaluate
