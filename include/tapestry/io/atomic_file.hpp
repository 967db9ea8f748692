#pragma once
#include <tapestry/core/error.hpp>
#include <tapestry/core/platform.hpp>

namespace tapestry::io {
namespace detail {
/// Name of a temporary file beside its target, shortened to the length that file systems allow.
std::string part_path(const std::string& target, unsigned attempt);

/// A temporary file beside its target. It is deleted unless it is renamed over the target, and locked while
/// its process lives.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& target);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();

  void write(std::span<const std::byte> bytes);

  void rename_over_target();

 private:
  /// Locks the file; false if remove_abandoned_parts() took it first. Not called on systems without locks.
  [[nodiscard]] bool claim() const;

  /// \throws FileError (write) if `reason`, an errno, is not 0
  void require(int reason, const char* action) const;

  std::string target_;
  std::string path_;
  platform::OpenFile file_{};
  bool renamed_ = false;
};
}  // namespace detail

/// Writes the parts one after the other to `path`. The path holds either the old file or the whole new one at
/// any time: a temporary in the same folder is written, flushed and renamed over the target.
/// \throws FileError (write); the old file is then unchanged and the temporary removed, except if
///         only flushing the folder failed, as the message then states
void write_file_atomically(const std::string& path, std::initializer_list<std::span<const std::byte>> parts);

/// The same for one block of bytes.
inline void write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  write_file_atomically(path, {bytes});
}

/// The same for text.
inline void write_file_atomically(const std::string& path, std::string_view text) {
  write_file_atomically(path, {std::as_bytes(std::span<const char>(text.data(), text.size()))});
}

/// Removes the temporaries that write_file_atomically() left in a folder when its process was killed. Files
/// of living processes are locked and stay. Failures are ignored, as nothing depends on it.
void remove_abandoned_parts(const std::string& folder);

/// Claims a folder, or a file to be written, for one process, by a lock of the operating system on
/// `FOLDER/.lock`, or on `.NAME.lock` beside the file NAME.
///
/// The lock ends with this object or with the process, however it ends. This object deletes its lock file.
/// The lock file of a killed process stays, but does not count as a claim. The file holds the owner's process
/// and host, for people to read. On network file systems that do not share such locks, only processes on the
/// same machine are locked out.
class RunLock {
 public:
  /// \throws FileError: in_use (another process holds it), write (the folder cannot be written)
  explicit RunLock(const std::string& folder) : RunLock(folder + "/.lock", folder, "folder") {}

  /// Claims a file, which need not exist. Errors as for the constructor.
  [[nodiscard]] static RunLock of_file(const std::string& path);

  RunLock(RunLock&& other) noexcept = default;
  RunLock& operator=(RunLock&& other) noexcept;
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;
  ~RunLock() { release(); }

  /// Releases the claim before the object is destroyed.
  void release() noexcept;

  /// Path of the lock file.
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  /// \param kind  of the claimed thing, in a word
  RunLock(std::string lock_path, const std::string& claimed, const char* kind);

  /// Text that the last owner wrote.
  [[nodiscard]] std::string text() const;

  void write_owner() const;

  std::string path_;
  platform::OpenFile file_{};
};
}  // namespace tapestry::io
