#pragma once
#include <unistd.h>
#include <tapestry/core/compiled.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {

/// Bytes that a reader accepts at most unless told otherwise.
inline constexpr std::uint64_t default_file_limit = std::uint64_t(4) << 30U;

/// Bytes of the longest path that Linux opens; a longer one in a file is not even taken apart.
inline constexpr std::size_t longest_path = 4096;

/// Whether a name within a file leads to the folder that it begins in or below that: not an absolute path,
/// nor one that leaves the folder by `..`. Links are not looked at.
[[nodiscard]] bool stays_below(const std::string& name);

/// A regular file open for reading, whose size was checked against a limit before anything is read.
///
/// Folders, FIFOs and devices are refused without waiting on them. A file that changes its size while it
/// is read is refused too; nothing is memory-mapped, so a cut file cannot kill the process.
class RegularFile {
 public:
  /// \param path   as the user gave it
  /// \param limit  largest accepted size in bytes
  /// \throws FileError  malformed if it cannot be opened or is not a regular file, limit if it is larger
  explicit RegularFile(std::string path, std::uint64_t limit = default_file_limit);

  RegularFile(const RegularFile&) = delete;
  RegularFile& operator=(const RegularFile&) = delete;
  ~RegularFile() { ::close(descriptor_); }

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// Fills `bytes` with the file's content from byte `offset` on.
  /// \throws FileError (malformed) if the file ends before or cannot be read
  void read_at(std::uint64_t offset, std::span<std::byte> bytes) const;

  /// Throws FileError (malformed) if the file no longer has the size it was opened with.
  void require_unchanged_size() const;

 private:
  [[nodiscard]] std::uint64_t measured_size() const;

  [[noreturn]] void fail(ErrorKind kind, const std::string& what) const {
    throw FileError(kind, {path_, "", what});
  }

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// The whole content of a regular file of at most `limit` bytes.
/// \throws FileError as RegularFile does
[[nodiscard]] std::vector<std::byte> read_file(const std::string& path,
                                               std::uint64_t limit = default_file_limit);

/// As read_file(), as text; line ends and encoding are left as they are.
[[nodiscard]] std::string read_text_file(const std::string& path, std::uint64_t limit = default_file_limit);

/// What recognised_format() says of one of the formats that Tapestry reads.
inline constexpr std::string_view recognised_safetensors = "a safetensors file";

/// What a file that begins with these bytes probably is, when it is a well-known kind of file that people
/// pass by mistake; empty when nothing is recognised. At least 16 bytes should be given.
[[nodiscard]] std::string_view recognised_format(std::span<const std::byte> beginning);

}  // namespace tapestry::io
