#pragma once
#include <sys/mman.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/file_source.hpp>

namespace tapestry {

/// A regular file's bytes as memory, read when they are first touched and never copied.
///
/// The bytes vanish with this object, which outlives the file's name: a file that is renamed or deleted stays
/// readable. One that another process cuts in place does not, and touching what was cut off kills this
/// process; so the users of a mapping call require_unchanged_size() of its file before and after they read.
class FileMapping {
 public:
  /// \throws FileError (limit) if the system refuses
  explicit FileMapping(const RegularFile& file) : size_(static_cast<std::size_t>(file.size())) {
    if (size_ == 0) return;  // which no system maps
    void* const address = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file.descriptor(), 0);
    if (address == MAP_FAILED) {
      throw FileError(ErrorKind::limit,
                      {file.path(), "", std::string("cannot map into memory: ") + std::strerror(errno)});
    }
    address_ = address;
  }
  FileMapping(const FileMapping&) = delete;
  FileMapping& operator=(const FileMapping&) = delete;
  ~FileMapping() {
    if (address_ != nullptr) ::munmap(address_, size_);
  }

  [[nodiscard]] std::span<const std::byte> bytes() const {
    return {static_cast<const std::byte*>(address_), size_};
  }

 private:
  void* address_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace tapestry
