#pragma once
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/io/atomic_file.hpp>
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
  [[nodiscard]] static RunLock of_file(const std::string& path) {
    constexpr std::size_t longest = 255 - 6;  // a name, less what is added
    const auto slash = path.rfind('/');
    const std::size_t name = slash == std::string::npos ? 0 : slash + 1;
    return {path.substr(0, name) + "." + path.substr(name, longest) + ".lock", path, "file"};
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
  ~RunLock() { release(); }

  /// Gives the claim up before the object ends.
  void release() noexcept {
    if (descriptor_ < 0) return;
    ::unlink(path_.c_str());  // while it is locked: who has it open meanwhile looks whether it is still there
    ::close(std::exchange(descriptor_, -1));
  }

 private:
  /// \param kind  of what is claimed, in a word
  RunLock(std::string lock_path, const std::string& claimed, const char* kind) : path_(std::move(lock_path)) {
    for (int attempt = 0; descriptor_ < 0; ++attempt) {
      open();
      int status = 0;
      do {
        status = ::flock(descriptor_, LOCK_EX | LOCK_NB);
      } while (status != 0 && errno == EINTR);
      if (status == 0 && detail::is_still_at(path_, descriptor_)) break;
      const int reason = status != 0 ? errno : attempt < 100 ? 0 : EINVAL;  // its owner took the file away
      const std::string owner = text();
      ::close(std::exchange(descriptor_, -1));
      if (reason == EWOULDBLOCK)
        throw FileError(ErrorKind::in_use,
                        {.path = claimed, .what = std::string(kind) + " is in use by " + owner});
      if (reason != 0) fail(std::string("cannot lock: ") + std::strerror(reason));
    }
    write_owner();
  }

  void open() {
    do {
      descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    } while (descriptor_ < 0 && errno == EINTR);
    if (descriptor_ < 0) fail(std::string("cannot create the lock: ") + std::strerror(errno));
  }

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
