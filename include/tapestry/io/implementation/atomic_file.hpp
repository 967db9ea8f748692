#pragma once
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <new>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {
namespace detail {

inline constexpr std::string_view part_mark = ".tapestry-part";

std::string part_path(const std::string& target, unsigned attempt) {
  const std::string end = std::string(part_mark) + std::to_string(::getpid()) + "-" + std::to_string(attempt);
  const auto slash = target.find_last_of('/');
  const std::size_t folder = slash == std::string::npos ? 0 : slash + 1;
  constexpr std::size_t longest = 255;
  return target.substr(0, folder + std::min(target.size() - folder, longest - end.size())) + end;
}

TemporaryFile::TemporaryFile(const std::string& target) : target_(target) {
  for (unsigned attempt = 0; descriptor_ < 0; ++attempt) {
    path_ = part_path(target, attempt);
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno != EEXIST && errno != EINTR) fail("create a file beside it");
    if (descriptor_ >= 0 && !claim()) {
      ::close(descriptor_);
      descriptor_ = -1;
    }
  }
  struct ::stat status {};
  if (::stat(target_.c_str(), &status) == 0) ::fchmod(descriptor_, status.st_mode & 0777U);
}

TemporaryFile::~TemporaryFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!renamed_) ::unlink(path_.c_str());
}

void TemporaryFile::write(std::span<const std::byte> bytes) {
  constexpr std::size_t largest = std::size_t(1) << 30U;
  while (!bytes.empty()) {
    const ::ssize_t count = ::write(descriptor_, bytes.data(), std::min(bytes.size(), largest));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("write");
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void TemporaryFile::rename_over_target() {
  while (::fsync(descriptor_) != 0)
    if (errno != EINTR) fail("flush");
  if (::rename(path_.c_str(), target_.c_str()) != 0) fail("rename into place");
  renamed_ = true;  // closed only now, which releases the lock; fsync has reported any error of closing
}

bool TemporaryFile::claim() const {
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return false;
  struct ::stat status {};
  return ::fstat(descriptor_, &status) != 0 || status.st_nlink > 0;
}

void TemporaryFile::fail(const char* action) const {
  throw FileError(ErrorKind::write,
                  {target_, "", std::string("cannot ") + action + ": " + std::strerror(errno)});
}

/// Makes a rename within the folder of `path` durable, on file systems that can do so.
/// \throws FileError (write) where the device fails
inline void flush_folder_of(const std::string& path) {
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  int status = 0;
  do {
    status = ::fsync(descriptor);
  } while (status != 0 && errno == EINTR);
  const int reason = status == 0 ? 0 : errno;
  ::close(descriptor);
  if (reason == EIO || reason == ENOSPC || reason == EDQUOT)
    throw FileError(ErrorKind::write,
                    {path, "",
                     "written, but may not outlast a loss of power: cannot flush its folder: " +
                         std::string(std::strerror(reason))});
}

/// Whether a name ends like that of a temporary: in a process and an attempt, `12-0`.
inline bool is_part_name(std::string_view name) {
  const auto mark = name.rfind(part_mark);
  if (mark == std::string_view::npos) return false;
  const std::string_view numbers = name.substr(mark + part_mark.size());
  const auto dash = numbers.find('-');
  const auto is_number = [](std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
  };
  return dash != std::string_view::npos && is_number(numbers.substr(0, dash)) &&
         is_number(numbers.substr(dash + 1));
}

bool is_still_at(const std::string& path, int descriptor) {
  struct ::stat open {
  }, there{};
  return ::fstat(descriptor, &open) == 0 && ::lstat(path.c_str(), &there) == 0 && S_ISREG(open.st_mode) &&
         open.st_dev == there.st_dev && open.st_ino == there.st_ino;
}

}  // namespace detail

void write_file_atomically(const std::string& path, std::initializer_list<std::span<const std::byte>> parts) {
  struct ::stat status {};
  if (path.find('\0') != std::string::npos || path.empty())
    throw FileError(ErrorKind::write, {path, "", "not a file name"});
  if (const int failed = ::stat(path.c_str(), &status); failed != 0 && errno != ENOENT && errno != ENOTDIR) {
    throw FileError(ErrorKind::write, {path, "", std::string("cannot inspect: ") + std::strerror(errno)});
  } else if (failed == 0 && !S_ISREG(status.st_mode)) {
    throw FileError(ErrorKind::write, {path, "", "exists and is not a regular file"});
  }
  detail::TemporaryFile temporary(path);
  for (const auto& part : parts) temporary.write(part);
  temporary.rename_over_target();
  detail::flush_folder_of(path);
}

void remove_abandoned_parts(const std::string& folder) {
  std::error_code ignored;
  std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, ignored);
  for (; !ignored && entry != std::filesystem::directory_iterator(); entry.increment(ignored)) {
    const std::string path = entry->path().string();
    if (!detail::is_part_name(entry->path().filename().string())) continue;
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0) continue;
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && detail::is_still_at(path, descriptor))
      ::unlink(path.c_str());
    ::close(descriptor);
  }
}

RunLock RunLock::of_file(const std::string& path) {
  constexpr std::size_t longest = 255 - 6;  // a name, less prefix and ending
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
  ::unlink(path_.c_str());  // while locked: a process that has it open checks if it is still there
  ::close(std::exchange(descriptor_, -1));
}

RunLock::RunLock(std::string lock_path, const std::string& claimed, const char* kind)
    : path_(std::move(lock_path)) {
  const auto fail = [&](const char* action, int reason) {
    throw FileError(
        ErrorKind::write,
        {.path = claimed, .what = std::string("cannot ") + action + " its lock: " + std::strerror(reason)});
  };
  for (int attempt = 0; descriptor_ < 0; ++attempt) {
    if (const int reason = open(); reason != 0) fail("create", reason);
    int status = 0;
    do {
      status = ::flock(descriptor_, LOCK_EX | LOCK_NB);
    } while (status != 0 && errno == EINTR);
    if (status == 0 && detail::is_still_at(path_, descriptor_)) break;
    const int reason = status != 0 ? errno : attempt < 100 ? 0 : EINVAL;  // its owner deleted the file
    const std::string owner = text();
    ::close(std::exchange(descriptor_, -1));
    if (reason == EWOULDBLOCK)
      throw FileError(ErrorKind::in_use,
                      {.path = claimed, .what = std::string(kind) + " is in use by " + owner});
    if (reason != 0) fail("take", reason);
  }
  write_owner();
}

int RunLock::open() {
  do {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
  } while (descriptor_ < 0 && errno == EINTR);
  return descriptor_ < 0 ? errno : 0;
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
  // The text is for people only: if the disk is full, the claim still holds.
  if (::ftruncate(descriptor_, 0) == 0 && ::pwrite(descriptor_, owner.data(), owner.size(), 0) < 0) return;
}

}  // namespace tapestry::io
