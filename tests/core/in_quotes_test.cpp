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

TEST_CASE("what goes to a terminal gives it no orders", "[core][in_quotes]") {
  CHECK(tapestry::printable("plain, größe, 日本") == "plain, größe, 日本");
  CHECK(tapestry::printable("\x1b[31mred\a\n\x7f") == "?[31mred???");
  CHECK(tapestry::printable("\xc2\x9b"
                            "31m\xc2\xa0\xc2") == "?31m\xc2\xa0\xc2");  // CSI as U+009B
}
