#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/float_formats.hpp>
#include <tapestry/io/safetensors_file.hpp>
#include <tapestry/io/safetensors_header.hpp>
#include <utility>
#include <vector>

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
    throw ShapeError("SafetensorsFile::read: values is [" + std::to_string(values.size()) +
                     "], expected at most [" + std::to_string(tensor.size()) + "] less the first " +
                     std::to_string(first));
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
  file_.require_unchanged_size();
}

void write_safetensors(const std::string& path, const std::map<std::string, std::string>& metadata,
                       const std::vector<NamedShape>& tensors, std::span<const float> values) {
  const std::string text = safetensors_header_text(metadata, tensors);
  if (text.size() > largest_safetensors_header)
    throw DomainError("write_safetensors: the header is " + std::to_string(text.size()) +
                      " bytes, expected at most 16777216");
  try {
    (void)parse_safetensors_header(text, values.size_bytes(), path);
  } catch (const FileError& error) {
    throw DomainError("write_safetensors: " + error.details().what);
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
