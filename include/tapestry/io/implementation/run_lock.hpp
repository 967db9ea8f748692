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
#include <tapestry/io/run_lock.hpp>
#include <utility>

namespace tapestry::io {

RunLock RunLock::of_file(const std::string& path) {
  constexpr std::size_t longest = 255 - 6;  // a name, less what is added
  const auto slash = path.rfind('/');
  const std::size_t name = slash == std::string::npos ? 0 : slash + 1;
  return {path.substr(0, name) + "." + path.substr(name, longest) + ".lock", path, "file"};
}

RunLock& RunLock::operator=(RunLock&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

void RunLock::release() noexcept {
  if (descriptor_ < 0) return;
  ::unlink(path_.c_str());  // while it is locked: who has it open meanwhile looks whether it is still there
  ::close(std::exchange(descriptor_, -1));
}

RunLock::RunLock(std::string lock_path, const std::string& claimed, const char* kind)
    : path_(std::move(lock_path)) {
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

void RunLock::open() {
  do {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) fail(std::string("cannot create the lock: ") + std::strerror(errno));
}

std::string RunLock::text() const {
  std::array<char, 200> buffer{};
  const ::ssize_t count = ::pread(descriptor_, buffer.data(), buffer.size(), 0);
  std::string owner(buffer.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  while (!owner.empty() && owner.back() == '\n') owner.pop_back();
  return owner.empty() ? "another process" : owner;
}

void RunLock::write_owner() const {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
  const std::string owner = "process " + std::to_string(::getpid()) + " on " + host.data() + "\n";
  // The text is a courtesy: a full disk must not lose the claim.
  if (::ftruncate(descriptor_, 0) == 0 && ::pwrite(descriptor_, owner.data(), owner.size(), 0) < 0) return;
}

}  // namespace tapestry::io
