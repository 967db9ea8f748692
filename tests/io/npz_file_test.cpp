#include <tapestry/io/npy.hpp>

#include "../support/random_array.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
io::NpzWriter small_writer() {
  io::NpzWriter writer;
  writer.add("values", test::random_array<float>({3, 4}, 1));
  writer.add("steps", std::uint64_t{1} << 63U);
  writer.add("list", std::vector<std::uint64_t>{1, 2, 3});
  writer.add("note", "two words");
  return writer;
}

io::NpzFile parse(const std::string& bytes, const io::ZipLimits& limits = {}) {
  return io::NpzFile::parse(bytes, "a.npz", limits);
}

std::string with(std::string bytes, std::size_t at, const std::string& replacement) {
  return bytes.replace(at, replacement.size(), replacement);
}
}  // namespace

TEST_CASE("an npz file comes back", "[io][npz]") {
  const bool compress = GENERATE(false, true);
  const test::TemporaryFolder folder;
  small_writer().write(folder.path("a.npz"), compress);
  const auto file = io::NpzFile::read(folder.path("a.npz"));
  CHECK(file.names() == std::vector<std::string>{"values", "steps", "list", "note"});
  CHECK((file.array<float, 2>("values") == test::random_array<float>({3, 4}, 1)));
  CHECK(file.get("steps").as<std::uint64_t>() == std::vector<std::uint64_t>{std::uint64_t{1} << 63U});
  CHECK(file.get("list").as<std::uint64_t>() == std::vector<std::uint64_t>{1, 2, 3});
  const auto& note = file.get("note").bytes;
  CHECK(std::string(note.begin(), note.end()) == "two words");
  CHECK_FALSE(file.has("other"));
  CHECK(folder.read("a.npz") == small_writer().bytes(compress));
  check_refused(ErrorKind::mismatch, "found values, steps, list, note",
                [&] { (void)file.get("other"); });  // N12
}

TEST_CASE("an archive with data descriptors and a long comment is read", "[io][npz]") {  // N11
  std::string bytes = small_writer().bytes();
  const std::size_t end = bytes.size() - 22;
  CHECK(parse(with(bytes, end + 20, "\xff\xff") + std::string(65535, 'c')).has("note"));
  bytes = with(bytes, 6, "\x08");                 // sizes follow the content …
  bytes = with(bytes, 18, std::string(8, '\0'));  // … and are 0 here
  CHECK(parse(bytes).has("values"));
  CHECK(parse(with(bytes, 18, std::string(8, '\xff'))).has("values"));  // … or stand in a ZIP64 field
}

TEST_CASE("bad npz files are refused", "[io][npz][bad_input]") {
  const std::string good = small_writer().bytes();
  const std::size_t directory = good.find("PK\x01\x02");
  const std::size_t second = good.find("PK\x01\x02", directory + 4);
  const std::size_t end = good.size() - 22;
  io::NpzWriter twice;
  twice.add("a", 1.0);
  twice.add("a", 2.0);
  io::NpzWriter zeros;
  zeros.add("a", std::vector<double>(200000, 0.0));
  const std::string bomb = zeros.bytes(true);
  const std::size_t bomb_directory = bomb.find("PK\x01\x02");
  const auto malformed = ErrorKind::malformed;
  const BadContent rows[] = {
      {"N11 empty", "", malformed, "0 bytes"},
      {"N11 not a zip", "<html>", malformed, "not a zip archive"},
      {"N11 trailing", good + "x", malformed, "appended"},
      {"N11 directory moved", with(good, end + 16, std::string("\0\0\0\0", 4)), malformed, "does not end"},
      {"N11 directory beyond", with(good, end + 16, "\x7f\x7f\x7f\x7f"), malformed, "does not end"},
      {"N11 too few entries", with(good, end + 8, std::string("\3\0\3\0", 4)), malformed, "bytes between"},
      {"N11 too many entries", with(good, end + 8, std::string("\5\0\5\0", 4)), malformed, "damaged"},
      {"N11 disks", with(good, end + 4, "\1"), malformed, "disks"},
      {"N11 ZIP64 end", with(good, end + 8, "\xff\xff\xff\xff"), ErrorKind::limit, "ZIP64"},
      {"N11 ZIP64 records",
       good.substr(0, end) + "PK\x06\x06" + std::string(52, '\0') + "PK\x06\x07" + std::string(16, '\0') +
           good.substr(end),
       ErrorKind::limit, "ZIP64"},
      {"N11 ZIP64 entry", with(good, directory + 20, std::string(8, '\xff')), ErrorKind::limit, "ZIP64"},
      {"N11 entry size", with(good, directory + 20, std::string("\1\0\0\0\1\0\0\0", 8)), malformed,
       "contradicts"},
      {"N11 grows", with(good, directory + 24, "\1"), malformed, "changes its size"},
      {"N11 name length", with(good, second + 28, "\xff\xff"), malformed, "ends within"},
      {"N11 header offset", with(good, second + 42, "\1"), malformed, "no local header"},
      {"N11 header far", with(good, second + 42, "\xfe\xff\xff\x7f"), malformed, "no local header"},
      {"N11 header swapped", with(good, second + 42, std::string("\0\0\0\0", 4)), malformed, "contradicts"},
      {"N11 encrypted", with(good, directory + 8, "\1"), malformed, "encrypted"},
      {"N11 method", with(good, directory + 10, "\x0c"), malformed, "unknown method"},
      {"N11 duplicate", twice.bytes(), malformed, "two members"},
      {"N11 checksum", with(good, 60, "?"), malformed, "checksum"},
      {"N11 deflate damaged", with(bomb, 200, "????"), malformed, "unpack"},
      {"N11 deflate short", with(bomb, bomb_directory + 24, std::string("\0\0\1\0", 4)), malformed,
       "contradicts"},
      {"N11 ratio", with(bomb, bomb_directory + 24, "\xff\xff\xff\x7f"), malformed,
       "more than deflate can pack"},
  };
  for (const BadContent& row : rows) {
    INFO(row.id);
    check_refused(row.kind, row.text, [&] { (void)parse(row.file); });
  }
  check_refused(ErrorKind::limit, "unpacks to too much",
                [&] { (void)parse(bomb, {.unpacked_bytes = 100000}); });
  CHECK(parse(bomb).get("a").size() == 200000);  // a thousand to one, yet true
}

TEST_CASE("members outside the folder are just names", "[io][npz]") {  // N11
  io::NpzWriter writer;
  writer.add("../../x", 1.0);
  CHECK(parse(writer.bytes()).get("../../x").as<double>() == std::vector<double>{1});
}

TEST_CASE("every cut and every flipped bit of an npz file is refused or harmless", "[io][npz][bad_input]") {
  const bool compress = GENERATE(false, true);
  const std::string good = small_writer().bytes(compress);
  for (std::size_t length = 0; length < good.size(); ++length) {
    INFO(length);
    check_refused(ErrorKind::malformed, "a.npz:@", [&] { (void)parse(good.substr(0, length)); });
  }
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string flipped = good;
    flipped[at] = static_cast<char>(static_cast<unsigned char>(flipped[at]) ^ 1U << at % 8);
    try {
      const auto file = parse(flipped);
      for (const auto& name : file.names())
        if (name == "values") CHECK((file.array<float, 2>(name) == test::random_array<float>({3, 4}, 1)));
    } catch (const Error&) {
    }
  }
}

TEST_CASE("files that are no files are refused", "[io][npz][bad_input]") {
  const test::TemporaryFolder folder;
  check_refused(ErrorKind::malformed, "folder", [&] { (void)io::NpzFile::read(folder.path()); });
  check_refused(ErrorKind::malformed, "cannot open",
                [&] { (void)io::NpzFile::read(folder.path("absent.npz")); });
  check_refused(ErrorKind::write, "cannot", [&] { small_writer().write(folder.path("absent/a.npz")); });
}
