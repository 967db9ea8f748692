#pragma once
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <tapestry/core/error.hpp>
#include <utility>

namespace tapestry::io {

/// Claims a folder for one process, by a lock of the operating system on `<folder>/.lock`.
///
/// The lock ends with this object or with the process, however that ends; the file stays and is no sign of a
/// claim. It holds the process and host of the last owner, for people. Network file systems that do not share
/// such locks protect against the same machine only.
class RunLock {
 public:
  /// \throws FileError: in_use (another process has it), write (the folder cannot be written)
  explicit RunLock(const std::string& folder) : path_(folder + "/.lock") {
    do {
      descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    } while (descriptor_ < 0 && errno == EINTR);
    if (descriptor_ < 0) fail(std::string("cannot create the lock: ") + std::strerror(errno));
    int status = 0;
    do {
      status = ::flock(descriptor_, LOCK_EX | LOCK_NB);
    } while (status != 0 && errno == EINTR);
    if (status != 0) {
      const int reason = errno;
      const std::string owner = text();
      ::close(descriptor_);
      if (reason != EWOULDBLOCK) fail(std::string("cannot lock: ") + std::strerror(reason));
      throw FileError(ErrorKind::in_use, {.path = folder, .what = "folder is in use by " + owner});
    }
    write_owner();
  }
  RunLock(RunLock&& other) noexcept
      : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}
  RunLock& operator=(RunLock&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;
  ~RunLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw FileError(ErrorKind::write, {.path = path_, .what = what});
  }

  /// What the last owner wrote.
  [[nodiscard]] std::string text() const {
    std::array<char, 200> buffer{};
    const ::ssize_t count = ::pread(descriptor_, buffer.data(), buffer.size(), 0);
    std::string owner(buffer.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
    while (!owner.empty() && owner.back() == '\n') owner.pop_back();
    return owner.empty() ? "another process" : owner;
  }

  void write_owner() const {
    std::array<char, 256> host{};
    if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
    const std::string owner = "process " + std::to_string(::getpid()) + " on " + host.data() + "\n";
    // The text is a courtesy: a full disk must not lose the claim.
    if (::ftruncate(descriptor_, 0) == 0 && ::pwrite(descriptor_, owner.data(), owner.size(), 0) < 0) return;
  }

  std::string path_;
  int descriptor_ = -1;
};

}  // namespace tapestry::io
