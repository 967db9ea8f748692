#pragma once

#include <tapestry/core/error.hpp>
#include <tapestry/io/detail/deflated_part.hpp>

namespace tapestry::io {

/// Builds a zip archive in memory. Members are stored or deflated, without ZIP64 and time stamps, so that
/// equal members give equal bytes. Source: PKWARE APPNOTE 6.3.10.
class ZipWriter {
 public:
  /// \param size  bytes to take memory for at once
  explicit ZipWriter(std::size_t size = 0) { body_.reserve(size); }

  /// \throws Error (limit) if the archive would exceed 4 GiB or 65,534 members
  void add(const std::string& name, std::string_view content, bool deflate) {
    const std::string packed = deflate ? deflated(content) : std::string();
    const std::string_view stored = deflate ? std::string_view(packed) : content;
    constexpr std::uint64_t largest = 0xFFFFFFF0;
    if (content.size() > largest || body_.size() + stored.size() + directory_.size() + 1000 > largest ||
        count_ >= 65534 || name.size() > 400)
      throw Error(ErrorKind::limit,
                  {"zip archive: member '", name, "' does not fit into 4 GiB and 65534 members"});
    const auto offset = static_cast<std::uint32_t>(body_.size());
    std::string fields;  // common to local header and central directory
    put16(fields, 20);   // version needed to extract
    put16(fields, 0);
    put16(fields, deflate ? 8 : 0);
    put16(fields, 0);
    put16(fields, 0x21);  // 1 January 1980
    put32(fields, static_cast<std::uint32_t>(
                      crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size())));
    put32(fields, static_cast<std::uint32_t>(stored.size()));
    put32(fields, static_cast<std::uint32_t>(content.size()));
    put16(fields, static_cast<std::uint32_t>(name.size()));
    put16(fields, 0);
    body_ += "PK\x03\x04" + fields + name;
    body_ += stored;
    directory_ += "PK\x01\x02";
    put16(directory_, 20);  // version made by
    directory_ += fields;
    directory_.append(10, '\0');  // comment length, disk, attributes
    put32(directory_, offset);
    directory_ += name;
    ++count_;
  }

  /// Takes the archive with the members added so far out of the writer.
  [[nodiscard]] std::string bytes() {
    const std::size_t size = body_.size();
    std::string archive = std::move(body_);
    archive += directory_ + "PK\x05\x06";
    put32(archive, 0);
    put16(archive, count_);
    put16(archive, count_);
    put32(archive, static_cast<std::uint32_t>(directory_.size()));
    put32(archive, static_cast<std::uint32_t>(size));
    put16(archive, 0);
    return archive;
  }

 private:
  static void put16(std::string& to, std::uint32_t value) {
    to += static_cast<char>(value & 0xFFU);
    to += static_cast<char>(value >> 8U & 0xFFU);
  }
  static void put32(std::string& to, std::uint32_t value) {
    put16(to, value & 0xFFFFU);
    put16(to, value >> 16U);
  }

  static std::string deflated(std::string_view content) {
    std::string packed = detail::deflated_part(content, 0, content.size(), true, 9, 9);
    if (packed.empty()) throw Error(ErrorKind::limit, "zip archive: a member is too large to deflate");
    return packed;
  }

  std::string body_;
  std::string directory_;
  std::uint32_t count_ = 0;
};

}  // namespace tapestry::io
