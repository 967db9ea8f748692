#include <tapestry/io/run_lock.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <utility>

#include "../support/catch.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

namespace io = tapestry::io;
using tapestry::ErrorKind;
using tapestry::test::check_refused;

TEST_CASE("a folder has one owner at a time", "[io][run_lock]") {  // F10
  const tapestry::test::TemporaryFolder folder;
  {
    io::RunLock lock(folder.path());
    const std::string owner = "in use by process " + std::to_string(::getpid()) + " on ";
    check_refused(ErrorKind::in_use, owner, [&] { const io::RunLock second(folder.path()); });
    const io::RunLock moved = std::move(lock);
    check_refused(ErrorKind::in_use, owner, [&] { const io::RunLock second(folder.path()); });
  }
  CHECK_NOTHROW(io::RunLock(folder.path()));
  check_refused(ErrorKind::write, "cannot create", [&] { const io::RunLock lock(folder.path("absent")); });
}

TEST_CASE("the lock of a killed process is free", "[io][run_lock]") {  // F10
  const tapestry::test::TemporaryFolder folder;
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
