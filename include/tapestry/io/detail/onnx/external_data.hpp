#pragma once
#include <optional>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/detail/onnx/protobuf_message.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {
/// Place of a tensor's elements outside the file itself.
struct ExternalReference {
  std::string_view location{};            ///< a path relative to the model's folder
  std::uint64_t offset = 0;               ///< of the first byte
  std::optional<std::uint64_t> length{};  ///< in bytes; if missing, up to the end of the file
};

/// The files beside a model that hold elements of its tensors. Only files below the model's folder are
/// opened, after links are resolved, so a model cannot read other files. If the model is itself a link, as in
/// the folders of model hubs, a link beside it may also lead to a file directly beside the model's target. A
/// file with several names is refused, since hard links cannot be resolved: another name may be anywhere.
/// Source: ONNX, docs/ExternalData.md.
class ExternalData {
 public:
  /// \param model_path   of the file that refers to others
  /// \param byte_budget most bytes to read for all tensors together
  ExternalData(std::string model_path, std::uint64_t byte_budget)
      : model_path_(std::move(model_path)), byte_budget_(byte_budget), bytes_left_(byte_budget) {}

  /// Reads one entry, a StringStringEntryProto, into the reference; unknown keys ("checksum") are ignored.
  /// \throws FileError (malformed) for offsets and lengths that are not whole numbers
  static void read_entry(ProtobufMessage entry, ExternalReference& reference) {
    std::string_view key;
    std::string_view value;
    while (entry.next()) {
      if (entry.tag() == 1) key = entry.bytes("key");
      if (entry.tag() == 2) value = entry.bytes("value");
    }
    if (key == "location") reference.location = value;
    if (key == "offset") reference.offset = whole_number(entry, key, value);
    if (key == "length") reference.length = whole_number(entry, key, value);
  }

  /// The bytes of a tensor.
  /// \param size number of bytes that its extents and type require
  /// \param tensor  for messages
  /// \throws FileError  malformed for a path that leaves the model's folder and a file that cannot be read,
  ///                    mismatch for one of another size, limit beyond the budget
  [[nodiscard]] std::vector<std::byte> read(const ExternalReference& reference, std::uint64_t size,
                                            const ProtobufMessage& tensor) {
    const std::string label = "external data " + in_quotes(reference.location);
    const std::string path = path_inside_folder(reference.location, label, tensor);
    try {
      const RegularFile file(path);
      if (file.name_count() > 1)
        tensor.fail_whole(label + " is a hard link, whose other names may lie outside of the folder",
                          "a file of one name, such as a copy", std::to_string(file.name_count()) + " names");
      const std::uint64_t left = file.size() < reference.offset ? 0 : file.size() - reference.offset;
      if (file.size() < reference.offset || reference.length.value_or(left) > left)
        tensor.fail_whole(label + " ends early",
                          std::to_string(reference.length.value_or(size)) + " bytes from byte " +
                              std::to_string(reference.offset) + " on",
                          std::to_string(file.size()) + " bytes in all", ErrorKind::mismatch);
      if (reference.length.value_or(left) != size)
        tensor.fail_whole(label + " does not fit type and extents", std::to_string(size) + " bytes",
                          std::to_string(reference.length.value_or(left)), ErrorKind::mismatch);
      take(size, label, tensor);
      std::vector<std::byte> bytes(static_cast<std::size_t>(size));
      file.read_at(reference.offset, bytes);
      file.require_unchanged();
      return bytes;
    } catch (const FileError& error) {
      if (error.details().path != path) throw;
      tensor.fail_whole(label + ": " + error.details().what, error.details().expected, error.details().found,
                        error.kind());
    }
  }

 private:
  static std::uint64_t whole_number(const ProtobufMessage& entry, std::string_view key,
                                    std::string_view text) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || number > largest_offset)
      entry.fail_whole(std::string(key) + " of external data", "a whole number of bytes", in_quotes(text));
    return number;
  }

  [[nodiscard]] std::string path_inside_folder(std::string_view location, const std::string& label,
                                               const ProtobufMessage& tensor) const {
    namespace fs = std::filesystem;
    constexpr const char* expected = "a path inside the model's folder";
    if (location.empty() || location.find('\0') != std::string_view::npos)
      tensor.fail_whole(label + " names no file", expected);
    const fs::path path = path_of(location);
    if (path.has_root_path()) tensor.fail_whole(label + " is an absolute path", expected);
    for (const fs::path& part : path)
      if (part == "..") tensor.fail_whole(label + " leaves its folder by '..'", expected);
    std::error_code error;
    const fs::path model = path_of(model_path_), parent = model.parent_path();
    const fs::path folder = fs::canonical(parent.empty() ? fs::path(".") : parent, error);
    const fs::path target = error ? fs::path() : fs::canonical(folder / path, error);
    if (error) tensor.fail_whole(label + " cannot be opened: " + error.message());
    const fs::path inside = target.lexically_relative(folder);
    const bool is_below = !inside.empty() && *inside.begin() != "..";
    const bool is_beside_link = fs::is_symlink(model, error) && !error &&
                                target.parent_path() == fs::canonical(model, error).parent_path();
    if (!is_below && (error || !is_beside_link))
      tensor.fail_whole(label + " is a link that leads out of the folder", expected, "",
                        ErrorKind::malformed);
    return target.string();
  }

  void take(std::uint64_t size, const std::string& label, const ProtobufMessage& tensor) {
    if (size > bytes_left_)
      tensor.fail_whole(label + " is too much with that of other tensors",
                        "at most " + std::to_string(byte_budget_) + " bytes in all", "more",
                        ErrorKind::limit);
    bytes_left_ -= size;
  }

  static constexpr std::uint64_t largest_offset = std::uint64_t(1) << 62U;

  std::string model_path_;
  std::uint64_t byte_budget_;
  std::uint64_t bytes_left_;
};
}  // namespace tapestry::io
