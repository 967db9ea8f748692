#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
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

}  // namespace detail

/// A tensor to write.
struct NamedShape {
  std::string name;
  std::vector<std::size_t> shape;
};

/// Reads the header's JSON, without the eight bytes of its length, and checks every tensor against the bytes
/// that follow. Integer types are known, so that messages can name them, though nothing here reads them.
///
/// Source: the format's description, https://github.com/huggingface/safetensors#format. Stricter than it:
/// unknown fields of a tensor, more than 16 axes and more than 131,072 tensors are refused.
/// Compiled where a program includes implementation.hpp.
///
/// \param data_size  bytes of the file after the header
/// \throws FileError  malformed (or limit) with the byte and, where one is at fault, the tensor's name
[[nodiscard]] SafetensorsHeader parse_safetensors_header(std::string_view text, std::uint64_t data_size,
                                                         const std::string& path);

/// The header of tensors of F32 that lie one after the other in the given order, with blanks so that they
/// begin at a multiple of 8 bytes; compiled as parse_safetensors_header().
/// \throws DomainError for names that repeat and for text that is not UTF-8
[[nodiscard]] std::string safetensors_header_text(const std::map<std::string, std::string>& metadata,
                                                  const std::vector<NamedShape>& tensors);

}  // namespace tapestry::io
