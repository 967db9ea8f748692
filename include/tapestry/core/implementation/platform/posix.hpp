#pragma once
#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <tapestry/core/platform.hpp>
#include <tapestry/core/platform/memory.hpp>
#if defined(__APPLE__)
#include <mach-o/dyld.h>
#endif

namespace tapestry::platform {
/// Calls until no signal interrupts the call.
template <class Call>
auto uninterrupted(Call call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}
inline int failure_of(int result) { return result < 0 ? errno : 0; }
inline int descriptor_of(std::intptr_t handle) { return static_cast<int>(handle); }

#if defined(__APPLE__)  // written after its manual, not tried
inline ::timespec change_of(const struct ::stat& status) { return status.st_mtimespec; }
// fsync() does not wait for the device there; some file systems can do no more.
inline int flush_device(int file) { return ::fcntl(file, F_FULLFSYNC) == 0 ? 0 : ::fsync(file); }
inline std::ptrdiff_t read_program_path(std::string& path) {
  auto size = static_cast<std::uint32_t>(path.size());
  return ::_NSGetExecutablePath(path.data(), &size) == 0 ? static_cast<std::ptrdiff_t>(path.find('\0')) : 0;
}
inline constexpr double peak_units_per_mib = 1024 * 1024;
#else
inline ::timespec change_of(const struct ::stat& status) { return status.st_mtim; }
inline int flush_device(int file) { return ::fsync(file); }
inline std::ptrdiff_t read_program_path(std::string& path) {
  return ::readlink("/proc/self/exe", path.data(), path.size());
}
inline constexpr double peak_units_per_mib = 1024;
#endif

int OpenFile::open(const std::string& path, Access access) {
  close();
  constexpr std::array flags{O_RDONLY | O_NONBLOCK | O_NOCTTY, O_WRONLY | O_CREAT | O_EXCL,
                             O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK};
  const int flag = flags[static_cast<std::size_t>(access)] | O_CLOEXEC;
  const int descriptor = uninterrupted([&] { return ::open(path.c_str(), flag, 0666); });
  handle_ = descriptor;
  return failure_of(descriptor);
}

void OpenFile::close() noexcept {
  if (is_open()) ::close(descriptor_of(std::exchange(handle_, none)));
}

int OpenFile::lock() const {
  return failure_of(uninterrupted([&] { return ::flock(descriptor_of(handle_), LOCK_EX | LOCK_NB); }));
}

std::ptrdiff_t OpenFile::read_at(std::uint64_t offset, std::span<std::byte> bytes) const {
  return uninterrupted([&] {
    return ::pread(descriptor_of(handle_), bytes.data(), bytes.size(), static_cast<::off_t>(offset));
  });
}

int OpenFile::write(std::span<const std::byte> bytes) const {
  constexpr std::size_t largest = std::size_t(1) << 30U;
  while (!bytes.empty()) {
    const auto count = uninterrupted(
        [&] { return ::write(descriptor_of(handle_), bytes.data(), std::min(bytes.size(), largest)); });
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return 0;
}

int OpenFile::replace(std::span<const std::byte> bytes) const {
  const int file = descriptor_of(handle_);
  return ::ftruncate(file, 0) != 0 || ::pwrite(file, bytes.data(), bytes.size(), 0) < 0 ? errno : 0;
}

int OpenFile::flush() const {
  return failure_of(uninterrupted([&] { return flush_device(descriptor_of(handle_)); }));
}

int OpenFile::inspect(FileState& state) const {
  struct ::stat status {};
  if (::fstat(descriptor_of(handle_), &status) != 0) return errno;
  state.kind = S_ISREG(status.st_mode)   ? FileKind::regular
               : S_ISDIR(status.st_mode) ? FileKind::folder
                                         : FileKind::other;
  state.size = static_cast<std::uint64_t>(status.st_size);
  state.name_count = status.st_nlink;
  state.stamp.clear();
  for (const auto part :
       {static_cast<long long>(status.st_dev), static_cast<long long>(status.st_ino),
        static_cast<long long>(status.st_size), static_cast<long long>(change_of(status).tv_sec),
        static_cast<long long>(change_of(status).tv_nsec)})
    state.stamp += std::to_string(part) + ' ';
  return 0;
}

bool OpenFile::is_still_at(const std::string& path) const {
  struct ::stat open {
  }, there{};
  return ::fstat(descriptor_of(handle_), &open) == 0 && ::lstat(path.c_str(), &there) == 0 &&
         S_ISREG(open.st_mode) && open.st_dev == there.st_dev && open.st_ino == there.st_ino;
}

int replace_file(const std::string& from, const std::string& to) {
  return failure_of(::rename(from.c_str(), to.c_str()));
}

int flush_folder(const std::string& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return 0;
  const int reason = failure_of(uninterrupted([&] { return ::fsync(descriptor); }));
  ::close(descriptor);
  return reason == EIO || reason == ENOSPC || reason == EDQUOT ? reason : 0;
}

int remove_file(const char* path) noexcept { return failure_of(::unlink(path)); }

long process_number() { return ::getpid(); }

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "?";
}

std::string program_path() {
  std::string path(4096, '\0');
  const auto length = read_program_path(path);
  path.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
  return path;
}

std::vector<std::string> command_line_words(int argc, char** argv) { return {argv, argv + argc}; }

void set_variable(const char* name, const std::string& value) { ::setenv(name, value.c_str(), 1); }

inline std::string machine_name() {
  ::utsname system{};
  return ::uname(&system) == 0 ? system.machine : "unknown";
}

ProcessCost process_cost() {
  ::rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return {static_cast<double>(usage.ru_maxrss) / peak_units_per_mib, usage.ru_nvcsw, usage.ru_minflt};
}

std::uint64_t machine_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  std::uint64_t bytes =
      pages > 0 && size > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(size) : 0;
  // Absent outside containers; "max" where there is no limit.
  if (std::FILE* const file = std::fopen("/sys/fs/cgroup/memory.max", "r")) {
    unsigned long long most = 0;
    if (std::fscanf(file, "%llu", &most) == 1) bytes = std::min<std::uint64_t>(bytes, most);
    std::fclose(file);
  }
  return bytes;
}

void limit_memory(std::uint64_t bytes, std::uint64_t threads) {
  ::rlimit limit{}, stack{};
  if (!PagePool::keeps_blocks || ::getrlimit(RLIMIT_DATA, &limit) != 0)
    return;  // AddressSanitizer maps far more
  // Stacks count as data from when they are reserved.
  if (::getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur < bytes) bytes += threads * stack.rlim_cur;
  limit.rlim_cur = std::min<::rlim_t>(bytes, limit.rlim_max);
  ::setrlimit(RLIMIT_DATA, &limit);
}

bool is_error_stream_a_terminal() { return ::isatty(STDERR_FILENO) == 1; }

void open_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDWR) < 0) return;
}

int silence_standard_streams() {
  const int errors = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere < 0) return errors;
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
  ::close(nowhere);
  return errors;
}

void print_to(int descriptor, const std::string& text) { ::dprintf(descriptor, "%s", text.c_str()); }
}  // namespace tapestry::platform
