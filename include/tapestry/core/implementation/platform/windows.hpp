#pragma once
#define WIN32_LEAN_AND_MEAN
#if !defined(NOMINMAX)
#define NOMINMAX
#endif
#include <windows.h>
#undef near
#undef far
#include <fcntl.h>
#include <io.h>
#include <psapi.h>
#include <shellapi.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <tapestry/core/platform.hpp>

namespace tapestry::platform {
inline int last_failure() {
  const auto condition = std::system_category().default_error_condition(static_cast<int>(::GetLastError()));
  return condition.category() == std::generic_category() ? condition.value() : EIO;
}
inline int failure_unless(BOOL succeeds) { return succeeds != 0 ? 0 : last_failure(); }
inline HANDLE handle_of(std::intptr_t number) { return reinterpret_cast<HANDLE>(number); }

/// UTF-16 of a path in UTF-8; a long one in the form that may have more than 260 characters.
inline std::wstring wide(const std::string& text) {
  const int size = static_cast<int>(text.size());
  std::wstring result(text.size(), L'\0');
  const int count = ::MultiByteToWideChar(CP_UTF8, 0, text.data(), size, result.data(), size);
  result.resize(static_cast<std::size_t>(count));
  if (result.size() < 240 || result.starts_with(L"\\\\")) return result;
  std::wstring whole(32768, L'\0');
  whole.resize(::GetFullPathNameW(result.c_str(), 32768, whole.data(), nullptr));
  return L"\\\\?\\" + whole;
}

/// UTF-8 of UTF-16, which ends with 0.
inline std::string narrow(const wchar_t* text) {
  std::string result(3 * std::wcslen(text) + 1, '\0');
  const int size = static_cast<int>(result.size());
  const int count = ::WideCharToMultiByte(CP_UTF8, 0, text, -1, result.data(), size, nullptr, nullptr);
  result.resize(static_cast<std::size_t>(count - 1));
  return result;
}

inline OVERLAPPED place_of(std::uint64_t offset) {
  OVERLAPPED place{};
  place.Offset = static_cast<DWORD>(offset);
  place.OffsetHigh = static_cast<DWORD>(offset >> 32U);
  return place;
}

int OpenFile::open(const std::string& path, Access access) {
  close();
  constexpr DWORD makings[] = {OPEN_EXISTING, CREATE_NEW, OPEN_ALWAYS};
  const DWORD rights = access == Access::read ? GENERIC_READ : GENERIC_READ | GENERIC_WRITE;
  // A file may be deleted and renamed while it is open, as elsewhere; a folder is opened to be recognised.
  handle_ = reinterpret_cast<std::intptr_t>(
      ::CreateFileW(wide(path).c_str(), rights, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
                    nullptr, makings[static_cast<int>(access)], FILE_FLAG_BACKUP_SEMANTICS, nullptr));
  return failure_unless(is_open());
}

void OpenFile::close() noexcept {
  if (is_open()) ::CloseHandle(handle_of(std::exchange(handle_, none)));
}

int OpenFile::lock() const {
  OVERLAPPED place = place_of(std::uint64_t(1) << 62U);  // behind the content, which others may read
  if (::LockFileEx(handle_of(handle_), LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1, 0, &place))
    return 0;
  return ::GetLastError() == ERROR_LOCK_VIOLATION ? EWOULDBLOCK : last_failure();
}

std::ptrdiff_t OpenFile::read_at(std::uint64_t offset, std::span<std::byte> bytes) const {
  OVERLAPPED place = place_of(offset);
  DWORD count = 0;
  const auto most = static_cast<DWORD>(std::min<std::size_t>(bytes.size(), 1U << 30U));
  if (::ReadFile(handle_of(handle_), bytes.data(), most, &count, &place) ||
      ::GetLastError() == ERROR_HANDLE_EOF)
    return static_cast<std::ptrdiff_t>(count);
  errno = last_failure();
  return -1;
}

int OpenFile::write(std::span<const std::byte> bytes) const {
  while (!bytes.empty()) {
    DWORD count = 0;
    const auto most = static_cast<DWORD>(std::min<std::size_t>(bytes.size(), 1U << 30U));
    if (!::WriteFile(handle_of(handle_), bytes.data(), most, &count, nullptr)) return last_failure();
    bytes = bytes.subspan(count);
  }
  return 0;
}

int OpenFile::replace(std::span<const std::byte> bytes) const {
  return ::SetEndOfFile(handle_of(handle_)) ? write(bytes) : last_failure();
}

int OpenFile::flush() const { return failure_unless(::FlushFileBuffers(handle_of(handle_))); }

int OpenFile::inspect(FileState& state) const {
  BY_HANDLE_FILE_INFORMATION file{};
  if (!::GetFileInformationByHandle(handle_of(handle_), &file)) return last_failure();
  state.kind = (file.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0 ? FileKind::folder : FileKind::regular;
  if (::GetFileType(handle_of(handle_)) != FILE_TYPE_DISK) state.kind = FileKind::other;
  state.size = std::uint64_t(file.nFileSizeHigh) << 32U | file.nFileSizeLow;
  state.name_count = file.nNumberOfLinks;
  state.stamp.clear();
  for (const auto part :
       {file.dwVolumeSerialNumber, file.nFileIndexHigh, file.nFileIndexLow, file.nFileSizeHigh,
        file.nFileSizeLow, file.ftLastWriteTime.dwHighDateTime, file.ftLastWriteTime.dwLowDateTime})
    state.stamp += std::to_string(part) + ' ';
  return 0;
}

bool OpenFile::is_still_at(const std::string& path) const {
  OpenFile other;
  FileState here, there;
  return other.open(path, Access::read) == 0 && inspect(here) == 0 && other.inspect(there) == 0 &&
         here.kind == FileKind::regular && here.stamp == there.stamp;
}

int replace_file(const std::string& from, const std::string& to) {
  return failure_unless(::MoveFileExW(wide(from).c_str(), wide(to).c_str(),
                                      MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH));
}

int flush_folder(const std::string&) { return 0; }

int remove_file(const char* path) noexcept {  // renamed first: it keeps its name while anyone has it open
  std::wstring name = wide(path);
  const std::wstring gone = name + L".deleted-" + std::to_wstring(::GetTickCount64());
  if (::MoveFileExW(name.c_str(), gone.c_str(), 0)) name = gone;
  return failure_unless(::DeleteFileW(name.c_str()));
}

long process_number() { return static_cast<long>(::GetCurrentProcessId()); }

std::string host_name() {
  std::array<char, MAX_COMPUTERNAME_LENGTH + 1> name{};
  DWORD size = name.size();
  return ::GetComputerNameA(name.data(), &size) ? name.data() : "?";
}

std::string program_path() {
  std::wstring path(32768, L'\0');
  ::GetModuleFileNameW(nullptr, path.data(), 32767);
  return narrow(path.c_str());
}

std::vector<std::string> command_line_words(int, char**) {
  int count = 0;
  wchar_t** const words = ::CommandLineToArgvW(::GetCommandLineW(), &count);
  std::vector<std::string> result;
  for (int i = 0; i < count; ++i) result.push_back(narrow(words[i]));
  ::LocalFree(words);
  return result;
}

void set_variable(const char* name, const std::string& value) { ::_putenv_s(name, value.c_str()); }

inline std::string machine_name() { return "unknown"; }

ProcessCost process_cost() {
  PROCESS_MEMORY_COUNTERS memory{};
  ::GetProcessMemoryInfo(::GetCurrentProcess(), &memory, sizeof memory);
  return {static_cast<double>(memory.PeakWorkingSetSize) / (1 << 20), 0,
          static_cast<long>(memory.PageFaultCount)};
}

std::uint64_t machine_memory() {
  MEMORYSTATUSEX status{};
  status.dwLength = sizeof status;
  return ::GlobalMemoryStatusEx(&status) != 0 ? status.ullTotalPhys : 0;
}

void limit_memory(std::uint64_t, std::uint64_t) {}

bool is_error_stream_a_terminal() {  // that rewrites its lines
  const HANDLE errors = ::GetStdHandle(STD_ERROR_HANDLE);
  DWORD mode = 0;
  return ::GetConsoleMode(errors, &mode) && ::SetConsoleMode(errors, mode | 4U /* escape sequences */);
}

void open_standard_streams() {
  ::_setmode(1, _O_BINARY);
  ::_setmode(2, _O_BINARY);
  ::SetConsoleOutputCP(CP_UTF8);
}
}  // namespace tapestry::platform
