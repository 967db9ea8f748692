#pragma once
/// \file
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/detail/npy_header.hpp>
#include <tapestry/io/detail/number_formats.hpp>
#include <tapestry/io/detail/safetensors_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/json.hpp>

/// The compiled part of the reader of safetensors headers.

namespace tapestry::io {
namespace detail {

/// Bytes that the shape and the type require.
[[nodiscard]] inline std::uint64_t needed_bytes(const std::string& path, const Tensor& tensor) {
  std::uint64_t bytes = item_size(tensor.type);
  bool has_none = false;
  bool fits = true;
  for (const std::size_t extent : tensor.shape) {
    has_none = has_none || extent == 0;
    fits = fits && (extent == 0 || !__builtin_mul_overflow(bytes, std::uint64_t(extent), &bytes));
  }
  if (!fits)
    refuse_tensor(path, tensor, "shape too large", "fewer than 2^64 bytes", shape_text(tensor.shape));
  return has_none ? 0 : bytes;
}

/// The whole numbers of a list, each at most `most`.
[[nodiscard]] inline std::vector<std::uint64_t> counts_of(const std::string& path, const Tensor& tensor,
                                                          const std::string& field,
                                                          const nlohmann::json& list, std::size_t most) {
  const auto is_count = [](const nlohmann::json& number) { return number.is_number_unsigned(); };
  if (!list.is_array() || !std::ranges::all_of(list, is_count))
    refuse_tensor(path, tensor, field + " makes no sense",
                  "a list of whole numbers from 0 to 18446744073709551615");
  if (list.size() > most)
    refuse_tensor(path, tensor, "too many entries of " + field, "at most " + std::to_string(most),
                  std::to_string(list.size()));
  return list.get<std::vector<std::uint64_t>>();
}

[[nodiscard]] inline Tensor tensor_of(const std::string& path, Tensor tensor, const nlohmann::json& entry) {
  constexpr std::string_view fields = "dtype, shape and data_offsets";
  constexpr std::size_t largest_rank = 16;
  if (!entry.is_object())
    refuse_tensor(path, tensor, "not an entry", "an object of " + std::string(fields), entry.type_name());
  for (const auto& field : entry.items())
    if (field.key() != "dtype" && field.key() != "shape" && field.key() != "data_offsets")
      refuse_tensor(path, tensor, "unknown field", std::string(fields), in_quotes(field.key()));
  if (entry.size() != 3) refuse_tensor(path, tensor, "incomplete entry", std::string(fields));
  const auto known = std::ranges::find_if(
      tensor_types, [&](const TensorTypeFacts& type) { return entry["dtype"] == nlohmann::json(type.name); });
  if (known == tensor_types.end())
    refuse_tensor(path, tensor, "unknown dtype", "F32, F64, F16, BF16 or an integer type",
                  entry["dtype"].is_string() ? in_quotes(entry["dtype"].get_ref<const std::string&>())
                                             : entry["dtype"].type_name());
  tensor.type = static_cast<TensorType>(known - tensor_types.begin());
  const auto shape = counts_of(path, tensor, "shape", entry["shape"], largest_rank);
  tensor.shape.assign(shape.begin(), shape.end());
  const auto offsets = counts_of(path, tensor, "data_offsets", entry["data_offsets"], 2);
  if (offsets.size() != 2) refuse_tensor(path, tensor, "incomplete entry", "two data_offsets");
  tensor.begin = offsets[0];
  tensor.end = offsets[1];
  return tensor;
}

/// Checks that each tensor's span fits its shape, and that the spans follow each other without gaps.
inline void check_spans(const std::string& path, const std::vector<Tensor>& tensors,
                        std::uint64_t data_size) {
  std::uint64_t next = 0;
  const Tensor* last = nullptr;
  for (const Tensor& tensor : tensors) {
    const std::string span = std::to_string(tensor.begin) + " to " + std::to_string(tensor.end);
    if (tensor.end < tensor.begin)
      refuse_tensor(path, tensor, "data_offsets run backwards", "the end not before the beginning", span);
    if (tensor.end > data_size)
      refuse_tensor(path, tensor, "data_offsets pass the end of the file",
                    "at most " + std::to_string(data_size), span);
    const std::uint64_t needed = needed_bytes(path, tensor);
    if (needed != tensor.end - tensor.begin)
      refuse_tensor(path, tensor, "data_offsets do not span its shape",
                    std::to_string(needed) + " bytes for " + shape_text(tensor.shape) + " of " +
                        std::string(type_name(tensor.type)),
                    std::to_string(tensor.end - tensor.begin));
    if (tensor.begin != next)
      refuse_tensor(path, tensor,
                    tensor.begin < next ? "bytes overlap those of tensor " + in_quotes(last->name)
                                        : std::string("unused bytes before it"),
                    "to begin at " + std::to_string(next), std::to_string(tensor.begin));
    next = tensor.end;
    last = &tensor;
  }
  if (next != data_size)
    throw FileError(ErrorKind::malformed,
                    {path, "", "bytes after the last tensor", std::to_string(next) + " bytes of numbers",
                     std::to_string(data_size)});
}
}  // namespace detail

SafetensorsHeader parse_safetensors_header(std::string_view text, std::uint64_t data_size,
                                           const std::string& path) {
  constexpr std::uint64_t length_size = 8;
  constexpr std::size_t levels = 3;  // a shape in an entry in the header
  if (!text.starts_with('{'))
    throw FileError(ErrorKind::malformed, {path, "@8", "not a safetensors header", "'{'",
                                           text.empty() ? "no bytes" : in_quotes(text.substr(0, 20))});
  const JsonText json = read_json(text, path, length_size, levels);
  SafetensorsHeader header;
  header.size = length_size + text.size();
  for (const auto& item : json.value.items()) {
    const std::uint64_t position = json.positions.at(item.key());
    if (item.key() != "__metadata__") {
      header.tensors.push_back(
          detail::tensor_of(path, {.name = item.key(), .position = position}, item.value()));
      continue;
    }
    const auto is_text = [](const nlohmann::json& value) { return value.is_string(); };
    if (!item.value().is_object() || !std::ranges::all_of(item.value(), is_text))
      throw FileError(ErrorKind::malformed, {path, "@" + std::to_string(position),
                                             "__metadata__ makes no sense", "an object of strings"});
    header.metadata = item.value().get<std::map<std::string, std::string>>();
  }
  std::ranges::sort(header.tensors, {},
                    [](const Tensor& tensor) { return std::pair(tensor.begin, tensor.end); });
  detail::check_spans(path, header.tensors, data_size);
  return header;
}

std::string safetensors_header_text(const std::map<std::string, std::string>& metadata,
                                    const std::vector<NamedShape>& tensors) {
  nlohmann::json header{{"__metadata__", metadata}};
  std::uint64_t begin = 0;
  for (const auto& [name, shape] : tensors) {
    std::uint64_t end = sizeof(float);
    for (const std::size_t extent : shape) end *= extent;
    end += begin;
    const nlohmann::json entry{{"dtype", "F32"}, {"shape", shape}, {"data_offsets", {begin, end}}};
    if (!header.emplace(name, entry).second)
      throw DomainError({"write_safetensors: tensor ", in_quotes(name), " given twice"});
    begin = end;
  }
  try {
    std::string text = header.dump();
    text.append((8 - text.size() % 8) % 8, ' ');
    return text;
  } catch (const nlohmann::json::type_error&) {
    throw DomainError("write_safetensors: a name or the metadata is not UTF-8");
  }
}

}  // namespace tapestry::io

namespace tapestry::io::detail {

SafetensorsHeader read_safetensors_header(const RegularFile& file) {
  const auto fail = [&](ErrorKind kind, const std::string& what, const std::string& expected,
                        std::uint64_t found) {
    throw FileError(kind, {file.path(), "@0", what, expected, std::to_string(found) + " bytes"});
  };
  std::array<std::byte, 16> beginning{};
  if (file.size() < 8)
    fail(ErrorKind::malformed, "file too short", "a header's length, 8 bytes", file.size());
  const auto first = std::span(beginning).first(file.size() < 16 ? 8 : 16);
  file.read_at(0, first);
  const std::string_view recognised = recognised_format(first);
  if (!recognised.empty() && recognised != recognised_safetensors)
    throw FileError(ErrorKind::malformed, {file.path(), "@0", "not a safetensors file", "a .safetensors file",
                                           std::string(recognised)});
  const auto length = little_endian_word<std::uint64_t>(beginning.data());
  if (length > file.size() - 8)
    fail(ErrorKind::malformed, "header passes the end of the file",
         "at most " + std::to_string(file.size() - 8) + " bytes", length);
  if (length > largest_safetensors_header)
    fail(ErrorKind::limit, "header too large", "at most 16777216 bytes", length);
  std::string text(static_cast<std::size_t>(length), '\0');
  file.read_at(8, std::as_writable_bytes(std::span<char>(text)));
  return parse_safetensors_header(text, file.size() - 8 - length, file.path());
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

void SafetensorsFile::read(const Tensor& tensor, std::span<float> values, std::size_t first) const {
  if (first > tensor.size() || values.size() > tensor.size() - first)
    throw ShapeError({"SafetensorsFile::read: values is [", values.size(), "], expected at most [",
                      tensor.size(), "] less the first ", first});
  if (tensor.type == TensorType::f32) {
    read_converted<float_from_f32>(tensor, values, first);
  } else if (tensor.type == TensorType::f64) {
    read_converted<float_from_f64>(tensor, values, first);
  } else if (tensor.type == TensorType::f16) {
    read_converted<float_from_f16>(tensor, values, first);
  } else if (tensor.type == TensorType::bf16) {
    read_converted<float_from_bf16>(tensor, values, first);
  } else {
    detail::refuse_tensor(path(), tensor, "not floating point", "F32, F64, F16 or BF16",
                          std::string(type_name(tensor.type)), ErrorKind::mismatch);
  }
  file_.require_unchanged();
}

void write_safetensors(const std::string& path, const std::map<std::string, std::string>& metadata,
                       const std::vector<NamedShape>& tensors, std::span<const float> values) {
  const std::string text = safetensors_header_text(metadata, tensors);
  if (text.size() > largest_safetensors_header)
    throw DomainError(
        {"write_safetensors: the header is ", text.size(), " bytes, expected at most 16777216"});
  try {
    (void)parse_safetensors_header(text, values.size_bytes(), path);
  } catch (const FileError& error) {
    throw DomainError({"write_safetensors: ", error.details().what});
  }
  const auto length = little_endian_bytes(std::uint64_t(text.size()));
  const auto header = std::as_bytes(std::span<const char>(text));
  if constexpr (std::endian::native == std::endian::little) {
    write_file_atomically(path, {length, header, std::as_bytes(values)});
  } else {
    std::vector<std::byte> swapped;
    for (const float value : values)
      for (const std::byte byte : little_endian_bytes(std::bit_cast<std::uint32_t>(value)))
        swapped.push_back(byte);
    write_file_atomically(path, {length, header, swapped});
  }
}

}  // namespace tapestry::io
