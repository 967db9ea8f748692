#include <tapestry/core/atomic_file.hpp>
#include <tapestry/core/file_source.hpp>

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "../support/catch.hpp"

namespace fs = std::filesystem;
using namespace tapestry;

namespace {
struct Folder {
  fs::path path;
  Folder() {
    std::string name = (fs::temp_directory_path() / "tapestry_atomic_XXXXXX").string();
    path = ::mkdtemp(name.data());
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  [[nodiscard]] std::string file(const std::string& name) const { return (path / name).string(); }
  [[nodiscard]] std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path), fs::directory_iterator()));
  }
};

template <class Action>
FileError failure_of(Action action) {
  try {
    action();
  } catch (const FileError& error) {
    return error;
  }
  FAIL("no FileError");
  return FileError(ErrorKind::usage, {});
}
}  // namespace

TEST_CASE("a file written atomically reads back and leaves nothing beside it", "[core][atomic_file]") {
  const Folder folder;
  const auto path = folder.file("a b%\n.txt");
  write_file_atomically(path, std::string_view("first"));
  write_file_atomically(path, std::string_view("second"));
  CHECK(read_text_file(path) == "second");
  CHECK(read_file(path).size() == 6);
  CHECK(folder.entries() == 1);
}

TEST_CASE("a file that cannot be written is a write error and leaves nothing half written",
          "[core][atomic_file]") {
  const Folder folder;
  const auto path = folder.file("absent/file");
  CHECK(failure_of([&] { write_file_atomically(path, std::string_view("x")); }).kind() == ErrorKind::write);
  CHECK(failure_of([&] { write_file_atomically(folder.path.string(), std::string_view("x")); }).kind() ==
        ErrorKind::write);
  CHECK(failure_of([&] {
          write_file_atomically(folder.file(std::string(300, 'n')), std::string_view("x"));
        }).kind() == ErrorKind::write);
  CHECK(folder.entries() == 0);
}

TEST_CASE("only regular files within the limit are read", "[core][file_source]") {
  const Folder folder;
  const auto fifo = folder.file("fifo");
  REQUIRE(::mkfifo(fifo.c_str(), 0600) == 0);
  CHECK_THROWS_WITH((void)read_file(folder.path.string()), Catch::Matchers::Contains("folder"));
  CHECK_THROWS_WITH((void)read_file(fifo), Catch::Matchers::Contains("not a regular file"));
  CHECK_THROWS_WITH((void)read_file("/dev/zero"), Catch::Matchers::Contains("not a regular file"));
  CHECK_THROWS_WITH((void)read_file(folder.file("absent")), Catch::Matchers::Contains("cannot open"));
  const auto sparse = folder.file("sparse");
  std::ofstream(sparse).put('x');
  fs::resize_file(sparse, std::uintmax_t(5) << 30U);
  CHECK(failure_of([&] { (void)read_file(sparse); }).kind() == ErrorKind::limit);
  fs::resize_file(sparse, 1);
  CHECK(read_text_file(sparse, 1) == "x");
}

TEST_CASE("a file whose size changes while it is read is refused", "[core][file_source]") {
  const Folder folder;
  const auto path = folder.file("grows");
  write_file_atomically(path, std::string_view("abc"));
  const RegularFile file(path);
  std::ofstream(path, std::ios::app) << "d";
  CHECK_THROWS_WITH(file.require_unchanged_size(), Catch::Matchers::Contains("changed while it was read"));
  std::array<std::byte, 8> bytes{};
  CHECK_THROWS_WITH(file.read_at(0, bytes), Catch::Matchers::Contains("ends early"));
}
