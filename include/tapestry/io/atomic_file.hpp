#pragma once
#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <utility>

namespace tapestry::io {
namespace detail {

/// Name of a temporary beside its target, cut to what file systems allow.
std::string part_path(const std::string& target, unsigned attempt);

/// A file beside its target that vanishes unless it is renamed over the target. It is locked as long as its
/// process lives.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& target);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();

  void write(std::span<const std::byte> bytes);

  void rename_over_target();

 private:
  /// Locks the file; false if remove_abandoned_parts() was quicker. Not called where there are no locks.
  [[nodiscard]] bool claim() const;

  [[noreturn]] void fail(const char* action) const;

  std::string target_;
  std::string path_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

/// Whether a path still names the regular file that is open.
bool is_still_at(const std::string& path, int descriptor);
}  // namespace detail

/// Writes the parts one after the other to `path`, so that whatever happens either the old file or the
/// whole new one is found there: a temporary in the same folder, flushed, then renamed over it.
/// \throws FileError (write); the old file is then unchanged and the temporary removed, unless the message
///         is that only flushing the folder failed
void write_file_atomically(const std::string& path, std::initializer_list<std::span<const std::byte>> parts);

/// The same for one block of bytes.
inline void write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  write_file_atomically(path, {bytes});
}

/// The same for text.
inline void write_file_atomically(const std::string& path, std::string_view text) {
  write_file_atomically(path, {std::as_bytes(std::span<const char>(text.data(), text.size()))});
}

/// Removes from a folder the temporaries that write_file_atomically() left there when its process was killed;
/// those of living processes are locked and stay. Failures are ignored: nothing depends on it.
void remove_abandoned_parts(const std::string& folder);

/// Claims a folder, or a file to be written, for one process, by a lock of the operating system on
/// `FOLDER/.lock`, or on `.NAME.lock` beside the file NAME.
///
/// The lock ends with this object or with the process, however that ends. The object takes its file away
/// again; that of a killed process stays and is no sign of a claim. It holds the process and host of the
/// owner, for people. Network file systems that do not share such locks protect against the same machine
/// only.
class RunLock {
 public:
  /// \throws FileError: in_use (another process has it), write (the folder cannot be written)
  explicit RunLock(const std::string& folder) : RunLock(folder + "/.lock", folder, "folder") {}

  /// Claims a file, which need not be there. Errors as of the constructor.
  [[nodiscard]] static RunLock of_file(const std::string& path);

  RunLock(RunLock&& other) noexcept
      : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}
  RunLock& operator=(RunLock&& other) noexcept;
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;
  ~RunLock() { release(); }

  /// Gives the claim up before the object ends.
  void release() noexcept;

 private:
  /// \param kind  of what is claimed, in a word
  RunLock(std::string lock_path, const std::string& claimed, const char* kind);

  void open();

  [[noreturn]] void fail(const std::string& what) const {
    throw FileError(ErrorKind::write, {.path = path_, .what = what});
  }

  /// Text that the last owner wrote.
  [[nodiscard]] std::string text() const;

  void write_owner() const;

  std::string path_;
  int descriptor_ = -1;
};

}  // namespace tapestry::io
