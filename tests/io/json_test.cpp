#include <tapestry/io/json.hpp>

#include <tapestry/io/text_lines.hpp>

#include "../support/bad_file.hpp"

using namespace tapestry;
using namespace std::string_literals;

namespace {
nlohmann::json value_of(const std::string& text) { return io::read_json(text, "some.json").value; }

std::string nested(std::size_t depth) {
  return R"({"a":)" + std::string(depth - 1, '[') + std::string(depth - 1, ']') + "}";
}
}  // namespace

TEST_CASE("read_json reads every kind of value", "[io][json]") {
  const auto json =
      value_of(" {\"a\" : [ 0 ,\t18446744073709551615,-1.5e1 ] ,\r\n\"\" : [null,true,false] } ");
  CHECK(json["a"][1].get<std::uint64_t>() == 18446744073709551615ULL);
  CHECK(json["a"][2].get<double>() == -15);
  CHECK(json[""].size() == 3);
  CHECK(value_of(R"("\"\\\/\b\f\n\r\t")").get<std::string>() == "\"\\/\b\f\n\r\t");
  CHECK(value_of(R"("\u0041\u00e9\u20AC\uD83D\uDE00\u0000")").get<std::string>() == "Aé€😀\0"s);
  CHECK(value_of(R"([{"a":1},{"a":1}])").size() == 2);  // the same key in two objects
  CHECK(value_of("7").get<int>() == 7);
}

TEST_CASE("read_json tells where the outermost members have their values", "[io][json]") {
  const auto json = io::read_json(R"({"a" : 12, "b":[1,{"a":3}] ,"c": "x","d":4})", "some.json", 100);
  CHECK(json.positions ==
        std::map<std::string, std::string>{{"a", "@107"}, {"b", "@115"}, {"c", "@133"}, {"d", "@141"}});
  CHECK(io::read_json("{\"é\": [\n1], \"b\":\n\n  2}", "some.json").positions ==
        std::map<std::string, std::string>{{"é", "1:7"}, {"b", "4:3"}});
  CHECK(io::read_json(R"([{"a":1}])", "some.json").positions.empty());
}

TEST_CASE("utf8_prefix ends where the text is no longer well-formed", "[io][json]") {
  CHECK(io::utf8_prefix("") == 0);
  CHECK(io::utf8_prefix("aé€😀") == 10);
  CHECK(io::utf8_prefix("\xED\x9F\xBF\xEE\x80\x80\xF4\x8F\xBF\xBF") == 10);  // beside surrogates; the last
  const std::vector<std::string> faulty = {"\x80", "\xFF",
                                           // Cut, overlong, of surrogates, beyond the last.
                                           "\xC3", "\xC3(", "\xC0\x80", "\xC1\xBF", "\xE0\x9F\xBF",
                                           "\xED\xA0\x80", "\xF0\x8F\xBF\xBF", "\xE2\x82", "\xF4\x90\x80\x80",
                                           "\xF5\x80\x80\x80", "\xE2\x82(", "\xF0\x9F\x98", "\xF0\x9F\x98("};
  for (const auto& fault : faulty) CHECK(io::utf8_prefix("ab" + fault) == 2);
}

TEST_CASE("read_json takes 64 levels and 131,072 members, and no more", "[io][json][bad_input][repeated]") {
  CHECK(value_of(nested(64)).size() == 1);
  std::string crowded = "{";
  for (int i = 0; i < 131072; ++i) crowded += "\"" + std::to_string(i) + "\":[],";
  crowded.back() = '}';
  CHECK(value_of(crowded).size() == 131072);
  crowded.back() = ',';
  const auto many = std::to_string(8 + crowded.size());
  const auto malformed = ErrorKind::malformed;
  test::check_bad_files({{"65 levels", nested(65), malformed, "@76",
                          "JSON nested too deep; expected at most 64 levels, found more"},
                         {"200,000 levels", nested(200000), malformed, "@76", "JSON nested too deep"},
                         {"200,000 objects",
                          [] {
                            std::string text;
                            for (int i = 0; i < 200000; ++i) text += R"({"a":)";
                            return text;
                          }(),
                          malformed, "@328", "JSON nested too deep"},
                         {"crowded", crowded + "\"x\":1}", ErrorKind::limit, "@" + many, "at most 131072"}},
                        "some.json",
                        [](const std::string& text) { (void)io::read_json(text, "some.json", 8); });
}

TEST_CASE("N17: read_json refuses what is not sound JSON", "[io][json][bad_input]") {
  const auto malformed = ErrorKind::malformed;
  test::check_bad_files(
      {
          {"empty", "", malformed, "1:1", "found the end"},
          {"cut", "{\"a\":[1,", malformed, "1:9", "found the end"},
          {"no colon", "{\"a\" [1]}", malformed, "1:6", "expected ':' behind the key, found '[1]}'"},
          {"no comma", "{\"a\":[1 2]}", malformed, "1:9", "expected ',' or ']', found '2]}'"},
          {"comma at the end", "{\"a\":[1],}", malformed, "1:10", "a key in double quotes, found '}'"},
          {"comma at the end of an array", "{\"a\":[1,]}", malformed, "1:9", "expected a value, found ']}'"},
          {"text behind", "{} {", malformed, "1:4", "expected the end, found '{'"},
          {"twice", "{\"a\":[],\"a\":[]}", malformed, "1:9", "expected each key once, found 'a'"},
          {"twice, once escaped", "{\"a\":[],\"\\u0061\":[]}", malformed, "1:9", "key given twice"},
          {"comment", "{/**/}", malformed, "1:2", "expected a key in double quotes, found '/**/}'"},
          {"single quotes", "{'a':[]}", malformed, "1:2", "expected a key in double quotes"},
          {"no number", "[NaN]", malformed, "1:2", "not valid JSON; expected a value, found 'NaN]'"},
          {"half a word", "[1,\n  [\"aé😀\", tru ]\r\n]", malformed, "2:11", "expected a value, found 'tru ]"},
          {"no digits", "[\n\n1.2e+]", malformed, "3:1", "expected a number such as -1.5e3, found '1.2e+]'"},
          {"leading zero", "{\"a\":[01]}", malformed, "1:8", "expected ',' or ']'"},
          {"far too large", "[1e999]", malformed, "1:2", "expected a number of at most 1.79e308"},
          {"far too large, behind others", "{\"a\": [1, 1e999]}", malformed, "1:11", "found '1e999]}'"},
          {"open string", "{\"a", malformed, "1:4", "expected a closing quote, found the end"},
          {"newline in a string", "{\"a\n\":[]}", malformed, "1:4", "expected an escape"},
          {"unknown escape", "{\"\\x\":[]}", malformed, "1:4", "backslash"},
          {"short escape", "{\"\\u00", malformed, "1:7", "four hexadecimal digits"},
          {"half a pair", "{\"\\ud83d\":[]}", malformed, "1:9", "surrogate"},
          {"second half", "{\"\\ude00\":[]}", malformed, "1:8", "surrogate"},
          {"not UTF-8", "{\"\xC3(\":[]}", malformed, "1:4", "UTF-8"},
          {"overlong", "[\"\xC0\x80\"]", malformed, "1:3", "UTF-8"},
          {"a surrogate's bytes", "[\"\xED\xA0\x80\"]", malformed, "1:4", "UTF-8"},
          {"zero byte", "{\"a\":[]}\0"s, malformed, "1:9", "zero byte"},
      },
      "some.json", [](const std::string& text) { (void)io::read_json(text, "some.json"); });
}

TEST_CASE("read_json takes every text that a parser must take", "[io][json]") {
  // The rules of RFC 8259 as the JSONTestSuite (Seriot, Parsing JSON is a Minefield) tests them, with new
  // cases.
  const std::vector<std::pair<std::string, std::string>> rows = {
      // Arrays and white space.
      {"[[]   ]", "[[]]"},
      {"[\"a\"]\n", "[\"a\"]"},
      {"[null, 1, \"1\", {}]", "[null,1,\"1\",{}]"},
      {"[1\n]", "[1]"},
      {" [1]", "[1]"},
      {"[2] ", "[2]"},
      {"\t\r\n[ \t\r\n]\t\r\n", "[]"},
      // Numbers.
      {"[123e65]", "[1.23e+67]"},
      {"[0e+1]", "[0.0]"},
      {"[0e1]", "[0.0]"},
      {"[ 4]", "[4]"},
      {"[-0." + std::string(77, '0') + "1]", "[-1e-78]"},
      {"[20e1]", "[200.0]"},
      {"[-0]", "[0]"},
      {"[1E22]", "[1e+22]"},
      {"[1E-2]", "[0.01]"},
      {"[1E+2]", "[100.0]"},
      {"[123e45]", "[1.23e+47]"},
      {"[123.456e78]", "[1.23456e+80]"},
      {"[1e-2]", "[0.01]"},
      {"[0.5, 10.25]", "[0.5,10.25]"},
      // Objects.
      {R"({"asd":"sdf", "dfg":"fgh"})", R"({"asd":"sdf","dfg":"fgh"})"},
      {R"({"foo\u0000bar": 42})", R"({"foo\u0000bar":42})"},
      {R"({ "min": -1.0e+28, "max": 1.0e+28 })", R"({"max":1e+28,"min":-1e+28})"},
      {"{\n\"a\": \"b\"\n}", R"({"a":"b"})"},
      // Strings.
      {R"(["\u0060\u012a\u12AB"])", "[\"`Īካ\"]"},
      {R"(["\uD801\udc37"])", "[\"\xF0\x90\x90\xB7\"]"},
      {R"(["\ud83d\ude39\ud83d\udc8d"])", "[\"\xF0\x9F\x98\xB9\xF0\x9F\x92\x8D\"]"},
      {R"(["\"\\\/\b\f\n\r\t"])", R"(["\"\\/\b\f\n\r\t"])"},
      {R"(["\uFFFF"])", "[\"\xEF\xBF\xBF\"]"},
      {R"(["\uDBFF\uDFFF"])", "[\"\xF4\x8F\xBF\xBF\"]"},
      {R"(["new\u00A0line"])", "[\"new\xC2\xA0line\"]"},
      {R"(["\u002c"])", R"([","])"},
      {"[\"\xCF\x80\"]", "[\"π\"]"},
      {R"(["\uD834\uDd1e"])", "[\"\xF0\x9D\x84\x9E\"]"},
      {R"(["\u0821\u0123"])", "[\"\xE0\xA0\xA1\xC4\xA3\"]"},
      {"[\"\xE2\x80\xA8\xE2\x80\xA9\"]", "[\"\xE2\x80\xA8\xE2\x80\xA9\"]"},  // U+2028, U+2029
      {R"(["\u005C\u0022"])", R"(["\\\""])"},
      {R"(["\u200B\u2064\uFDD0\uFFFE"])", "[\"\xE2\x80\x8B\xE2\x81\xA4\xEF\xB7\x90\xEF\xBF\xBE\"]"},
  };
  for (const auto& [text, expected] : rows) {
    INFO(text);
    CHECK(value_of(text).dump() == expected);
  }
  const std::vector<std::string> unchanged = {
      // Arrays.
      "[\"\"]", "[]", "[1,null,null,null,2]",
      // Numbers.
      "[-0.0]", "[-123]", "[-1]", "[123]", "[123.456789]", "[-9223372036854775808]",
      // Objects.
      R"({"asd":"sdf"})", "{}", R"({"":0})", R"({"a":[]})",
      // Strings.
      R"(["\\u0000"])", R"(["\""])", R"(["a/*b*/c/*d//e"])", R"(["\\a"])", R"(["\\n"])", R"(["\u0012"])",
      R"(["\u0000"])", "[\"\xF4\x8F\xBF\xBF\"]", "[\"\xEF\xBF\xBF\"]", "[\"\xF0\x9B\xBF\xBF\"]", "[\"€𝄞\"]",
      "[\"a\x7F"
      "a\"]",
      "\" \"",
      // A value alone.
      "false", "42", "-0.1", "null", "\"asd\"", "true", "\"\""};
  for (const auto& text : unchanged) CHECK(value_of(text).dump() == text);
}

TEST_CASE("read_json refuses every text that a parser must refuse", "[io][json][bad_input]") {
  const std::vector<std::string> rows = {
      // Arrays.
      "[1 true]", "[a\xE5]", "[\"\": 1]", "[\"\"],", "[,1]", "[1,,2]", "[\"x\",,]", "[\"x\"]]", "[\"\",]",
      "[\"x\"", "[x", "[3[4]]", "[\xFF]", "[1:2]", "[,]", "[-]", "[   , \"\"]", "[\"a\",\n4\n,1", "[1,]",
      "[1,,]", "[\"\va\"\\f]", "[*]", "[\"\"", "[1,", "[1,\n1\n,1", "[{}", "[1;2]", "[\"a\" \"b\"]",
      // Words.
      "[fals]", "[nul]", "[tru]", "[True]", "[truth]", "nullx", "[NULL]", "undefined", "123\0"s,
      // Numbers.
      "[++1234]", "[+1]", "[+Inf]", "[-01]", "[-1.0.]", "[-2.]", "[-NaN]", "[.-1]", "[.2e-3]", "[0.1.2]",
      "[0.3e+]", "[0.3e]", "[0.e1]", "[0E+]", "[0E]", "[0e+]", "[0e]", "[1.0e+]", "[1.0e-]", "[1.0e]",
      "[1 000.0]", "[1eE2]", "[2.e+3]", "[2.e-3]", "[2.e3]", "[9.e+]", "[Inf]", "[NaN]", "[\xEF\xBC\x91]",
      "[1+2]", "[0x1]", "[0x42]", "[Infinity]", "[0e+-1]", "[-123.123foo]", "[123\xE5]", "[1e1\xE5]",
      "[0\xE5]", "[-Infinity]", "[-foo]", "[- 1]", "[-012]", "[-.123]", "[-1x]", "[1ea]", "[1.]", "[.123]",
      "[1.2a-3]", "[1.8011670033376514H-308]", "[012]", "[1_000]", "-", "1e", "2@",
      // Objects.
      R"(["x", truth])", "{[: \"x\"}\n", R"({"x", null})", R"({"x"::"b"})", "{🇨🇭}", R"({"a":"a" 123})",
      R"({key: 'value'})", "{\"\xB9\":\"0\",}", R"({"a" b})", R"({:"b"})", R"({"a" "b"})", R"({"a":)",
      R"({"a")", "{1:1}", "{9999E9999:1}", "{null:null,null:null}", R"({"id":0,,,,,})", "{'a':0}",
      R"({"id":0,})", R"({"a":"b"}/**/)", R"({"a":"b"}/**//)", R"({"a":"b"}//)", R"({"a":"b"}/)",
      R"({"a":"b",,"c":"d"})", R"({a: "b"})", R"({"a":"a)", R"({ "foo" : "bar", "a" })", R"({"a":"b"}#)", " ",
      "{true:1}",
      // Strings.
      R"(["\uD800\"])", R"(["\uD800\u"])", R"(["\uD800\u1"])", R"(["\uD800\u1x"])", "[é]", "[\"\\\0\"]"s,
      R"(["\x00"])", R"(["\\\"])", "[\"\\\t\"]", "[\"\\🌀\"]", R"(["\"])", R"(["\u00A"])", R"(["\uD834\uDd"])",
      R"(["\uD800\uD800\x"])", "[\"\\u\xE5\"]", R"(["\a"])", R"(["\uqqqq"])", "[\"\\\xE5\"]",
      R"([\u0020"asd"])", R"([\n])", "\"", "['single quote']", "abc", R"(["\)", "[\"a\0a\"]"s,
      "[\"new\nline\"]", "[\"\t\"]", R"("\UA66D")", R"(""x)", "[\"\x1F\"]",
      // The whole.
      "", "\xEF\xBB\xBF", "<.>", "[<null>]", "[1]x", "[1]]", R"(["asd])", "aå", "1]", R"({"x": true,)",
      "[][]", "]", "\xEF\xBB{}", "\xE5", "[", "[\0]"s, "{}}", R"({"":)", R"({"a":/*comment*/"b"})",
      R"({"a": true} "x")", "['", "[,", "[{", "[\"a", "[\"a\"", "{", "{]", "{,", "{[", "{\"a", "{'a'",
      R"(["\{["\{["\{["\{)", "\xE9", "*", R"({"a":"b"}#{})", R"([\u000A""])", "[1", "[ false, nul",
      "[ false, tru", "[ true, fals", R"({"asd":"asd")", "å", "[\xE2\x81\xA0]", "\xE2\x81\xA0", "[\f]",
      "[\xC2\xA0]", "// one\n[]", "[] []", std::string(100000, '['),
      // A parser may take these: texts that are not UTF-8, lone surrogates, numbers beyond double, and,
      // stricter than others, more than 64 levels.
      "[\"\xEF\xBF\"]", "[\"\xE6\x97\xA5\xD1\x88\xFA\"]", "[\"\xFF\"]", "[\"\x81\"]", "[\"\xC0\xAF\"]",
      "[\"\xFC\x83\xBF\xBF\xBF\xBF\"]", "[\"\xE0\xFF\"]", "[\"\xF4\xBF\xBF\xBF\"]", "[\"\xED\xA0\x80\"]",
      "\xFF\xFE[\0\"\0\xE9\0\"\0]\0"s, "\0[\0\"\0\xE9\0\"\0]"s, R"({"\uDFAA":0})", R"(["\uDADA"])",
      R"(["\uD888\u1234"])", R"(["\uD800\n"])", R"(["\uDd1ea"])", R"(["\uD800\uD800\n"])", R"(["\ud800"])",
      R"(["\uDd1e\uD834"])", R"(["\uDFAA"])", "[0.4e006699999999999999]", "[-1e+9999]", "[1.5e+9999]",
      "[-123123e100000]", "[123123e100000]", std::string(500, '[') + std::string(500, ']'),
      R"({"a":"b","a":"c"})"};  // N17
  for (const auto& text : rows) {
    INFO(text.substr(0, 80));
    CHECK_THROWS_AS(value_of(text), FileError);
  }
}

TEST_CASE("read_json takes what others may refuse", "[io][json]") {
  CHECK(value_of("\xEF\xBB\xBF{}").dump() == "{}");  // a byte order mark
  CHECK(value_of("[123.456e-789, -1e-400]").dump() == "[0.0,-0.0]");
  CHECK(value_of("[100000000000000000000]").dump() == "[1e+20]");
  CHECK(value_of("[-123123123123123123123123123123]").dump() == "[-1.2312312312312312e+29]");
}
