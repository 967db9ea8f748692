#include <tapestry/io/npy.hpp>

#include "../support/refusal.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
std::string header(const std::string& dictionary, int version = 1) {
  std::string text("\x93NUMPY", 6);
  text += static_cast<char>(version);
  text += '\0';
  text += static_cast<char>(dictionary.size() & 0xFFU);
  text += static_cast<char>(dictionary.size() >> 8U);
  if (version > 1) text += std::string(2, '\0');
  return text + dictionary;
}

std::string array_file(const std::string& descr, const std::string& order, const std::string& shape,
                       const std::string& payload) {
  return header("{'descr': " + descr + ", 'fortran_order': " + order + ", 'shape': " + shape + ", }\n") +
         payload;
}

io::NpyArray parse(const std::string& file) { return io::parse_npy(file, "a.npy"); }
}  // namespace

TEST_CASE("an npy file is read by hand", "[io][npy]") {
  const auto array = parse(array_file("'<i2'", "False", "(2, 1)", std::string("\x01\x02\xff\xff", 4)));
  CHECK(array.shape == std::vector<std::size_t>{2, 1});
  CHECK(array.as<int>() == std::vector<int>{0x0201, -1});
  CHECK(array.as<double>() == std::vector<double>{513, -1});
  CHECK(array.array<float, 2>()(1, 0) == -1.0F);
  CHECK(parse(array_file("'>i2'", "False", "(1,)", std::string("\x01\x02", 2))).as<int>() ==
        std::vector<int>{258});
  CHECK(parse(array_file("'|b1'", "False", "()", "\x01")).as<int>() == std::vector<int>{1});
  CHECK(parse(array_file("'<f4'", "False", "(0, 3)", "")).array<float, 2>().size() == 0);  // N06
}

TEST_CASE("column-major arrays are transposed", "[io][npy]") {  // N09
  const auto array = parse(array_file("'|u1'", "True", "(2, 3)", std::string("\0\3\1\4\2\5", 6)));
  CHECK(array.as<int>() == std::vector<int>{0, 1, 2, 3, 4, 5});
  const auto cube = parse(array_file("'>u2'", "True", "(2, 1, 2)", std::string("\0\1\0\3\0\2\0\4", 8)));
  CHECK(cube.as<int>() == std::vector<int>{1, 2, 3, 4});
}

TEMPLATE_TEST_CASE("npy_bytes comes back", "[io][npy]", std::uint8_t, std::int16_t, std::int32_t,
                   std::int64_t, std::uint64_t, float, double) {
  const std::vector<TestType> values{std::numeric_limits<TestType>::lowest(), 0, 1,
                                     std::numeric_limits<TestType>::max()};
  const std::vector<std::size_t> shape{2, 2};
  const std::string file = io::npy_bytes<TestType>(shape, values);
  CHECK((file.size() - sizeof(TestType) * 4) % 64 == 0);
  const auto array = parse(file);
  CHECK(array.shape == shape);
  CHECK(array.as<TestType>() == values);
}

TEST_CASE("bad npy files are refused", "[io][npy][bad_input]") {
  const auto shaped = [](const std::string& shape) { return array_file("'<f4'", "False", shape, "1234"); };
  const auto malformed = ErrorKind::malformed;
  const BadContent rows[] = {
      {"N01", shaped("(2,)"), malformed, "expected 8 bytes, found 4"},
      {"N02", shaped("()") + "x", malformed, "expected 4 bytes, found 5"},
      {"N03", shaped("(4611686018427387905, 4)"), ErrorKind::limit, "larger than memory"},
      {"N03 wraps to 0", shaped("(4294967296, 4294967296)"), ErrorKind::limit, "larger than memory"},
      {"N03 beyond 64 bits", shaped("(99999999999999999999,)"), ErrorKind::limit, "larger than memory"},
      {"N03 hidden by 0", shaped("(4294967296, 4294967296, 0)"), ErrorKind::limit, "larger than memory"},
      {"N04", shaped("(1000000000, 1000000000, 1000000000)"), ErrorKind::limit, "larger than memory"},
      {"N04 fits a word", shaped("(1000000000, 100000000)"), malformed, "payload"},
      {"N05 negative", shaped("(-1,)"), malformed, "not a whole number"},
      {"N05 text", shaped("(a,)"), malformed, "not a whole number"},
      {"N05 fraction", shaped("(1.0,)"), malformed, "tuple"},
      {"N07 text", array_file("'<U8'", "False", "(1,)", ""), ErrorKind::mismatch, "found <U8"},
      {"N07 half", array_file("'<f2'", "False", "(2,)", "1234"), ErrorKind::mismatch, "found <f2"},
      {"N07 records", array_file("[('a', '<f4')]", "False", "(1,)", "1234"), ErrorKind::mismatch, "records"},
      {"N07 order", array_file("'f4'", "False", "(1,)", "1234"), malformed, "byte order"},
      {"N08", array_file("'|O'", "False", "(1,)", "1234"), malformed, "pickled objects are never loaded"},
      {"N10 empty", "", malformed, "magic"},
      {"N10 magic", "\x92NUMPY12345", malformed, "magic"},
      {"N10 version", header("{}", 9), malformed, "found 9"},
      {"N10 length 0", std::string("\x93NUMPY\x01\0\0\0", 10), malformed, "not a dictionary"},
      {"N10 length 65535", std::string("\x93NUMPY\x01\0\xff\xff", 10), malformed, "longer than the file"},
      {"N10 long", std::string("\x93NUMPY\x02\0\0\0\0\x7f", 12), malformed, "too long"},
      {"N10 key missing", header("{'descr': '<f4', 'shape': (1,)}") + "1234", malformed, "lacks a key"},
      {"N10 key unknown", header("{'desc': '<f4'}"), malformed, "unknown key"},
      {"N10 key repeated", header("{'shape': (), 'shape': ()}"), malformed, "repeated key"},
      {"N10 order", array_file("'<f4'", "1", "(1,)", "1234"), malformed, "fortran_order"},
      {"N10 rest", header("{'descr': '<f4', 'fortran_order': False, 'shape': ()} x") + "1234", malformed,
       "after"},
      {"N10 garbage", header(std::string("\0\0{", 3)), malformed, "control character"},
      {"N10 unclosed", header("{'descr': '<f4"), malformed, "quoted word"},
  };
  for (const BadContent& row : rows) {
    INFO(row.id);
    check_refused(row.kind, row.text, [&] { (void)parse(row.file); });
    check_refused(row.kind, "a.npy:@", [&] { (void)parse(row.file); });
  }
}

TEST_CASE("every cut of an npy file is refused", "[io][npy][bad_input]") {
  const std::string whole = array_file("'<f4'", "False", "(1, 2)", "12345678");
  for (std::size_t length = 0; length < whole.size(); ++length) {
    INFO(length);
    check_refused(ErrorKind::malformed, "a.npy:@", [&] { (void)parse(whole.substr(0, length)); });
  }
}

TEST_CASE("values that do not fit the asked type are refused", "[io][npy]") {
  const auto floats = parse(array_file("'<f4'", "False", "(1,)", std::string("\0\0\x80\x3f", 4)));
  CHECK(floats.as<double>() == std::vector<double>{1});
  check_refused(ErrorKind::mismatch, "expected i4, found f4", [&] { (void)floats.as<std::int32_t>(); });
  check_refused(ErrorKind::mismatch, "found (1,)", [&] { (void)floats.array<float, 2>(); });
  const auto wide = parse(array_file("'<i2'", "False", "(1,)", std::string("\0\1", 2)));
  check_refused(ErrorKind::mismatch, "expected u1, found 256", [&] { (void)wide.as<std::uint8_t>(); });
}
