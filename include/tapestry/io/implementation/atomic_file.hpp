#pragma once
#include <cerrno>
#include <cstring>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {
namespace detail {
inline constexpr std::string_view part_mark = ".tapestry-part";

std::string part_path(const std::string& target, unsigned attempt) {
  const std::string end =
      std::string(part_mark) + std::to_string(platform::process_number()) + "-" + std::to_string(attempt);
  const auto slash = target.find_last_of(platform::separators);
  const std::size_t folder = slash == std::string::npos ? 0 : slash + 1;
  constexpr std::size_t longest = 255;
  return target.substr(0, folder + std::min(target.size() - folder, longest - end.size())) + end;
}

TemporaryFile::TemporaryFile(const std::string& target) : target_(target) {
  for (unsigned attempt = 0; !file_.is_open(); ++attempt) {
    path_ = part_path(target, attempt);
    if (const int reason = file_.open(path_, platform::Access::create); reason != EEXIST)
      require(reason, "create a file beside it");
    if (file_.is_open() && !claim()) file_.close();
  }
  std::error_code ignored;
  if (const auto status = std::filesystem::status(path_of(target_), ignored); std::filesystem::exists(status))
    std::filesystem::permissions(path_of(path_), status.permissions() & std::filesystem::perms::all, ignored);
}

TemporaryFile::~TemporaryFile() {
  file_.close();
  if (!renamed_) platform::remove_file(path_.c_str());
}

void TemporaryFile::write(std::span<const std::byte> bytes) { require(file_.write(bytes), "write"); }

void TemporaryFile::rename_over_target() {
  require(file_.flush(), "flush");
  require(platform::replace_file(path_, target_), "rename into place");
  renamed_ = true;  // closed only now, which releases the lock; flushing has reported any error of closing
}

bool TemporaryFile::claim() const {
  platform::FileState state;
  return file_.lock() != EWOULDBLOCK && (file_.inspect(state) != 0 || state.name_count > 0);
}

void TemporaryFile::require(int reason, const char* action) const {
  if (reason != 0)
    throw FileError(ErrorKind::write,
                    {target_, "", std::string("cannot ") + action + ": " + std::strerror(reason)});
}

/// Makes a rename within the folder of `path` durable, on file systems that can do so.
/// \throws FileError (write) where the device fails
inline void flush_folder_of(const std::string& path) {
  const auto slash = path.find_last_of(platform::separators);
  if (const int reason = platform::flush_folder(slash == std::string::npos ? "." : path.substr(0, slash + 1));
      reason != 0)
    throw FileError(ErrorKind::write,
                    {path, "",
                     "written, but may not outlast a loss of power: cannot flush its folder: " +
                         std::string(std::strerror(reason))});
}

/// Whether a name ends like a temporary's: in a process and an attempt, `12-0`.
inline bool is_part_name(std::string_view name) {
  const auto mark = name.rfind(part_mark);
  if (mark == std::string_view::npos) return false;
  const std::string_view numbers = name.substr(mark + part_mark.size());
  const auto dash = numbers.find_first_not_of("0123456789");
  return dash != std::string_view::npos && dash > 0 && numbers[dash] == '-' && dash + 1 < numbers.size() &&
         numbers.find_first_not_of("0123456789", dash + 1) == std::string_view::npos;
}
}  // namespace detail

void write_file_atomically(const std::string& path, std::initializer_list<std::span<const std::byte>> parts) {
  if (path.find('\0') != std::string::npos || path.empty())
    throw FileError(ErrorKind::write, {path, "", "not a file name"});
  if (const auto status = status_of(path, ErrorKind::write);
      std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw FileError(ErrorKind::write, {path, "", "exists and is not a regular file"});
  detail::TemporaryFile temporary(path);
  for (const auto& part : parts) temporary.write(part);
  temporary.rename_over_target();
  detail::flush_folder_of(path);
}

void remove_abandoned_parts(const std::string& folder) {
  if (!can_be_listed(folder.empty() ? "." : folder)) return;
  std::error_code ignored;
  std::filesystem::directory_iterator entry(path_of(folder.empty() ? "." : folder), ignored);
  for (; !ignored && entry != std::filesystem::directory_iterator(); entry.increment(ignored)) {
    const std::string path = entry->path().string();
    if (!detail::is_part_name(entry->path().filename().string())) continue;
    platform::OpenFile file;
    if (file.open(path, platform::Access::read) == 0 && file.lock() == 0 && file.is_still_at(path))
      platform::remove_file(path.c_str());
  }
}

RunLock RunLock::of_file(const std::string& path) {
  constexpr std::size_t longest = 255 - 6;  // a name, less prefix and ending
  const auto slash = path.find_last_of(platform::separators);
  const std::size_t name = slash == std::string::npos ? 0 : slash + 1;
  return {path.substr(0, name) + "." + path.substr(name, longest) + ".lock", path, "file"};
}

RunLock& RunLock::operator=(RunLock&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(file_, other.file_);
  return *this;
}

void RunLock::release() noexcept {
  if (!file_.is_open()) return;
  // Deleted while it is locked: a process that has it open checks if it is still there.
  platform::remove_file(path_.c_str());
  file_.close();
}

RunLock::RunLock(std::string lock_path, const std::string& claimed, const char* kind)
    : path_(std::move(lock_path)) {
  const auto fail = [&](const char* action, int reason) {
    throw FileError(ErrorKind::write,
                    {claimed, "", std::string("cannot ") + action + " its lock: " + std::strerror(reason)});
  };
  for (int attempt = 0; !file_.is_open(); ++attempt) {
    if (const int reason = file_.open(path_, platform::Access::share); reason != 0) fail("create", reason);
    const int failure = file_.lock();
    if (failure == 0 && file_.is_still_at(path_)) break;
    const int reason = failure != 0 ? failure : attempt < 100 ? 0 : EINVAL;  // its owner deleted the file
    const std::string owner = text();
    file_.close();
    if (reason == EWOULDBLOCK)
      throw FileError(ErrorKind::in_use, {claimed, "", std::string(kind) + " is in use by " + owner});
    if (reason != 0) fail("take", reason);
  }
  write_owner();
}

std::string RunLock::text() const {
  std::array<char, 200> buffer{};
  const std::ptrdiff_t count = file_.read_at(0, std::as_writable_bytes(std::span<char>(buffer)));
  std::string owner(buffer.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  while (!owner.empty() && owner.back() == '\n') owner.pop_back();
  return owner.empty() ? "another process" : owner;
}

void RunLock::write_owner() const {
  const std::string owner =
      "process " + std::to_string(platform::process_number()) + " on " + platform::host_name() + "\n";
  // The text is for people only: if the disk is full, the claim still holds.
  (void)file_.replace(std::as_bytes(std::span<const char>(owner)));
}
}  // namespace tapestry::io
