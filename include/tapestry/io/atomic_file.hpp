#pragma once

#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

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
  /// Locks the file; false if remove_abandoned_parts() was quicker. Where there are no locks, it is not
  /// asked.
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
///         says that only flushing the folder failed
void write_file_atomically(const std::string& path, std::initializer_list<std::span<const std::byte>> parts);

/// As above, for one block of bytes.
inline void write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  write_file_atomically(path, {bytes});
}

/// As above, for text.
inline void write_file_atomically(const std::string& path, std::string_view text) {
  write_file_atomically(path, {std::as_bytes(std::span<const char>(text.data(), text.size()))});
}

/// Removes from a folder the temporaries that write_file_atomically() left there when its process was killed;
/// those of living processes are locked and stay. Failures are ignored: nothing depends on it.
void remove_abandoned_parts(const std::string& folder);

}  // namespace tapestry::io
