#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/safetensors_header.hpp>
#include <vector>

namespace tapestry::io {

inline constexpr std::uint64_t largest_safetensors_header = std::uint64_t(16) << 20U;

namespace detail {
[[nodiscard]] SafetensorsHeader read_safetensors_header(const RegularFile& file);
}  // namespace detail

/// A safetensors file: named arrays of numbers. Its header is read and checked at once, numbers when they are
/// asked for. A file that is cut or grows meanwhile is refused; one that is renamed or deleted stays
/// readable; one that is overwritten in place at its size is not noticed, and gives old and new numbers.
/// Takes memory of at most 48 times its header and 1 MiB.
class SafetensorsFile {
 public:
  /// \throws FileError as RegularFile and parse_safetensors_header() do; malformed also when the header
  ///         passes the end of the file, limit above 16 MiB of header or `limit` bytes in all
  explicit SafetensorsFile(const std::string& path, std::uint64_t limit = default_file_limit)
      : file_(path, limit), header_(detail::read_safetensors_header(file_)) {
    file_.require_unchanged_size();
  }

  [[nodiscard]] const std::string& path() const { return file_.path(); }
  [[nodiscard]] const std::map<std::string, std::string>& metadata() const { return header_.metadata; }
  [[nodiscard]] const std::vector<Tensor>& tensors() const { return header_.tensors; }

  /// Byte of the file where element `index` of a tensor stands, for messages.
  [[nodiscard]] std::uint64_t position(const Tensor& tensor, std::size_t index = 0) const {
    return header_.size + tensor.begin + std::uint64_t(index) * item_size(tensor.type);
  }

  /// Reads elements of a tensor, from `first` on, as many as `values` holds: F32 straight into them, F16 and
  /// BF16 exactly, F64 rounded to the nearest float, and to infinity beyond the largest.
  /// \throws FileError  mismatch for integers, malformed if the file has changed its size
  /// \throws ShapeError if the tensor has fewer
  void read(const Tensor& tensor, std::span<float> values, std::size_t first = 0) const;

  /// Throws FileError (malformed) if the file no longer has the size it was opened with.
  void require_unchanged_size() const { file_.require_unchanged_size(); }

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
/// \param tensors   whose names differ
/// \param values    the elements of all tensors, one after the other
/// \throws FileError (write); DomainError for what no reader would accept: names that repeat, text that is
///         not UTF-8, more than 16 MiB of header, another number of values than the shapes say
void write_safetensors(const std::string& path, const std::map<std::string, std::string>& metadata,
                       const std::vector<NamedShape>& tensors, std::span<const float> values);

}  // namespace tapestry::io
