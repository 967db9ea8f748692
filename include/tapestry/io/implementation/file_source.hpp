#pragma once
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/io/file_source.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {

bool stays_below(const std::string& name) {
  const auto relative = std::filesystem::path(name).lexically_normal();
  return !relative.has_root_path() && (relative.empty() || *relative.begin() != "..");
}

RegularFile::RegularFile(std::string path, std::uint64_t limit) : path_(std::move(path)) {
  if (path_.find('\0') != std::string::npos) fail(ErrorKind::malformed, "file name holds a zero byte");
  do {
    descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) fail(ErrorKind::malformed, std::string("cannot open: ") + std::strerror(errno));
  try {
    size_ = measured_size();
    if (size_ > limit) {
      throw FileError(ErrorKind::limit,
                      {path_, "", "file too large", "at most " + std::to_string(limit) + " bytes",
                       std::to_string(size_) + " bytes"});
    }
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

void RegularFile::read_at(std::uint64_t offset, std::span<std::byte> bytes) const {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ::ssize_t count =
        ::pread(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<::off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(ErrorKind::malformed, std::string("cannot read: ") + std::strerror(errno));
    if (count == 0) {
      throw FileError(ErrorKind::malformed, {path_, "@" + std::to_string(offset + done), "file ends early",
                                             std::to_string(bytes.size() - done) + " more bytes", "none"});
    }
    done += static_cast<std::size_t>(count);
  }
}

void RegularFile::require_unchanged_size() const {
  const std::uint64_t now = measured_size();
  if (now != size_) {
    throw FileError(ErrorKind::malformed, {path_, "", "file changed while it was read",
                                           std::to_string(size_) + " bytes", std::to_string(now) + " bytes"});
  }
}

std::uint64_t RegularFile::measured_size() const {
  struct ::stat status {};
  if (::fstat(descriptor_, &status) != 0) {
    fail(ErrorKind::malformed, std::string("cannot inspect: ") + std::strerror(errno));
  }
  if (!S_ISREG(status.st_mode)) {
    fail(ErrorKind::malformed,
         S_ISDIR(status.st_mode) ? "not a regular file but a folder" : "not a regular file");
  }
  return static_cast<std::uint64_t>(status.st_size);
}

std::vector<std::byte> read_file(const std::string& path, std::uint64_t limit) {
  const RegularFile file(path, limit);
  std::vector<std::byte> bytes(static_cast<std::size_t>(file.size()));
  file.read_at(0, bytes);
  file.require_unchanged_size();
  return bytes;
}

std::string read_text_file(const std::string& path, std::uint64_t limit) {
  const RegularFile file(path, limit);
  std::string text(static_cast<std::size_t>(file.size()), '\0');
  file.read_at(0, std::as_writable_bytes(std::span<char>(text.data(), text.size())));
  file.require_unchanged_size();
  return text;
}

std::string_view recognised_format(std::span<const std::byte> beginning) {
  const std::string_view text(reinterpret_cast<const char*>(beginning.data()), beginning.size());
  const auto starts = [&](std::string_view magic) { return text.substr(0, magic.size()) == magic; };
  using namespace std::string_view_literals;
  // First of all: its length field may be any other format's magic number.
  if (text.size() > 9 && text[8] == '{' && text.substr(3, 5) == "\0\0\0\0\0"sv) return recognised_safetensors;
  if (starts("version https://git-lfs"sv)) return "a Git LFS pointer, not the file it stands for";
  if (starts("\x1f\x8b"sv)) return "a gzip archive";
  if (starts("PK\x03\x04"sv)) return "a zip archive (npz, or a PyTorch checkpoint)";
  if (starts("\x80\x02"sv) || starts("\x80\x03"sv) || starts("\x80\x04"sv)) return "a Python pickle";
  if (starts("\x93NUMPY"sv)) return "a NumPy array";
  if (starts("\x89PNG"sv)) return "a PNG image";
  if (starts("\xff\xd8\xff"sv)) return "a JPEG image";
  if (starts("%PDF"sv)) return "a PDF document";
  if (starts("\x7f"
             "ELF"sv))
    return "a program";
  if (starts("\x08"sv) && text.size() > 3 && text[1] > 0 && text[1] < 16 &&
      (text[2] == 0x12 || text[2] == 0x1a))
    return "an ONNX model";
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '<') return "an HTML or XML page";
  return {};
}

}  // namespace tapestry::io
