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

TEST_CASE("no character turns the direction of what a terminal shows", "[core][in_quotes]") {
  CHECK(tapestry::printable("gpj.\u202Ecod") == "gpj.?cod");
  CHECK(tapestry::printable("\u061C\u200E\u200F\u2028\u202A\u2066\u2069") == std::string(7, '?'));
  // Their neighbours, and sequences that end early, stay.
  for (const std::string text :
       {"\u061B\u061D\u200D\u2010\u2027\u202F\u2065\u206A", "\xe2\x80", "\xe2", "\xd8"})
    CHECK(tapestry::printable(text) == text);
}

TEST_CASE("a message is cut in its middle, between characters, and says by how much", "[core][in_quotes]") {
  CHECK(tapestry::shortened(std::string(2000, 'x')) == std::string(2000, 'x'));
  CHECK(tapestry::shortened("abcdefghijkl", 8) == "abcdef … (4 bytes left out) … kl");
  CHECK(tapestry::shortened("äääääää", 8) == "äää … (6 bytes left out) … ä");  // two bytes each
  CHECK(tapestry::shortened("€€€€", 8) == "€€ … (6 bytes left out) … ");       // three bytes each
  CHECK(tapestry::shortened(std::string(1000000, 'x')).size() < 2100);
}
