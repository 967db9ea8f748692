#include <tapestry/io/atomic_file.hpp>

#if defined(__unix__)
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#endif

#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("a folder has one owner at a time", "[io][run_lock]") {  // F10
  const test::TemporaryFolder folder;
  {
    io::RunLock lock(folder.path());
    const std::string owner = "in use by process " + std::to_string(platform::process_number()) + " on ";
    check_refused(ErrorKind::in_use, owner, [&] { const io::RunLock second(folder.path()); });
    const io::RunLock moved = std::move(lock);
    check_refused(ErrorKind::in_use, owner, [&] { const io::RunLock second(folder.path()); });
  }
  CHECK_NOTHROW(io::RunLock(folder.path()));
  check_refused(ErrorKind::write, "cannot create", [&] { const io::RunLock lock(folder.path("absent")); });
}

TEST_CASE("a lock takes its file away, and a claim of a file leaves its folder to others", "[io][run_lock]") {
  const test::TemporaryFolder folder;
  const auto holds_nothing = [&] { return std::filesystem::is_empty(folder.path()); };
  {
    const io::RunLock lock(folder.path());
    CHECK_FALSE(holds_nothing());
  }
  CHECK(holds_nothing());
  const std::string output = folder.path(std::string(255, 'a'));  // as long as a name can be
  {
    io::RunLock lock = io::RunLock::of_file(output);
    check_refused(ErrorKind::in_use, output + ": file is in use by process ",
                  [&] { const io::RunLock second = io::RunLock::of_file(output); });
    CHECK_NOTHROW(io::RunLock::of_file(folder.path("b")));
    CHECK_NOTHROW(io::RunLock(folder.path()));
    lock.release();
    CHECK_NOTHROW(io::RunLock::of_file(output));
  }
  CHECK(holds_nothing());
  folder.write(".lock", "process 1 on elsewhere\n");  // of a killed process
  CHECK_NOTHROW(io::RunLock(folder.path()));
  CHECK(holds_nothing());
}

#if defined(__unix__)
TEST_CASE("of two processes that come and go one at a time has the lock", "[io][run_lock]") {
  const test::TemporaryFolder folder;
  const auto work = [&] {  // false if another one was within
    for (int done = 0; done < 300;) try {
        const io::RunLock lock(folder.path());
        if (::mkdir(folder.path("within").c_str(), 0700) != 0) return false;
        ::rmdir(folder.path("within").c_str());
        ++done;
      } catch (const FileError& error) {
        if (error.kind() != ErrorKind::in_use) return false;
      }
    return true;
  };
  const ::pid_t child = ::fork();
  if (child == 0) ::_exit(work() ? 0 : 1);
  CHECK(work());
  int status = -1;
  ::waitpid(child, &status, 0);
  CHECK(status == 0);
}

TEST_CASE("the lock of a killed process is free", "[io][run_lock]") {  // F10
  const test::TemporaryFolder folder;
  int ready[2] = {-1, -1};
  REQUIRE(::pipe(ready) == 0);
  const ::pid_t child = ::fork();
  if (child == 0) {
    const io::RunLock lock(folder.path());
    if (::write(ready[1], "x", 1) == 1) ::pause();
    ::_exit(1);
  }
  char byte = 0;
  REQUIRE(::read(ready[0], &byte, 1) == 1);
  check_refused(ErrorKind::in_use, "process " + std::to_string(child),
                [&] { const io::RunLock lock(folder.path()); });
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  CHECK_NOTHROW(io::RunLock(folder.path()));
  ::close(ready[0]);
  ::close(ready[1]);
}
#endif
