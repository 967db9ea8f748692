#pragma once

#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <utility>

namespace tapestry::io {

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

  /// What the last owner wrote.
  [[nodiscard]] std::string text() const;

  void write_owner() const;

  std::string path_;
  int descriptor_ = -1;
};

}  // namespace tapestry::io
