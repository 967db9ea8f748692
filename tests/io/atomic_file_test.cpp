#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>

#if defined(__unix__)
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#endif
#include <chrono>

#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

namespace fs = std::filesystem;
using namespace tapestry;
using namespace tapestry::test;
using namespace io;

namespace {
std::ptrdiff_t entry_count(const TemporaryFolder& folder) {
  return std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator());
}
}  // namespace

TEST_CASE("a file written atomically reads back and leaves nothing beside it", "[io][atomic_file][posix]") {
  const TemporaryFolder folder;
  const auto path = folder.path("a b%\n.txt");
  write_file_atomically(path, std::string_view("first"));
  write_file_atomically(path, std::string_view("second"));
  CHECK(read_text_file(path) == "second");
  CHECK(read_file(path).size() == 6);
  CHECK(entry_count(folder) == 1);
}

TEST_CASE("a file that cannot be written is a write error and leaves nothing half written",
          "[io][atomic_file]") {
  const TemporaryFolder folder;
  for (const auto& path : {folder.path("absent/file"), folder.path(), folder.path(std::string(300, 'n'))})
    check_refused(ErrorKind::write, path + ": ", [&] { write_file_atomically(path, std::string_view("x")); });
  CHECK(entry_count(folder) == 0);
}

TEST_CASE("a file name of the longest length can be written", "[io][atomic_file]") {
  const TemporaryFolder folder;
  const auto path = folder.path(std::string(255, 'n'));
  write_file_atomically(path, std::string_view("x"));
  CHECK(read_text_file(path) == "x");
  CHECK(entry_count(folder) == 1);
}

TEST_CASE("names of all letters are written and locked, in paths of more than 260", "[io][atomic_file]") {
  const TemporaryFolder folder;
  const std::u8string letters = u8"Zürich 車 🚗";
  const std::string name(letters.begin(), letters.end());
  fs::path place = folder.path();
  std::string deep = folder.path();
  for (int level = 0; level < 20; ++level) place /= letters, deep += "/" + name;
  fs::create_directories(place);
  fs::create_directory(folder.path("a"));
  for (const std::string& path :
       {deep + "/" + name, folder.path("a\\b.txt")}) {  // on Windows, in the folder a
    const RunLock lock = RunLock::of_file(path);
    check_refused(ErrorKind::in_use, path, [&] { (void)RunLock::of_file(path); });
    write_file_atomically(path, std::string_view("one\ntwo\r\n"));
    CHECK(read_text_file(path) == "one\ntwo\r\n");
    CHECK(is_regular_file(path));
  }
  CHECK(fs::file_size(place / letters) == 9);
  const auto listed = [](const std::string& folder_path) {
    return listed_paths(folder_path, [](const fs::path&) { return true; });
  };
  CHECK(listed(folder.path() + "/" + name).size() == 1);
  if (can_be_listed(deep))
    CHECK(read_text_file(listed(deep).at(0)).size() == 9);
  else
    check_refused(ErrorKind::limit, "too long to list", [&] { (void)listed(deep); });
}

#if defined(__unix__)
TEST_CASE("temporaries of killed processes are removed, those of living ones and other files stay",
          "[io][atomic_file]") {
  const TemporaryFolder folder;
  const auto killed = [&](const char* name) {
    const ::pid_t child = ::fork();
    if (child == 0) {
      io::detail::TemporaryFile* const temporary = new io::detail::TemporaryFile(folder.path(name));
      static_cast<void>(temporary);
      ::raise(SIGKILL);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    CHECK(WIFSIGNALED(status));
  };
  killed("checkpoint.npz");
  killed(std::string(250, 'n').c_str());
  CHECK(entry_count(folder) == 2);
  folder.write("notes.tapestry-part", "x");
  folder.write("notes.tapestry-part2-b", "x");
  folder.write("notes.tapestry-part2", "x");
  folder.write("film.part2-1", "x");
  {
    const io::detail::TemporaryFile living(folder.path("living"));
    remove_abandoned_parts(folder.path());
    CHECK(entry_count(folder) == 5);
  }
  CHECK(entry_count(folder) == 4);
  remove_abandoned_parts(folder.path("absent"));  // no error
}

TEST_CASE("only regular files within the limit are read", "[io][file_source]") {
  const TemporaryFolder folder;
  const auto fifo = folder.path("fifo");
  REQUIRE(::mkfifo(fifo.c_str(), 0600) == 0);
  CHECK_THROWS_WITH((void)read_file(folder.path()), contains("folder"));
  CHECK_THROWS_WITH((void)read_file(fifo), contains("not a regular file"));
  CHECK_THROWS_WITH((void)read_file("/dev/zero"), contains("not a regular file"));
  CHECK_THROWS_WITH((void)read_file(folder.path("absent")), contains("cannot open"));
  const auto sparse = folder.write("sparse", "x");
  fs::resize_file(sparse, std::uintmax_t(5) << 30U);
  check_refused(ErrorKind::limit, sparse + ": ", [&] { (void)read_file(sparse); });
  fs::resize_file(sparse, 1);
  CHECK(read_text_file(sparse, 1) == "x");
}
#endif

TEST_CASE("a path that leads nowhere is told the nearest one", "[io][file_source]") {
  const TemporaryFolder folder;
  const auto car = folder.write("sedan.obj", "x");
  CHECK_THROWS_WITH((void)read_file(folder.path("sedna.obj")),
                    contains("cannot open") && contains("; did you mean " + car + "?"));
  CHECK_THROWS_WITH((void)listed_paths(car, [](const fs::path&) { return true; }),
                    contains("give the folder that it lies in"));
  CHECK(path_remedy(folder.path("truck.obj")).empty());
  fs::create_directory(folder.path("frames"));
  CHECK(path_remedy(folder.path("frame/train/000.npz")) == "; did you mean " + folder.path("frames") + "?");
  CHECK(path_remedy("").empty());
}

TEST_CASE("a file whose size changes while it is read is refused", "[io][file_source]") {
  const TemporaryFolder folder;
  const auto path = folder.path("grows");
  write_file_atomically(path, std::string_view("abc"));
  const RegularFile file(path);
  std::ofstream(path, std::ios::app) << "d";
  CHECK_THROWS_WITH(file.require_unchanged(), contains("changed while it was read"));
  std::array<std::byte, 8> bytes{};
  CHECK_THROWS_WITH(file.read_at(0, bytes), contains("ends early"));
}

TEST_CASE("a file that is written to while it is read is refused, its size kept", "[io][file_source]") {
  const TemporaryFolder folder;
  const auto path = folder.write("same", "abc");
  fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(1));
  const RegularFile file(path);
  std::ofstream(path, std::ios::in) << "b";
  CHECK_THROWS_WITH(file.require_unchanged(), contains("changed while it was read"));
}
