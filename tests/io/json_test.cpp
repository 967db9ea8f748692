#include <tapestry/io/json.hpp>

#include <string>
#include <tapestry/io/utf8.hpp>
#include <vector>

#include "../support/bad_file.hpp"
#include "../support/catch.hpp"

namespace io = tapestry::io;
using tapestry::ErrorKind;
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
        std::map<std::string, std::uint64_t>{{"a", 107}, {"b", 115}, {"c", 133}, {"d", 141}});
  CHECK(io::read_json(R"([{"a":1}])", "some.json").positions.empty());
}

TEST_CASE("utf8_prefix ends where the text is no longer well-formed", "[io][json]") {
  CHECK(io::utf8_prefix("") == 0);
  CHECK(io::utf8_prefix("aé€😀") == 10);
  CHECK(io::utf8_prefix("\xED\x9F\xBF\xEE\x80\x80\xF4\x8F\xBF\xBF") == 10);  // beside surrogates; the last
  const std::vector<std::string> faulty = {"\x80",         "\xC3",
                                           "\xC3(",        "\xC0\x80",
                                           "\xC1\xBF",     "\xE0\x9F\xBF",
                                           "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
                                           "\xE2\x82",     "\xF4\x90\x80\x80",
                                           "\xFF",         "\xF5\x80\x80\x80",
                                           "\xE2\x82(",    "\xF0\x9F\x98",
                                           "\xF0\x9F\x98("};
  for (const auto& fault : faulty) CHECK(io::utf8_prefix("ab" + fault) == 2);
}

TEST_CASE("read_json takes 64 levels and 131,072 members, and no more", "[io][json][bad_input]") {
  CHECK(value_of(nested(64)).size() == 1);
  std::string crowded = "{";
  for (int i = 0; i < 131072; ++i) crowded += "\"" + std::to_string(i) + "\":[],";
  crowded.back() = '}';
  CHECK(value_of(crowded).size() == 131072);
  crowded.back() = ',';
  const auto many = std::to_string(8 + crowded.size());
  const auto malformed = ErrorKind::malformed;
  tapestry::test::check_bad_files(
      {{"65 levels", nested(65), malformed, "@76",
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
      "some.json", [](const std::string& text) { (void)io::read_json(text, "some.json", 8); });
}

TEST_CASE("N17: read_json refuses what is not sound JSON", "[io][json][bad_input]") {
  const auto malformed = ErrorKind::malformed;
  tapestry::test::check_bad_files(
      {
          {"empty", "", malformed, "@8",
           "unexpected end of input; expected '[', '{', or a literal; found the end"},
          {"cut", "{\"a\":[1,", malformed, "@16", "found the end"},
          {"no colon", "{\"a\" [1]}", malformed, "@13", "expected ':'; found '[1]}'"},
          {"no comma", "{\"a\":[1 2]}", malformed, "@16", "expected ']'"},
          {"comma at the end", "{\"a\":[1],}", malformed, "@17", "expected string literal"},
          {"comma at the end of an array", "{\"a\":[1,]}", malformed, "@16", "unexpected ']'"},
          {"text behind", "{} {", malformed, "@11", "unexpected '{'; expected end of input"},
          {"twice", "{\"a\":[],\"a\":[]}", malformed, "@16",
           "key given twice; expected each key once, found 'a'"},
          {"twice, once escaped", "{\"a\":[],\"\\u0061\":[]}", malformed, "@16", "key given twice"},
          {"comment", "{/**/}", malformed, "@9", "invalid"},
          {"single quotes", "{'a':[]}", malformed, "@9", "invalid"},
          {"no number", "[NaN]", malformed, "@9", "invalid"},
          {"leading zero", "{\"a\":[01]}", malformed, "@15", "unexpected number literal"},
          {"far too large", "[1e999]", malformed, "@13", "number overflow"},
          {"open string", "{\"a", malformed, "@11", "missing closing quote; found the end"},
          {"newline in a string", "{\"a\n\":[]}", malformed, "@11", "must be escaped"},
          {"unknown escape", "{\"\\x\":[]}", malformed, "@11", "backslash"},
          {"short escape", "{\"\\u00", malformed, "@14", "hex digits"},
          {"half a pair", "{\"\\ud83d\":[]}", malformed, "@16", "surrogate"},
          {"second half", "{\"\\ude00\":[]}", malformed, "@15", "surrogate"},
          {"not UTF-8", "{\"\xC3(\":[]}", malformed, "@11", "UTF-8"},
          {"overlong", "[\"\xC0\x80\"]", malformed, "@10", "UTF-8"},
          {"a surrogate's bytes", "[\"\xED\xA0\x80\"]", malformed, "@11", "UTF-8"},
          {"zero byte", "{\"a\":[]}\0"s, malformed, "@16", "zero byte"},
      },
      "some.json", [](const std::string& text) { (void)io::read_json(text, "some.json", 8); });
}
