#include <tapestry/core/in_quotes.hpp>

#include "../support/catch.hpp"

using tapestry::in_quotes;

TEST_CASE("in_quotes cuts long words and hides control characters", "[core][in_quotes]") {
  CHECK(in_quotes("") == "''");
  CHECK(in_quotes("a b\n\t\x7f") == "'a b" + std::string(3, '?') + "'");
  CHECK(in_quotes("grün") == "'grün'");
  CHECK(in_quotes(std::string(40, 'x')) == "'" + std::string(40, 'x') + "'");
  CHECK(in_quotes(std::string(41, 'x')) == "'" + std::string(40, 'x') + "…'");
}
