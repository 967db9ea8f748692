#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/json_reader.hpp>
#include <tapestry/io/npy_header.hpp>
#include <tapestry/io/text_lines.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {

/// Element types of safetensors files that Tapestry knows; the first four are read as numbers.
enum class TensorType { f32, f64, f16, bf16, boolean, u8, i8, u16, i16, u32, i32, u64, i64 };

namespace detail {
struct TensorTypeFacts {
  std::string_view name;
  std::size_t size;
};
inline constexpr std::array<TensorTypeFacts, 13> tensor_types{{{"F32", 4},
                                                               {"F64", 8},
                                                               {"F16", 2},
                                                               {"BF16", 2},
                                                               {"BOOL", 1},
                                                               {"U8", 1},
                                                               {"I8", 1},
                                                               {"U16", 2},
                                                               {"I16", 2},
                                                               {"U32", 4},
                                                               {"I32", 4},
                                                               {"U64", 8},
                                                               {"I64", 8}}};
}  // namespace detail

/// The name of a type in a file: "F32".
[[nodiscard]] constexpr std::string_view type_name(TensorType type) {
  return detail::tensor_types[static_cast<std::size_t>(type)].name;
}

/// Bytes of one element.
[[nodiscard]] constexpr std::size_t item_size(TensorType type) {
  return detail::tensor_types[static_cast<std::size_t>(type)].size;
}

/// One entry of the header.
struct Tensor {
  std::string name;
  TensorType type = TensorType::f32;
  std::vector<std::size_t> shape{};  ///< empty for a single number
  std::uint64_t begin = 0;           ///< of its bytes, counted from the end of the header
  std::uint64_t end = 0;             ///< one past its last byte
  std::uint64_t position = 0;        ///< of its entry in the file, for messages

  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(end - begin) / item_size(type); }
};

/// What stands before the numbers: free text by key, and the tensors in the order of their bytes.
struct SafetensorsHeader {
  std::map<std::string, std::string> metadata{};
  std::vector<Tensor> tensors{};
  std::uint64_t size = 0;  ///< bytes before the first tensor
};

namespace detail {

[[noreturn]] inline void refuse_tensor(const std::string& path, const Tensor& tensor, const std::string& what,
                                       const std::string& expected = "", const std::string& found = "",
                                       ErrorKind kind = ErrorKind::malformed) {
  throw FileError(kind, {path, "@" + std::to_string(tensor.position),
                         "tensor " + in_quotes(tensor.name) + ": " + what, expected, found});
}

[[nodiscard]] inline TensorType tensor_type(const std::string& path, const Tensor& tensor,
                                            const std::string& name) {
  const auto found = std::ranges::find(tensor_types, name, &TensorTypeFacts::name);
  if (found == tensor_types.end())
    refuse_tensor(path, tensor, "unknown dtype", "F32, F64, F16, BF16 or an integer type", in_quotes(name));
  return static_cast<TensorType>(found - tensor_types.begin());
}

/// Bytes that the shape and the type ask for.
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

[[nodiscard]] inline Tensor read_tensor_entry(JsonReader& reader, const std::string& path,
                                              const std::string& name) {
  constexpr std::size_t largest_rank = 16;
  Tensor tensor;
  tensor.name = name;
  tensor.position = reader.position();
  std::string type;
  std::vector<std::uint64_t> offsets;
  std::size_t fields = 0;
  reader.object([&](const std::string& field) {
    ++fields;
    if (field == "dtype") {
      type = reader.string();
    } else if (field == "shape") {
      reader.array([&] {
        if (tensor.shape.size() == largest_rank)
          refuse_tensor(path, tensor, "too many axes", "at most 16", "more");
        tensor.shape.push_back(static_cast<std::size_t>(reader.count()));
      });
    } else if (field == "data_offsets") {
      reader.array([&] {
        if (offsets.size() == 2) refuse_tensor(path, tensor, "too many data_offsets", "two", "more");
        offsets.push_back(reader.count());
      });
    } else {
      refuse_tensor(path, tensor, "unknown field", "dtype, shape and data_offsets", in_quotes(field));
    }
  });
  if (fields != 3 || offsets.size() != 2)
    refuse_tensor(path, tensor, "incomplete entry", "dtype, shape and two data_offsets");
  tensor.type = tensor_type(path, tensor, type);
  tensor.begin = offsets[0];
  tensor.end = offsets[1];
  return tensor;
}

/// Each tensor's span fits its shape, and the spans follow each other from the first byte to the last.
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

/// Reads the header's JSON, without the eight bytes of its length, and checks every tensor against the bytes
/// that follow. Integer types are known, so that messages can name them, though nothing here reads them.
///
/// Source: the format's description, https://github.com/huggingface/safetensors#format. Stricter than it:
/// unknown fields of a tensor, more than 16 axes and more than 131,072 tensors are refused.
///
/// \param data_size  bytes of the file after the header
/// \throws FileError  malformed (or limit) with the byte and, where one is at fault, the tensor's name
[[nodiscard]] inline SafetensorsHeader parse_safetensors_header(std::string_view text,
                                                                std::uint64_t data_size,
                                                                const std::string& path) {
  constexpr std::uint64_t length_size = 8;
  SafetensorsHeader header;
  header.size = length_size + text.size();
  if (!text.starts_with('{'))
    throw FileError(ErrorKind::malformed, {path, "@8", "not a safetensors header", "'{'",
                                           text.empty() ? "no bytes" : in_quotes(text.substr(0, 20))});
  JsonReader reader(text, path, length_size);
  reader.object([&](const std::string& name) {
    if (name == "__metadata__")
      reader.object([&](const std::string& key) { header.metadata.emplace(key, reader.string()); });
    else
      header.tensors.push_back(detail::read_tensor_entry(reader, path, name));
  });
  reader.end();
  std::ranges::sort(header.tensors, {},
                    [](const Tensor& tensor) { return std::pair(tensor.begin, tensor.end); });
  detail::check_spans(path, header.tensors, data_size);
  return header;
}

}  // namespace tapestry::io
