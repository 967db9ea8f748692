#include <sys/resource.h>
#include <unistd.h>
#include <tapestry/autodiff.hpp>

#include <fstream>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"

using tapestry::Variable, tapestry::test::ActiveTape;

namespace {
/// While it lives, the process can take `more` bytes of address space beyond what it has.
class ShortMemory {
 public:
  explicit ShortMemory(rlim_t more) {
    rlim_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    getrlimit(RLIMIT_AS, &before_);
    const rlimit now{pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + more, before_.rlim_max};
    setrlimit(RLIMIT_AS, &now);
  }
  ShortMemory(const ShortMemory&) = delete;
  ShortMemory& operator=(const ShortMemory&) = delete;
  ~ShortMemory() { setrlimit(RLIMIT_AS, &before_); }

 private:
  rlimit before_{};
};
}  // namespace

TEST_CASE("a tape without memory for more says how much it holds, and still answers", "[autodiff][memory]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(1);
  Variable<double> y = x;
  std::string message;
  {
    const ShortMemory memory(64 << 20U);
    try {
      for (int i = 0; i < 100'000'000; ++i) y = y * x;
    } catch (const tapestry::Error& error) {
      message = error.what();
      CHECK(error.kind() == tapestry::ErrorKind::limit);
    }
  }
  const std::size_t count = tape.statement_count();
  CHECK(count > 1'000'000);
  CHECK(message.starts_with("the tape: no memory for "));
  CHECK(message.find(" of " + std::to_string(count) + " statements; checkpoint()") != std::string::npos);
  {
    const ShortMemory memory(1 << 20U);
    CHECK_THROWS_WITH(tape.reverse(y), contains("reverse: no memory for "));
  }
  tape.reverse(y);
  CHECK(x.adjoint() == static_cast<double>(count));
}
