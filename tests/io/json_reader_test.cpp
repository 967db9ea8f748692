#include <tapestry/io/json_reader.hpp>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "../support/bad_file.hpp"
#include "../support/catch.hpp"

namespace io = tapestry::io;
using tapestry::ErrorKind;
using tapestry::test::BadFile;
using namespace std::string_literals;

namespace {
std::string string_of(const std::string& text) {
  io::JsonReader reader(text, "some.json");
  auto value = reader.string();
  reader.end();
  return value;
}

/// Reads {"key": [count, ...], ...}.
std::map<std::string, std::vector<std::uint64_t>> counts_of(const std::string& text) {
  io::JsonReader reader(text, "some.json", 8);
  std::map<std::string, std::vector<std::uint64_t>> counts;
  reader.object([&](const std::string& key) {
    auto& list = counts[key];
    reader.array([&] { list.push_back(reader.count()); });
  });
  reader.end();
  return counts;
}
}  // namespace

TEST_CASE("JsonReader reads objects, arrays, strings and counts", "[io][json]") {
  CHECK(counts_of("{}").empty());
  const auto counts = counts_of(" {\"a\" : [ 0 ,\t18446744073709551615 ] ,\r\n\"\" : [ ] } ");
  REQUIRE(counts.size() == 2);
  CHECK(counts.at("a") == std::vector<std::uint64_t>{0, 18446744073709551615ULL});
  CHECK(counts.at("").empty());
  CHECK(string_of(R"("\"\\\/\b\f\n\r\t")") == "\"\\/\b\f\n\r\t");
  CHECK(string_of(R"("\u0041\u00e9\u20AC\uD83D\uDE00\u0000")") == "Aé€😀\0"s);
}

TEST_CASE("json_string is the reverse of JsonReader::string", "[io][json]") {
  std::string text = "é€😀";
  for (char c = 0; c < 127; ++c) text += c;
  text += '\x7f';
  CHECK(string_of(io::json_string(text)) == text);
  CHECK(io::json_string("a\n\"\x01") == R"("a\n\"\u0001")");
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

TEST_CASE("JsonReader refuses what is not the JSON asked for", "[io][json][bad_input]") {
  const auto malformed = ErrorKind::malformed;
  std::string crowded = "{";
  for (int i = 0; i <= 131072; ++i) crowded += "\"" + std::to_string(i) + "\":[],";
  crowded.back() = '}';
  const auto last_key = crowded.rfind("\"131072\"");
  tapestry::test::check_bad_files(
      {
          {"empty", "", malformed, "@8", "expected '{', found the end"},
          {"another type", "[]", malformed, "@8", "expected '{', found '[]'"},
          {"cut", "{\"a\":[1,", malformed, "@16", "whole number"},
          {"no colon", "{\"a\" [1]}", malformed, "@13", "expected ':'"},
          {"no comma", "{\"a\":[1 2]}", malformed, "@16", "expected ',' or ']'"},
          {"comma at the end", "{\"a\":[1],}", malformed, "@17", "expected a string"},
          {"comma at the end of an array", "{\"a\":[1,]}", malformed, "@16", "whole number"},
          {"text behind", "{} x", malformed, "@11", "text after the last value; expected the end, found 'x'"},
          {"twice", "{\"a\":[],\"a\":[]}", malformed, "@16",
           "key given twice; expected each key once, found 'a'"},
          {"twice, once escaped", "{\"a\":[],\"\\u0061\":[]}", malformed, "@16", "key given twice"},
          {"comment", "{/**/}", malformed, "@9", "expected a string"},
          {"single quotes", "{'a':[]}", malformed, "@9", "expected a string"},
          {"negative", "{\"a\":[-1]}", malformed, "@14", "whole number"},
          {"fraction", "{\"a\":[1.0]}", malformed, "@14", "whole number"},
          {"exponent", "{\"a\":[1e3]}", malformed, "@14", "whole number"},
          {"leading zero", "{\"a\":[01]}", malformed, "@14", "whole number"},
          {"too large", "{\"a\":[18446744073709551616]}", malformed, "@14", "whole number"},
          {"far too large", "{\"a\":[99999999999999999999999]}", malformed, "@14", "whole number"},
          {"string for a number", "{\"a\":[\"1\"]}", malformed, "@14", "whole number"},
          {"null", "{\"a\":null}", malformed, "@13", "expected '['"},
          {"deep", "{\"a\":" + std::string(100000, '[') + std::string(100000, ']') + "}", malformed, "@14",
           "whole number"},
          {"open string", "{\"a", malformed, "@11",
           "without its closing quote; expected '\"', found the end"},
          {"newline in a string", "{\"a\n\":[]}", malformed, "@11",
           "control character in a string; expected an escape, found byte 10"},
          {"unknown escape", "{\"\\x\":[]}", malformed, "@11",
           "unknown escape in a string; expected one of \"\\/bfnrtu, found 'x\":[]}'"},
          {"open escape", "{\"\\", malformed, "@11", "unknown escape"},
          {"short escape", "{\"\\u00", malformed, "@14", "hexadecimal"},
          {"no hexadecimal", "{\"\\u00g0\":[]}", malformed, "@14", "hexadecimal"},
          {"half a pair", "{\"\\ud83d\":[]}", malformed, "@10", "surrogate"},
          {"two first halves", "{\"\\ud83d\\ud83d\":[]}", malformed, "@10", "surrogate"},
          {"second half", "{\"\\ude00\":[]}", malformed, "@10", "surrogate"},
          {"not UTF-8", "{\"\xC3(\":[]}", malformed, "@10",
           "not UTF-8; expected well-formed text, found byte 195"},
          {"zero byte", "{\"a\":[]}\0"s, malformed, "@16", "text after the last value"},
          {"crowded", crowded, ErrorKind::limit, "@" + std::to_string(8 + last_key), "131072"},
      },
      "some.json", [](const std::string& text) { (void)counts_of(text); });
}
