#pragma once
#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <tapestry/core/error.hpp>
#include <tapestry/core/platform.hpp>

/// \file
/// The first header of io/: readers and writers of files, which may be damaged or hostile.
///
///   read    path --> RegularFile --> bytes --> parse_…(bytes, name) --> value
///                    size limit                every count checked before memory is taken
///   write   value --> bytes --> write_file_atomically() --> path
///                               the old file or the whole new one
///
/// read_…(path) reads a file, parse_…() the same content in memory. A FileError states the path, the line or
/// byte, what was found and what was expected. Comments state the most memory that a reader takes.
///
/// Read next: text_lines.hpp and text_lists.hpp for text, npy.hpp for bytes, atomic_file.hpp for writing.

namespace tapestry::io {
/// Default limit of the bytes that a reader accepts.
inline constexpr std::uint64_t default_file_limit = std::uint64_t(4) << 30U;

/// Length in bytes of the longest path that Linux opens; a longer one in a file is refused unparsed.
inline constexpr std::size_t longest_path = 4096;

/// Path of a file whose name is UTF-8, on every system: only Linux takes the name as it is.
[[nodiscard]] inline std::filesystem::path path_of(std::string_view name) {
  return std::u8string(name.begin(), name.end());
}

/// Whether a name within a file leads to the folder it starts from, or below: it is not absolute and does not
/// leave the folder by `..`. Links are not checked.
[[nodiscard]] bool stays_below(const std::string& name);

/// A regular file open for reading. Its size is checked against a limit before anything is read.
///
/// Folders, FIFOs and devices are refused without waiting on them. A file that changes while it is read is
/// refused, too. Nothing is memory-mapped, so a file that is cut cannot kill the process. If an InputLedger
/// lives, it records the file.
class RegularFile {
 public:
  /// \param path path, for messages as well
  /// \param limit  largest accepted size in bytes
  /// \throws FileError  malformed if it cannot be opened or is not a regular file, limit if it is larger,
  ///                    mismatch if an InputLedger has recorded other bytes
  explicit RegularFile(std::string path, std::uint64_t limit = default_file_limit);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// Fills `bytes` with the file's content from byte `offset` on.
  /// \throws FileError (malformed) if the file ends before or cannot be read
  void read_at(std::uint64_t offset, std::span<std::byte> bytes) const;

  /// Throws FileError (malformed) if the file has changed since it was opened, by its size or its times.
  /// Readers call it when they have read.
  void require_unchanged() const;

  /// Size, number and times of the file when it was opened: equal only if nothing was written between.
  [[nodiscard]] const std::string& stamp() const { return stamp_; }

  /// Number of names (hard links) that the file has in its file system.
  [[nodiscard]] std::uint64_t name_count() const;

  /// SHA-256 of the content, in hexadecimal digits. Reads the file in pieces of 1 MiB.
  [[nodiscard]] std::string sha256() const;

 private:
  /// State of the file now. \throws FileError (malformed) if it cannot be inspected
  [[nodiscard]] platform::FileState state() const;

  /// Tells the ledger, if one lives.
  void record() const;

  [[noreturn]] void fail(ErrorKind kind, const std::string& what) const {
    throw FileError(kind, {path_, "", what});
  }

  std::string path_;
  platform::OpenFile file_{};
  std::uint64_t size_ = 0;
  std::string stamp_{};
};

/// The whole content of a regular file of at most `limit` bytes.
/// \throws FileError as RegularFile does
[[nodiscard]] std::vector<std::byte> read_file(const std::string& path,
                                               std::uint64_t limit = default_file_limit);

/// Like read_file(), as text; line ends and encoding are unchanged.
[[nodiscard]] std::string read_text_file(const std::string& path, std::uint64_t limit = default_file_limit);

/// The probable kind of a file with these first bytes, if it is a kind that people often pass by mistake;
/// else empty. Pass at least 16 bytes.
[[nodiscard]] std::string_view recognised_format(std::span<const std::byte> beginning);

// The only functions that examine a path without opening it. ENOENT and ENOTDIR mean that nothing is there.
// Any other failure (no permission, a device that fails, links in a ring) is an error, never absence.

/// The status of the file that a path leads to; file_type::not_found if there is none.
/// \param kind of the error: malformed for files to be read, write for files to be written
/// \throws FileError of that kind where the status cannot be read
[[nodiscard]] inline std::filesystem::file_status status_of(const std::string& path,
                                                            ErrorKind kind = ErrorKind::malformed) {
  std::error_code failure;
  const auto status = std::filesystem::status(path_of(path), failure);
  using std::filesystem::file_type;
  if (status.type() == file_type::none || (failure && status.type() != file_type::not_found))
    throw FileError(kind, {path, "", "cannot inspect: " + failure.message()});
  return status;
}

/// Whether a path leads to anything. Errors as of status_of().
[[nodiscard]] inline bool is_there(const std::string& path, ErrorKind kind = ErrorKind::malformed) {
  return std::filesystem::exists(status_of(path, kind));
}

/// Whether a path leads to a folder. Errors as of status_of().
[[nodiscard]] inline bool is_folder(const std::string& path, ErrorKind kind = ErrorKind::malformed) {
  return std::filesystem::is_directory(status_of(path, kind));
}

/// Whether a path leads to a regular file. Errors as of status_of().
[[nodiscard]] inline bool is_regular_file(const std::string& path, ErrorKind kind = ErrorKind::malformed) {
  return std::filesystem::is_regular_file(status_of(path, kind));
}

/// For a path that leads nowhere the nearest one as far as its first absent part, such as "; did you mean
/// a/car.obj?"; empty if no name there is near.
[[nodiscard]] std::string path_remedy(const std::string& path);

/// False on Windows for a folder of so long a path that mingw would list another one.
[[nodiscard]] inline bool can_be_listed(const std::string& folder) {
  constexpr bool is_windows = std::filesystem::path::preferred_separator != '/';
  return !is_windows || std::filesystem::absolute(path_of(folder)).native().size() < 250;
}

/// Paths of the folder's entries for which `accepts` returns true, sorted.
/// \throws FileError (malformed, limit) if the folder cannot be listed; std::bad_alloc
template <std::predicate<const std::filesystem::path&> Accepts>
[[nodiscard]] std::vector<std::string> listed_paths(const std::string& folder, Accepts accepts) {
  if (!can_be_listed(folder))
    throw FileError(ErrorKind::limit,
                    {folder, "", "its path is too long to list it", "less than 250 letters"});
  std::vector<std::string> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(path_of(folder), error), end; !error && entry != end;
       entry.increment(error))
    if (accepts(entry->path())) paths.push_back(entry->path().string());
  if (error == std::errc::not_enough_memory) throw std::bad_alloc();
  if (error)
    throw malformed_file({folder, "",
                          "cannot list the folder: " + error.message() +
                              (error == std::errc::not_a_directory ? "; give the folder that it lies in"
                                                                   : path_remedy(folder))});
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// Endings of names of readable pictures, for messages.
[[nodiscard]] std::string picture_endings();

/// Whether a name has the ending of a readable picture.
[[nodiscard]] bool has_picture_name(const std::filesystem::path& path);

/// SHA-256 of bytes that are added in pieces. Source: FIPS 180-4, sections 4.1.2, 5.1.1, 6.2.
class Sha256 {
 public:
  void add(std::span<const std::byte> bytes);

  /// The digest of the bytes added, as 64 hexadecimal digits; nothing may be added afterwards.
  [[nodiscard]] std::string hex();

 private:
  static constexpr std::array<std::uint32_t, 64> constants{
      0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
      0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
      0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
      0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
      0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
      0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
      0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
      0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

  void mix();

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::byte, 64> block_{};
  std::size_t filled_ = 0;
  std::uint64_t length_ = 0;
};

/// SHA-256 of bytes, as 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view bytes);
}  // namespace tapestry::io
