#pragma once
#include <bit>
#include <map>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/io/file_source.hpp>

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
  std::uint64_t begin = 0;           ///< first of its bytes, counted from the end of the header
  std::uint64_t end = 0;             ///< one past its last byte
  std::uint64_t position = 0;        ///< of its entry in the file, for messages

  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(end - begin) / item_size(type); }
};

/// Header of a safetensors file: the metadata, text by key, and the tensors in the order of their bytes.
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

/// Reads the header's JSON, without the eight bytes of its length, and checks every tensor against the size
/// of the data that follow. Integer types are known only so that messages can name them; they are not read.
///
/// Source: the format's description, https://github.com/huggingface/safetensors#format. Stricter: unknown
/// fields of a tensor, more than 16 axes and more than 131,072 tensors are refused.
/// Compiled where a program includes implementation.hpp.
///
/// \param data_size  bytes of the file after the header
/// \throws FileError malformed (or limit) with the byte and, if a tensor is at fault, its name
[[nodiscard]] SafetensorsHeader parse_safetensors_header(std::string_view text, std::uint64_t data_size,
                                                         const std::string& path);

/// The header of F32 tensors that lie one after another in the given order, padded with blanks so that they
/// begin at a multiple of 8 bytes; compiled as parse_safetensors_header().
/// \throws DomainError for names that repeat and for text that is not UTF-8
[[nodiscard]] std::string safetensors_header_text(const std::map<std::string, std::string>& metadata,
                                                  const std::vector<NamedShape>& tensors);

/// Metadata of a converted detector, beside its tensors.
struct DetectorMetadata {
  std::string cfg;                   ///< text of the Darknet cfg file, whole and unchanged
  std::uint64_t images_seen = 0;     ///< in training
  bool is_folded = false;            ///< batch normalisation is part of the weights
  double batch_norm_epsilon = 1e-5;  ///< inside the root; for a folded detector, the one used in folding
  detect::DecodeFamily decode = detect::DecodeFamily::darknet;  ///< stored only here
};

/// The metadata as fields of a safetensors file. Numbers are the shortest decimals that read back the same.
[[nodiscard]] std::map<std::string, std::string> fields_of(const DetectorMetadata& metadata);

/// The reverse of fields_of(); other fields are ignored.
/// \throws FileError  mismatch for a field that is missing or has an unsupported value, malformed for an
///                  invalid field or a cfg that does not match its hash
[[nodiscard]] DetectorMetadata parse_detector_metadata(const std::map<std::string, std::string>& fields,
                                                       const std::string& path);

/// Most bytes of a header.
inline constexpr std::uint64_t largest_safetensors_header = std::uint64_t(16) << 20U;

namespace detail {
[[nodiscard]] SafetensorsHeader read_safetensors_header(const RegularFile& file);
}  // namespace detail

/// A safetensors file: named arrays of numbers. The header is read and checked at once, the numbers on
/// demand. A file that is cut or grows while it is open is refused. One that is renamed or deleted stays
/// readable. One that is overwritten in place at the same size is not noticed, and yields old and new
/// numbers. Takes memory of at most 48 times its header and 1 MiB.
class SafetensorsFile {
 public:
  /// \throws FileError as RegularFile and parse_safetensors_header() do; malformed also if the header extends
  ///         beyond the file, limit above 16 MiB of header or `limit` bytes in all
  explicit SafetensorsFile(const std::string& path, std::uint64_t limit = default_file_limit)
      : file_(path, limit), header_(detail::read_safetensors_header(file_)) {
    file_.require_unchanged();
  }

  [[nodiscard]] const std::string& path() const { return file_.path(); }
  [[nodiscard]] const std::map<std::string, std::string>& metadata() const { return header_.metadata; }
  [[nodiscard]] const std::vector<Tensor>& tensors() const { return header_.tensors; }

  /// Byte of the file where element `index` of a tensor stands, for messages.
  [[nodiscard]] std::uint64_t position(const Tensor& tensor, std::size_t index = 0) const {
    return header_.size + tensor.begin + std::uint64_t(index) * item_size(tensor.type);
  }

  /// Reads as many elements of a tensor as `values` holds, from `first` on. F32, F16 and BF16 are exact; F64
  /// is rounded to the nearest float, and to infinity beyond the largest.
  /// \throws FileError  mismatch for integers, malformed if the file has changed its size
  /// \throws ShapeError if the tensor has fewer
  void read(const Tensor& tensor, std::span<float> values, std::size_t first = 0) const;

  /// Throws FileError (malformed) if the file no longer has the size it was opened with.
  void require_unchanged() const { file_.require_unchanged(); }

 private:
  template <auto float_from>
  void read_converted(const Tensor& tensor, std::span<float> values, std::size_t first) const {
    const std::uint64_t begin = position(tensor, first);
    if (tensor.type == TensorType::f32 && std::endian::native == std::endian::little) {
      file_.read_at(begin, std::as_writable_bytes(values));
      return;
    }
    const std::size_t item = item_size(tensor.type);
    std::vector<std::byte> bytes(item * values.size());
    file_.read_at(begin, bytes);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = float_from(bytes.data() + item * i);
  }

  RegularFile file_;
  SafetensorsHeader header_;
};

/// Writes tensors of F32, or leaves the old file as it was. The same arguments give the same bytes.
///
/// \param metadata  names and values in UTF-8
/// \param tensors with different names
/// \param values    the elements of all tensors, one after the other
/// \throws FileError (write); DomainError for a file that no reader would accept: repeated names, text that
///         is not UTF-8, more than 16 MiB of header, or another number of values than the shapes have
void write_safetensors(const std::string& path, const std::map<std::string, std::string>& metadata,
                       const std::vector<NamedShape>& tensors, std::span<const float> values);

}  // namespace tapestry::io
