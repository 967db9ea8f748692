#include <tapestry/io/input_ledger.hpp>

#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/obj_file.hpp>

#include "../support/bad_file.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"
#include "../support/threads.hpp"

namespace fs = std::filesystem;
using namespace tapestry;
using namespace tapestry::test;

namespace {
std::vector<std::string> paths_of(const io::InputLedger& ledger) {
  std::vector<std::string> paths;
  for (const auto& record : ledger.records()) paths.push_back(record.path);
  return paths;
}
}  // namespace

TEST_CASE("a ledger holds what was read, with the SHA-256 that others compute", "[io][input_ledger]") {
  const TemporaryFolder folder;
  const auto path = folder.write("abc", "abc");
  const io::InputLedger ledger;
  CHECK(io::read_text_file(path) == "abc");
  CHECK(io::read_text_file(path) == "abc");
  REQUIRE(ledger.records().size() == 1);
  // FIPS 180-2, example B.1
  CHECK(ledger.records().front() ==
        io::FileRecord{path, 3, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad", {}});
}

TEST_CASE("a ledger holds files that other files name", "[io][input_ledger]") {
  const TemporaryFolder folder;
  const auto mtl = folder.write("a.mtl", "newmtl body\nKd 1 0 0\n");
  const auto obj = folder.write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl body\nf 1 2 3\n");
  const io::InputLedger ledger;
  (void)io::read_obj(obj);
  CHECK(paths_of(ledger) == std::vector<std::string>{mtl, obj});
}

TEST_CASE("a file is recorded with all that it was read as", "[io][input_ledger]") {
  const TemporaryFolder folder;
  const auto names = folder.write("names", "car\n"), plain = folder.write("plain", "x");
  const io::InputLedger ledger;
  const auto read_as = [&](const std::string& role) {
    const io::InputLedger::Role as(role);
    (void)io::read_text_file(names);
    {
      const io::InputLedger::Role inner("a part of it");
      (void)io::read_text_file(names);
    }
    (void)io::read_text_file(names);
  };
  for (const char* role : {"second", "first", "second"}) read_as(role);
  (void)io::read_text_file(plain);
  const auto records = ledger.records();
  REQUIRE(records.size() == 2);
  CHECK(records[0].roles == std::vector<std::string>{"a part of it", "first", "second"});
  CHECK(records[1].roles.empty());
}

TEST_CASE("a path that is opened again must hold the same bytes", "[io][input_ledger]") {
  const TemporaryFolder folder;
  const auto path = folder.write("weights", "one");
  const io::InputLedger ledger;
  io::InputLedger::note(path);
  const std::string digest = ledger.digest();
  fs::remove(path);
  folder.write("weights", "one");
  CHECK(io::read_text_file(path) == "one");  // another file with the same bytes
  CHECK(ledger.digest() == digest);
  fs::remove(path);
  folder.write("weights", "two");
  test::check_refused(ErrorKind::mismatch, path + ": the file has changed since it was first read",
                      [&] { (void)io::read_text_file(path); });
  CHECK(ledger.digest() == digest);
}

TEST_CASE("a program's own results are no inputs, nor is what nobody records", "[io][input_ledger]") {
  const TemporaryFolder folder;
  fs::create_directory(folder.path("run"));
  fs::create_directory(folder.path("run/frames"));
  const auto own = folder.write("run/checkpoint", "x"), below = folder.write("run/frames/a", "y");
  (void)io::read_text_file(own);
  {
    io::InputLedger ledger;
    ledger.leave_out(folder.path("run"));
    (void)io::read_text_file(own);
    (void)io::read_text_file(below);
    CHECK(paths_of(ledger) == std::vector<std::string>{below});
    CHECK_THROWS_AS(io::InputLedger(), DomainError);
  }
  const io::InputLedger next;
  CHECK(next.records().empty());
}

TEST_CASE("threads that open files at once leave the same ledger as one", "[io][input_ledger]") {
  const TemporaryFolder folder;
  std::vector<std::string> paths;
  for (int i = 0; i < 20; ++i)
    paths.push_back(folder.write(std::to_string(i), std::string(1000, char('a' + i))));
  const auto digest_on = [&](int threads) {
    const test::Threads cap(threads);
    const io::InputLedger ledger;
    tapestry::parallel_for(200, [&](std::size_t i) { (void)io::read_text_file(paths[i % paths.size()]); });
    CHECK(ledger.records().size() == paths.size());
    return ledger.digest();
  };
  CHECK(digest_on(4) == digest_on(1));
}
