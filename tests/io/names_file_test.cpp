#include <tapestry/io/text_lists.hpp>

#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("class names are read", "[io][names]") {
  const test::TemporaryFolder folder;
  const auto names = io::read_class_names(folder.write("n",
                                                       "\xEF\xBB\xBF"
                                                       "car \r\ntraffic light\r\n\r\n\n"),
                                          2);
  CHECK(names == std::vector<std::string>{"car", "traffic light"});
}

TEST_CASE("bad lists of class names are refused", "[io][names][bad_input]") {  // G32
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& content) {
    return io::read_class_names(folder.write("n", content), 3);
  };
  check_refused(ErrorKind::mismatch, "expected 3, found 2", [&] { (void)read("a\nb\n"); });
  check_refused(ErrorKind::mismatch, "expected 3, found 4", [&] { (void)read("a\nb\nc\nd\n"); });
  check_refused(ErrorKind::malformed, "n:2: empty line", [&] { (void)read("a\n\nb\nc\n"); });
  check_refused(ErrorKind::mismatch, "n:3: class name 'a' is repeated; found line 1",
                [&] { (void)read("a\nb\na\n"); });
  check_refused(ErrorKind::malformed, "no class names", [&] { (void)read("\n\n"); });
  check_refused(ErrorKind::limit, "too long", [&] { (void)read(std::string(5000, 'x')); });
}

TEST_CASE("any number of class names is read in a time in proportion", "[io][names][bad_input]") {
  const test::TemporaryFolder folder;
  std::string many;  // comparing each with each would take minutes
  for (int i = 0; i < 500'000; ++i) many += std::to_string(i) + "\n";
  check_refused(ErrorKind::mismatch, "expected 3, found 500000",
                [&] { (void)io::read_class_names(folder.write("n", many), 3); });
}
