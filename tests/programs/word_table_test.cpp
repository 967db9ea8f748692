#include "../../examples/programs/shell/word_table.hpp"

#include "../../examples/programs/shell/csv.hpp"
#include "../support/catch.hpp"

namespace shell = tapestry::shell;

TEST_CASE("words of a Markdown table are words, whatever they are made of", "[programs][tables]") {
  using shell::markdown_escaped;
  CHECK(markdown_escaped("plain words, 12.5 % [10.1, 14.9] (+3) - 2.") ==
        "plain words, 12.5 % [10.1, 14.9] (+3) - 2.");
  CHECK(markdown_escaped("yolox_nano p_at_50") == "yolox_nano p_at_50");
  CHECK(markdown_escaped("_a_ *b* ~~c~~ `d`") == "\\_a\\_ \\*b\\* \\~\\~c\\~\\~ \\`d\\`");
  CHECK(markdown_escaped("a|b") == "a\\|b");
  CHECK(markdown_escaped("<img src=x onerror=alert(1)> & &lt;") ==
        "&lt;img src=x onerror=alert(1)&gt; &amp; &amp;lt;");
  CHECK(markdown_escaped("[x](javascript:alert)") == "[x\\](javascript:alert)");
  CHECK(markdown_escaped("[x][y] [x]: z") == "[x\\][y] [x\\]: z");
  CHECK(markdown_escaped("a\\|b") == "a\\\\\\|b");
  CHECK(markdown_escaped("a\r\n# b") == "a  # b");

  const shell::WordTable table{"a <b>", {"", "x|y"}, {{"<i>", "1 | 2"}, {"-", "3"}}};
  CHECK(shell::markdown_of(table) ==
        "**a &lt;b&gt;**\n\n|  | x\\|y |\n|---|---:|\n| &lt;i&gt; | 1 \\| 2 |\n| - | 3 |\n\n");
}

TEST_CASE("a text in a CSV is one field, and no formula", "[programs][tables]") {
  using shell::csv_field, shell::csv_quoted;
  for (const char* plain : {"car", "traffic light", "", "a=b", "x-1", "l'oeil", "1.5"})
    CHECK(csv_field(plain) == plain);
  CHECK(csv_field("a,b") == "\"a,b\"");
  CHECK(csv_field("a;=b") == "\"a;=b\"");
  CHECK(csv_field("say \"a\"") == "\"say \"\"a\"\"\"");
  CHECK(csv_quoted("car") == "\"car\"");
  CHECK(csv_field("=HYPERLINK(\"http://x\",\"y\")") == "\"'=HYPERLINK(\"\"http://x\"\",\"\"y\"\")\"");
  for (const std::string first :
       {"=", "+", "-", "@", "\t", "\r", "\n", "\uff1d", "\uff0b", "\uff0d", "\uff20"}) {
    CHECK(csv_field(first + "1+1") == "\"'" + first + "1+1\"");
    CHECK(csv_quoted(first + "1+1") == "\"'" + first + "1+1\"");
  }
}

TEST_CASE("what rounds to nothing has no sign", "[programs][tables]") {
  CHECK(shell::fixed(-0.04, 1) == "0.0");
  CHECK(shell::fixed(-0.06, 1) == "-0.1");
  CHECK(shell::fixed(-0.4, 0) == "0");
  CHECK(shell::fixed(-10, 0) == "-10");
  CHECK(shell::interval_text({-0.0004, 0.2}) == "[0.0, 20.0]");
  CHECK(shell::interval_text({-0.0004, -0.002}, 1, 3) == "[0.000, -0.002]");
}
