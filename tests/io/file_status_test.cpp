#include <tapestry/io/file_source.hpp>

#if defined(__unix__)
#include <unistd.h>
#endif

#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("only what is missing counts as absent", "[io][file_status][posix]") {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("a", "x");
  CHECK(io::is_there(file));
  CHECK(io::is_regular_file(file));
  CHECK_FALSE(io::is_folder(file));
  CHECK(io::is_folder(folder.path()));
  CHECK_FALSE(io::is_regular_file(folder.path()));
  CHECK_FALSE(io::is_there(folder.path("b")));        // ENOENT
  CHECK_FALSE(io::is_regular_file(file + "/below"));  // ENOTDIR
  std::filesystem::create_symlink("nowhere", folder.path("dangling"));
  CHECK_FALSE(io::is_there(folder.path("dangling")));
  std::filesystem::create_symlink("ring", folder.path("ring"));
  for (const std::string& unknown : {folder.path("ring"), folder.path(std::string(300, 'n'))}) {
    check_refused(ErrorKind::malformed, unknown + ": cannot inspect: ", [&] { (void)io::is_there(unknown); });
    check_refused(ErrorKind::malformed, "cannot inspect", [&] { (void)io::is_regular_file(unknown); });
    check_refused(ErrorKind::write, "cannot inspect",
                  [&] { (void)io::is_folder(unknown, ErrorKind::write); });
  }
}

#if defined(__unix__)
TEST_CASE("a file in a folder without permission is not absent", "[io][file_status]") {
  if (::geteuid() == 0) return;  // for whom every folder is open
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("closed"));
  const std::string file = folder.write("closed/a", "x");
  std::filesystem::permissions(folder.path("closed"), std::filesystem::perms::none);
  check_refused(ErrorKind::malformed, "cannot inspect", [&] { (void)io::is_there(file); });
  std::filesystem::permissions(folder.path("closed"), std::filesystem::perms::owner_all);
}
#endif
