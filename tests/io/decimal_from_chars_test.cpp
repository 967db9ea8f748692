#include <tapestry/io/detail/number_formats.hpp>

#include "../support/catch.hpp"

namespace io = tapestry::io;

TEMPLATE_TEST_CASE("decimal numbers by a stream are those of std::from_chars", "[io][text]", float, double) {
  for (const std::string text : {"0",        "-0",     "1",         "-12.5",
                                 ".5",       "5.",     "-.25",      "1e3",
                                 "1E-3",     "1e+3",   "0.1",       "3.4028234e38",
                                 "1e-40",    "0e999",  "0.00e-999", "1e999",
                                 "-1e999",   "1e-999", "16777217",  "1.7976931348623157e308",
                                 "4.9e-324", "12abc",  "1e",        "1e+",
                                 "1.5.5",    "1,5",    "",          "-",
                                 ".",        "-.",     "+1",        " 1",
                                 "e5",       "0x10",   "--1"}) {
    CAPTURE(text);
    TestType by_stream = 7, expected = 7;
    const char* const last = text.data() + text.size();
    const auto found = io::detail::decimal_by_stream(text.data(), last, by_stream);
    const auto wanted = io::decimal_from_chars(text.data(), last, expected);
    CHECK(found.ptr == wanted.ptr);
    CHECK(found.ec == wanted.ec);
    CHECK(by_stream == expected);
  }
}

TEST_CASE("words for numbers that are not finite are none to a stream's form", "[io][text]") {
  for (const std::string text : {"inf", "-infinity", "nan"}) {
    double value = 7;
    const auto found = io::detail::decimal_by_stream(text.data(), text.data() + text.size(), value);
    CHECK(found.ec == std::errc::invalid_argument);
  }
}
