#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/name_numbers.hpp>
#include <tapestry/io/npy.hpp>
#include <tapestry/io/zip_archive.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {

/// The arrays of an .npz file, all of them read and verified at once.
class NpzFile {
 public:
  /// Takes memory of at most 4 times the file, 2 times its arrays and 1 MiB.
  /// \throws FileError: malformed (damaged archive or array, pickled objects), limit (larger than `limits`)
  [[nodiscard]] static NpzFile read(const std::string& path, const ZipLimits& limits = {}) {
    return parse(read_text_file(path, limits.file_bytes), path, limits);
  }

  /// As read(), for a file held in memory; `path` is for messages.
  [[nodiscard]] static NpzFile parse(std::string_view bytes, const std::string& path,
                                     const ZipLimits& limits = {});

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Of the arrays, without .npy.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] bool has(std::string_view name) const { return find(name) != nullptr; }

  /// \throws FileError (mismatch) listing the members there are, when `name` is not among them
  [[nodiscard]] const NpyArray& get(std::string_view name) const;

  /// A member as an array; see NpyArray::array().
  template <class T, std::size_t Rank>
  [[nodiscard]] Array<T, Rank> array(std::string_view name) const {
    return get(name).template array<T, Rank>();
  }

 private:
  [[nodiscard]] const NpyArray* find(std::string_view name) const;

  std::string path_;
  std::vector<std::string> names_;
  std::vector<NpyArray> arrays_;
  NameNumbers numbers_;  ///< of names, no two of which are alike in an archive
};

/// Collects arrays and writes them as one .npz file that NumPy can load.
class NpzWriter {
 public:
  template <class T, std::size_t Rank>
  void add(const std::string& name, const Array<T, Rank>& array) {
    const auto shape = array.shape();
    add(name, std::span<const std::size_t>(shape.data(), Rank),
        std::span<const T>(array.data(), array.size()));
  }

  /// A list becomes an array of one axis.
  template <class T>
  void add(const std::string& name, const std::vector<T>& list) {
    const std::size_t shape[] = {list.size()};
    add(name, std::span<const std::size_t>(shape), std::span<const T>(list));
  }

  /// A number becomes an array without axes.
  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void add(const std::string& name, T number) { add(name, {}, std::span<const T>(&number, 1)); }

  /// Text becomes an array of its bytes.
  void add(const std::string& name, std::string_view text) {
    add(name, std::vector<std::uint8_t>(text.begin(), text.end()));
  }

  /// Elements in row-major order under a shape of any number of axes.
  template <class T>
  void add(const std::string& name, std::span<const std::size_t> shape, std::span<const T> elements) {
    members_.emplace_back(name + ".npy", npy_bytes<T>(shape, elements));
  }

  /// The bytes of the file.
  [[nodiscard]] std::string bytes(bool compress = false) const;

  /// Replaces `path` by the whole file, or leaves it as it was. Equal arrays give equal bytes.
  /// \throws FileError (write); Error (limit) beyond 4 GiB
  void write(const std::string& path, bool compress = false) const {
    write_file_atomically(path, bytes(compress));
  }

 private:
  std::vector<std::pair<std::string, std::string>> members_;
};

}  // namespace tapestry::io
