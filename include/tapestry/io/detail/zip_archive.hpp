#pragma once
#include <set>
#include <tapestry/core/error.hpp>
#include <tapestry/io/detail/deflated_part.hpp>
#include <vector>

namespace tapestry::io {
/// Limits on the content of a zip archive, checked before anything is allocated.
struct ZipLimits {
  std::uint64_t file_bytes = std::uint64_t(4) << 30U;
  std::uint64_t unpacked_bytes = std::uint64_t(1) << 30U;  ///< of all members together
};

/// The members of a zip archive held in memory: stored or deflated, neither encrypted nor ZIP64, one disk.
///
/// The central directory is the only list of members, and every field of it is checked against the archive
/// before use. Member names are only for looking up; no file is written under them.
/// Source: PKWARE APPNOTE 6.3.10, sections 4.3.7, 4.3.12, 4.3.15, 4.3.16.
///
/// Implemented here instead of with libzip, because most of this code checks counts, sizes and offsets before
/// any of libzip's functions could run, and limits that libzip has no option for. Both inflate with zlib.
class ZipArchive {
 public:
  /// A file in the archive, as its directory lists it.
  struct Member {
    std::string name;
    std::uint32_t method = 0;  ///< 0 stored, 8 deflated
    std::uint32_t crc = 0;
    std::uint64_t packed = 0;
    std::uint64_t unpacked = 0;
    std::uint64_t header = 0;  ///< offset of its local header
  };

  /// \param bytes  the archive; must outlive this object
  /// \param path   for messages
  /// \throws FileError: malformed (any damage), limit (unpacked size, ZIP64)
  ZipArchive(std::string_view bytes, std::string path, const ZipLimits& limits = {})
      : bytes_(bytes), path_(std::move(path)) {
    if (!bytes_.starts_with("PK\x03\x04") && !bytes_.starts_with("PK\x05\x06"))
      fail(0, "not a zip archive", "the magic PK", bytes_.empty() ? "0 bytes" : "other bytes");
    read_directory(end_record(), limits);
  }

  [[nodiscard]] const std::vector<Member>& members() const { return members_; }

  /// The content of a member, after its checksum was verified.
  [[nodiscard]] std::string unpack(const Member& member) const {
    const std::size_t start = payload(member);
    const std::string_view packed = bytes_.substr(start, member.packed);
    std::string content =
        member.method == 0 ? std::string(packed) : inflated(packed, member.unpacked, start, member.name);
    const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
    if (crc != member.crc) fail(start, "checksum of member '" + member.name + "' is wrong", "", "");
    return content;
  }

 private:
  static constexpr std::size_t end_size = 22;
  static constexpr std::size_t entry_size = 46;
  static constexpr std::size_t local_size = 30;

  [[noreturn]] void fail(std::size_t at, const std::string& what, const std::string& expected,
                         const std::string& found, ErrorKind kind = ErrorKind::malformed) const {
    throw FileError(kind, {path_, "@" + std::to_string(at), what, expected, found});
  }

  [[nodiscard]] std::uint32_t u16(std::size_t at) const {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes_[at])) |
           static_cast<std::uint32_t>(static_cast<unsigned char>(bytes_[at + 1])) << 8U;
  }
  [[nodiscard]] std::uint32_t u32(std::size_t at) const { return u16(at) | u16(at + 2) << 16U; }

  /// Offset of the end-of-central-directory record: the last one whose comment ends with the archive.
  [[nodiscard]] std::size_t end_record() const {
    const std::size_t last = bytes_.size() < end_size ? 0 : bytes_.size() - end_size;
    const std::size_t first = last > 65535 ? last - 65535 : 0;
    for (std::size_t at = last + 1; bytes_.size() >= end_size && at-- > first;) {
      if (bytes_.substr(at, 4) == "PK\x05\x06" && at + end_size + u16(at + 20) == bytes_.size()) return at;
    }
    fail(bytes_.size(), "zip archive has no central directory: it is cut or has bytes appended", "", "");
  }

  void read_directory(std::size_t end, const ZipLimits& limits) {
    if (u16(end + 4) != 0 || u16(end + 6) != 0 || u16(end + 8) != u16(end + 10))
      fail(end + 4, "zip archive spans several disks", "", "");
    const std::size_t count = u16(end + 10);
    const std::uint64_t size = u32(end + 12);
    std::uint64_t at = u32(end + 16);
    const bool has_locator = end >= 20 && bytes_.substr(end - 20, 4) == "PK\x06\x07";
    if (count == 0xFFFF || size == 0xFFFFFFFF || at == 0xFFFFFFFF || has_locator)
      fail(end, "ZIP64 archives are not read", "", "", ErrorKind::limit);
    if (at > end || size != end - at)
      fail(end + 12, "central directory does not end where its record begins", "",
           std::to_string(size) + " bytes");
    std::uint64_t unpacked = 0;
    for (std::size_t i = 0; i < count; ++i) {
      at = read_entry(static_cast<std::size_t>(at), end);
      unpacked += members_.back().unpacked;
      if (unpacked > limits.unpacked_bytes)
        fail(static_cast<std::size_t>(at), "zip archive unpacks to too much",
             "at most " + std::to_string(limits.unpacked_bytes) + " bytes",
             std::to_string(unpacked) + " or more", ErrorKind::limit);
    }
    if (at != end)
      fail(static_cast<std::size_t>(at), "bytes between central directory and its record", "", "");
  }

  /// Reads one entry of the central directory and returns the offset of the next.
  std::size_t read_entry(std::size_t at, std::size_t end) {
    if (end - at < entry_size || bytes_.substr(at, 4) != "PK\x01\x02")
      fail(at, "central directory is damaged", "an entry", "other bytes");
    const std::size_t name_size = u16(at + 28);
    const std::size_t next = at + entry_size + name_size + u16(at + 30) + u16(at + 32);
    if (next > end) fail(at, "central directory is damaged", "an entry that ends within it", "");
    Member member{std::string(bytes_.substr(at + entry_size, name_size)),
                  u16(at + 10),
                  u32(at + 16),
                  u32(at + 20),
                  u32(at + 24),
                  u32(at + 42)};
    if ((u16(at + 8) & 1U) != 0) fail(at, "member '" + member.name + "' is encrypted", "", "");
    if (member.packed == 0xFFFFFFFF || member.unpacked == 0xFFFFFFFF || member.header == 0xFFFFFFFF)
      fail(at, "ZIP64 archives are not read", "", "", ErrorKind::limit);
    if (member.method != 0 && member.method != 8)
      fail(at + 10, "member '" + member.name + "' is packed by an unknown method",
           "0 (stored) or 8 (deflate)", std::to_string(member.method));
    if (!names_.insert(member.name).second) fail(at, "two members are named '" + member.name + "'", "", "");
    require_plausible(member, at);
    members_.push_back(std::move(member));
    return next;
  }

  void require_plausible(const Member& member, std::size_t at) const {
    if (member.method == 0 && member.packed != member.unpacked)
      fail(at, "stored member '" + member.name + "' changes its size", std::to_string(member.packed),
           std::to_string(member.unpacked));
    constexpr std::uint64_t best_ratio = 1032;  // largest ratio of the deflate format
    if (member.unpacked > best_ratio * member.packed + best_ratio)
      fail(at, "member '" + member.name + "' claims more than deflate can pack",
           "at most " + std::to_string(best_ratio) + " times " + std::to_string(member.packed) + " bytes",
           std::to_string(member.unpacked));
    static_cast<void>(payload(member));
  }

  /// Offset of a member's content; checks its local header against the central directory.
  [[nodiscard]] std::size_t payload(const Member& member) const {
    const auto at = static_cast<std::size_t>(member.header);
    if (bytes_.size() < local_size || at > bytes_.size() - local_size || bytes_.substr(at, 4) != "PK\x03\x04")
      fail(at, "no local header of member '" + member.name + "'", "", "");
    const std::size_t start = at + local_size + u16(at + 26) + u16(at + 28);
    if (start > bytes_.size() || member.packed > bytes_.size() - start)
      fail(at, "member '" + member.name + "' reaches beyond the archive", "", "");
    if (bytes_.substr(at + local_size, u16(at + 26)) != member.name || u16(at + 8) != member.method)
      fail(at, "local header of member '" + member.name + "' contradicts the central directory", "", "");
    const bool sizes_follow = (u16(at + 6) & 8U) != 0;  // then a data descriptor comes after the content
    const auto agrees = [&](std::uint32_t local, std::uint64_t central) {
      return local == central || local == 0xFFFFFFFF ||
             (sizes_follow && local == 0);  // 2^32−1: in a ZIP64 field
    };
    if (!agrees(u32(at + 18), member.packed) || !agrees(u32(at + 22), member.unpacked))
      fail(at + 18, "local header of member '" + member.name + "' contradicts the central directory",
           std::to_string(member.packed) + " and " + std::to_string(member.unpacked) + " bytes",
           std::to_string(u32(at + 18)) + " and " + std::to_string(u32(at + 22)));
    return start;
  }

  [[nodiscard]] std::string inflated(std::string_view packed, std::uint64_t size, std::size_t at,
                                     const std::string& name) const {
    std::string content(static_cast<std::size_t>(size) + 1, '\0');  // one byte more detects longer streams
    z_stream stream{};
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(content.data());
    stream.avail_out = static_cast<uInt>(content.size());
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw std::bad_alloc();
    const int status = inflate(&stream, Z_FINISH);
    const std::uint64_t made = stream.total_out;
    const bool all_read = stream.avail_in == 0;
    inflateEnd(&stream);
    if (status == Z_MEM_ERROR) throw std::bad_alloc();
    if (status != Z_STREAM_END || made != size || !all_read)
      fail(at, "member '" + name + "' does not unpack to its size", std::to_string(size) + " bytes",
           status == Z_STREAM_END ? std::to_string(made) : "a damaged deflate stream");
    content.pop_back();
    return content;
  }

  std::string_view bytes_;
  std::string path_;
  std::vector<Member> members_;
  std::set<std::string> names_;
};

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
