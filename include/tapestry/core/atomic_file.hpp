#pragma once
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>

namespace tapestry {
namespace detail {

/// A file beside its target that vanishes unless it is renamed over the target.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& target) : target_(target) {
    for (unsigned attempt = 0; descriptor_ < 0; ++attempt) {
      path_ = target + ".part" + std::to_string(::getpid()) + "-" + std::to_string(attempt);
      descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ < 0 && errno != EEXIST && errno != EINTR) fail("create a file beside it");
    }
    struct ::stat status {};
    if (::stat(target_.c_str(), &status) == 0) ::fchmod(descriptor_, status.st_mode & 0777U);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!renamed_) ::unlink(path_.c_str());
  }

  void write(std::span<const std::byte> bytes) {
    constexpr std::size_t largest = std::size_t(1) << 30U;
    while (!bytes.empty()) {
      const ::ssize_t count = ::write(descriptor_, bytes.data(), std::min(bytes.size(), largest));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail("write");
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
  }

  void rename_over_target() {
    while (::fsync(descriptor_) != 0)
      if (errno != EINTR) fail("flush");
    const int closed = ::close(descriptor_);  // never again, even after EINTR: the descriptor is gone
    descriptor_ = -1;
    if (closed != 0 && errno != EINTR) fail("close");
    if (::rename(path_.c_str(), target_.c_str()) != 0) fail("rename into place");
    renamed_ = true;
  }

 private:
  [[noreturn]] void fail(const char* action) const {
    throw FileError(ErrorKind::write,
                    {target_, "", std::string("cannot ") + action + ": " + std::strerror(errno)});
  }

  std::string target_;
  std::string path_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

/// Makes a rename within the folder of `path` durable; file systems that cannot are left to themselves.
inline void flush_folder_of(const std::string& path) {
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  while (::fsync(descriptor) != 0 && errno == EINTR) {
  }
  ::close(descriptor);
}
}  // namespace detail

/// Writes the parts one after the other to `path`, so that whatever happens either the old file or the
/// whole new one is found there: a temporary in the same folder, flushed, then renamed over it.
/// \throws FileError (write); the old file is then unchanged and the temporary removed
inline void write_file_atomically(const std::string& path,
                                  std::initializer_list<std::span<const std::byte>> parts) {
  struct ::stat status {};
  if (path.find('\0') != std::string::npos || path.empty()) {
    throw FileError(ErrorKind::write, {path, "", "not a file name"});
  }
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
    throw FileError(ErrorKind::write, {path, "", "exists and is not a regular file"});
  }
  detail::TemporaryFile temporary(path);
  for (const auto& part : parts) temporary.write(part);
  temporary.rename_over_target();
  detail::flush_folder_of(path);
}

/// As above, for one block of bytes.
inline void write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  write_file_atomically(path, {bytes});
}

/// As above, for text.
inline void write_file_atomically(const std::string& path, std::string_view text) {
  write_file_atomically(path, {std::as_bytes(std::span<const char>(text.data(), text.size()))});
}

}  // namespace tapestry
