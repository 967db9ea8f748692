#pragma once
#include <cerrno>
#include <cstdio>
#include <tapestry/core/platform.hpp>

/// \file
/// The form for a system that is neither POSIX nor Windows, such as a web page: C++'s own files, which cannot
/// be locked.
namespace tapestry::platform {
inline std::FILE* file_of(std::intptr_t handle) { return reinterpret_cast<std::FILE*>(handle); }
inline int failure_of(bool fails) { return fails ? errno : 0; }

int OpenFile::open(const std::string& path, Access access) {
  close();
  std::FILE* file = std::fopen(path.c_str(), access == Access::read     ? "rb"
                                             : access == Access::create ? "wbx"
                                                                        : "r+b");
  if (file == nullptr && access == Access::share) file = std::fopen(path.c_str(), "w+b");
  handle_ = file == nullptr ? none : reinterpret_cast<std::intptr_t>(file);
  return failure_of(file == nullptr);
}

void OpenFile::close() noexcept {
  if (is_open()) std::fclose(file_of(std::exchange(handle_, none)));
}

int OpenFile::lock() const { return 0; }

std::ptrdiff_t OpenFile::read_at(std::uint64_t offset, std::span<std::byte> bytes) const {
  std::FILE* const file = file_of(handle_);
  if (std::fseek(file, static_cast<long>(offset), SEEK_SET) != 0) return -1;
  const std::size_t count = std::fread(bytes.data(), 1, bytes.size(), file);
  return count == 0 && std::ferror(file) != 0 ? -1 : static_cast<std::ptrdiff_t>(count);
}

int OpenFile::write(std::span<const std::byte> bytes) const {
  return failure_of(std::fwrite(bytes.data(), 1, bytes.size(), file_of(handle_)) != bytes.size());
}

int OpenFile::replace(std::span<const std::byte> bytes) const { return write(bytes); }

int OpenFile::flush() const { return failure_of(std::fflush(file_of(handle_)) != 0); }

int OpenFile::inspect(FileState& state) const {
  const bool fails = std::fseek(file_of(handle_), 0, SEEK_END) != 0;
  state.size = fails ? 0 : static_cast<std::uint64_t>(std::ftell(file_of(handle_)));
  state.stamp = std::to_string(state.size);
  return failure_of(fails);
}

bool OpenFile::is_still_at(const std::string&) const { return true; }

int replace_file(const std::string& from, const std::string& to) {
  return failure_of(std::rename(from.c_str(), to.c_str()) != 0);
}

int flush_folder(const std::string&) { return 0; }
int remove_file(const char* path) noexcept { return failure_of(std::remove(path) != 0); }
long process_number() { return 1; }
std::string host_name() { return "?"; }
std::string program_path() { return {}; }
std::vector<std::string> command_line_words(int argc, char** argv) { return {argv, argv + argc}; }
void set_variable(const char*, const std::string&) {}
inline std::string machine_name() { return "unknown"; }
ProcessCost process_cost() { return {}; }
std::uint64_t machine_memory() { return 0; }
void limit_memory(std::uint64_t, std::uint64_t) {}
bool is_error_stream_a_terminal() { return false; }
void open_standard_streams() {}
}  // namespace tapestry::platform
