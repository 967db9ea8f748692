// Preloaded into a program, makes one of its system calls fail: TAPESTRY_FAULT is `call:n:errno`, the n-th
// call of that name from 1 on, `errno` as a number or, for write, `short`, which then writes one byte only,
// or `stop`: the program stops there as by SIGSTOP, and the call succeeds when it goes on. When it does, it
// makes the file TAPESTRY_FAULT_MARK. Calls that the C library makes within itself are not seen. `create` is
// an open that may create a file; `allocation` is one of 4 KiB or more, since smaller ones
// seldom fail and are countless.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {
struct Fault {
  std::string call;
  long number = 0;
  int error = 0;  ///< 0 for a short write
  bool stops = false;
};

const Fault& fault() {
  static const Fault wanted = [] {
    const char* text = std::getenv("TAPESTRY_FAULT");
    const std::string words = text == nullptr ? "" : text;
    const auto first = words.find(':'), second = words.find(':', first + 1);
    if (second == std::string::npos) return Fault{};
    return Fault{words.substr(0, first), std::atol(words.c_str() + first + 1),
                 std::atoi(words.c_str() + second + 1), words.substr(second + 1) == "stop"};
  }();
  return wanted;
}

/// Whether this call must fail; sets errno.
bool fails(std::string_view call) {
  static std::atomic<long> count{0};
  if (call != fault().call || ++count != fault().number) return false;
  if (const char* mark = std::getenv("TAPESTRY_FAULT_MARK"))
    ::syscall(SYS_close, ::syscall(SYS_openat, AT_FDCWD, mark, O_CREAT | O_WRONLY | O_CLOEXEC, 0600));
  if (fault().stops) return ::raise(SIGSTOP) != 0;
  errno = fault().error;
  return true;
}

constexpr std::size_t small_allocation = 4096;

/// Whether a block of that size is refused.
bool refuses(std::size_t bytes) { return bytes >= small_allocation && fails("allocation"); }

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* block, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);

void* malloc(std::size_t bytes) noexcept { return refuses(bytes) ? nullptr : __libc_malloc(bytes); }
void* calloc(std::size_t count, std::size_t bytes) noexcept {
  return refuses(count * bytes) ? nullptr : __libc_calloc(count, bytes);
}
void* realloc(void* block, std::size_t bytes) noexcept {
  return refuses(bytes) ? nullptr : __libc_realloc(block, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  return refuses(bytes) ? nullptr : __libc_memalign(alignment, bytes);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) noexcept {
  *block = refuses(bytes) ? nullptr : __libc_memalign(alignment, bytes);
  return *block == nullptr ? ENOMEM : 0;
}
int open(const char* path, int flags, ...) {
  static const auto real = next<int(const char*, int, ...)>("open");
  std::va_list arguments;
  va_start(arguments, flags);
  const int mode = (flags & O_CREAT) != 0 ? va_arg(arguments, int) : 0;
  va_end(arguments);
  return fails("open") || ((flags & O_CREAT) != 0 && fails("create")) ? -1 : real(path, flags, mode);
}
ssize_t write(int descriptor, const void* bytes, std::size_t size) {
  static const auto real = next<ssize_t(int, const void*, std::size_t)>("write");
  if (!fails("write")) return real(descriptor, bytes, size);
  return fault().error == 0 ? real(descriptor, bytes, 1) : -1;
}
ssize_t pread(int descriptor, void* bytes, std::size_t size, off_t offset) {
  static const auto real = next<ssize_t(int, void*, std::size_t, off_t)>("pread");
  return fails("pread") ? -1 : real(descriptor, bytes, size, offset);
}
int stat(const char* path, struct stat* status) noexcept {
  static const auto real = next<int(const char*, struct stat*)>("stat");
  return fails("stat") ? -1 : real(path, status);
}
int unlink(const char* path) noexcept {
  static const auto real = next<int(const char*)>("unlink");
  return fails("unlink") ? -1 : real(path);
}
int remove(const char* path) noexcept {
  static const auto real = next<int(const char*)>("remove");
  return fails("unlink") ? -1 : real(path);
}
int fsync(int descriptor) {
  static const auto real = next<int(int)>("fsync");
  return fails("fsync") ? -1 : real(descriptor);
}
int rename(const char* from, const char* to) noexcept {
  static const auto real = next<int(const char*, const char*)>("rename");
  return fails("rename") ? -1 : real(from, to);
}
}
