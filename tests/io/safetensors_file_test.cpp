#include <tapestry/io/detail/number_formats.hpp>
#include <tapestry/io/detail/safetensors_file.hpp>

#include <cmath>

#include "../support/bad_file.hpp"
#include "../support/catch.hpp"
#include "../support/safetensors_bytes.hpp"
#include "../support/temporary_folder.hpp"

namespace io = tapestry::io;
using tapestry::ErrorKind;
using tapestry::test::BadFile;
using tapestry::test::safetensors_bytes;
using tapestry::test::TemporaryFolder;
using namespace std::string_literals;

namespace {
std::string entry(const std::string& name, const std::string& type, const std::string& shape,
                  const std::string& offsets) {
  return "\"" + name + R"(":{"dtype":")" + type + R"(","shape":[)" + shape + R"(],"data_offsets":[)" +
         offsets + "]}";
}

std::vector<float> copied(const io::SafetensorsFile& file, std::size_t tensor) {
  std::vector<float> values(file.tensors()[tensor].size());
  file.read(file.tensors()[tensor], values);
  return values;
}

template <class Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

constexpr float infinity = std::numeric_limits<float>::infinity();
}  // namespace

TEST_CASE("the smallest safetensors files are read", "[io][safetensors]") {
  const TemporaryFolder folder;
  const io::SafetensorsFile empty(folder.write("empty", safetensors_bytes("{}")));
  CHECK(empty.tensors().empty());
  CHECK(empty.metadata().empty());

  const io::SafetensorsFile file(folder.write(
      "some",
      safetensors_bytes("{" + entry("b", "F32", "2,0,3", "4,4") + "," + entry("number", "F32", "", "0,4") +
                            R"(,"__metadata__":{"k":"v"}})" + "  ",
                        "\0\0\x80\x3F"s)));
  REQUIRE(file.tensors().size() == 2);  // in the order of their bytes
  CHECK(file.tensors()[0].name == "number");
  CHECK(file.tensors()[0].size() == 1);
  CHECK(copied(file, 0) == std::vector<float>{1});
  CHECK(file.tensors()[1].size() == 0);
  CHECK(file.metadata().at("k") == "v");
}

TEST_CASE("half precision is widened exactly, double rounded to the nearest float", "[io][safetensors]") {
  const TemporaryFolder folder;
  const std::vector<std::uint16_t> half{0x3C00, 0xC000, 0x7BFF, 0x0400, 0x0001,
                                        0x83FF, 0x8000, 0x7C00, 0x3555};
  const std::vector<std::uint16_t> brain{0x3F80, 0xC000, 0x7F7F, 0x0001, 0xFF80};
  const std::vector<double> wide{1.0 / 3, -0.0, 1e300, -1e300, 0x1.FFFFFEp127, 1e-60};
  const io::SafetensorsFile file(folder.write(
      "some",
      safetensors_bytes("{" + entry("h", "F16", "9", "0,18") + "," + entry("b", "BF16", "5", "18,28") + "," +
                            entry("w", "F64", "2,3", "28,76") + "}",
                        bytes_of(half) + bytes_of(brain) + bytes_of(wide))));
  CHECK(copied(file, 0) ==
        std::vector<float>{1, -2, 65504, 0x1p-14F, 0x1p-24F, -1023 * 0x1p-24F, -0.0F, infinity, 0x1.554p-2F});
  CHECK(std::signbit(copied(file, 0)[6]));
  CHECK(copied(file, 1) == std::vector<float>{1, -2, 0x1.FEp127F, 0x1p-133F, -infinity});
  CHECK(copied(file, 2) ==
        std::vector<float>{1.0F / 3, -0.0F, infinity, -infinity, std::numeric_limits<float>::max(), 0});
}

TEST_CASE("every half-precision number agrees with its definition", "[io][safetensors]") {
  for (std::uint32_t bits = 0; bits < 0x7C00; ++bits) {
    const std::array<std::byte, 2> bytes{std::byte(bits & 0xFFU), std::byte(bits >> 8U)};
    const auto exponent = static_cast<int>(bits >> 10U);
    const auto fraction = static_cast<double>(bits & 0x3FFU);
    const double value = std::ldexp(exponent == 0 ? fraction : 1024 + fraction, std::max(exponent, 1) - 25);
    if (io::float_from_f16(bytes.data()) != static_cast<float>(value)) FAIL_CHECK(bits);
  }
}

TEST_CASE("safetensors files that are written read back to the same bits", "[io][safetensors]") {
  const TemporaryFolder folder;
  const std::vector<float> values{1, -0.0F, std::numeric_limits<float>::quiet_NaN(), infinity, 1e-42F, 7};
  const auto path = folder.path("some");
  for (std::size_t padding = 0; padding < 8; ++padding) {
    const std::string text = "é\n\"" + std::string(padding, 'x');
    io::write_safetensors(path, {{"text", text}, {"", "empty key"}}, {{"a", {2, 2}}, {"b", {}}, {"c", {1}}},
                          values);
    const io::SafetensorsFile file(path);
    CHECK(file.metadata().at("text") == text);
    CHECK(file.position(file.tensors()[0]) % 8 == 0);
    CHECK(file.tensors()[0].shape == std::vector<std::size_t>{2, 2});
    CHECK(bytes_of(copied(file, 0)) + bytes_of(copied(file, 1)) + bytes_of(copied(file, 2)) ==
          bytes_of(values));
    const auto bytes = folder.read("some");
    io::write_safetensors(path, file.metadata(), {{"a", {2, 2}}, {"b", {}}, {"c", {1}}}, values);
    CHECK(folder.read("some") == bytes);
  }
}

TEST_CASE("numbers may begin at any byte", "[io][safetensors]") {
  const TemporaryFolder folder;
  for (std::size_t padding = 0; padding < 4; ++padding) {
    const auto header = "{" + entry("a", "F32", "1", "0,4") + "}" + std::string(padding, ' ');
    const io::SafetensorsFile file(folder.write("some", safetensors_bytes(header, "\0\0\x80\x3F"s)));
    CHECK(copied(file, 0) == std::vector<float>{1});
  }
}

TEST_CASE("a part of a tensor is read from any element on", "[io][safetensors]") {
  const TemporaryFolder folder;
  const std::vector<float> whole{1, 2, 3, 4};
  const std::vector<std::uint16_t> brain{0x3F80, 0x4000, 0x4040, 0x4080};
  const io::SafetensorsFile file(folder.write(
      "some",
      safetensors_bytes("{" + entry("f", "F32", "2,2", "0,16") + "," + entry("b", "BF16", "4", "16,24") + "}",
                        bytes_of(whole) + bytes_of(brain))));
  for (const auto& tensor : file.tensors()) {
    std::vector<float> middle(2);
    file.read(tensor, middle, 1);
    CHECK(middle == std::vector<float>{2, 3});
    CHECK_NOTHROW(file.read(tensor, {}, 4));
    CHECK_THROWS_AS(file.read(tensor, middle, 3), tapestry::ShapeError);
    CHECK_THROWS_AS(file.read(tensor, {}, 5), tapestry::ShapeError);
  }
}

TEST_CASE("write_safetensors refuses what no reader would accept", "[io][safetensors]") {
  const TemporaryFolder folder;
  const auto path = folder.path("some");
  const std::vector<float> values(4);
  const auto huge = std::size_t(1) << 62U;
  CHECK_THROWS_AS(io::write_safetensors(path, {}, {{"a", {2}}, {"a", {2}}}, values), tapestry::DomainError);
  CHECK_THROWS_AS(io::write_safetensors(path, {}, {{"a", {5}}}, values), tapestry::DomainError);
  CHECK_THROWS_AS(io::write_safetensors(path, {}, {{"a", {3}}}, values), tapestry::DomainError);
  CHECK_THROWS_AS(io::write_safetensors(path, {}, {{"a", {huge, 4}}}, {}), tapestry::DomainError);
  CHECK_THROWS_AS(io::write_safetensors(path, {{"a", "\xFF"}}, {{"a", {4}}}, values), tapestry::DomainError);
  CHECK_THROWS_AS(io::write_safetensors(path, {{"a", std::string(17U << 20U, 'x')}}, {{"a", {4}}}, values),
                  tapestry::DomainError);
  CHECK_FALSE(std::filesystem::exists(path));
  CHECK_THROWS_AS(io::write_safetensors(folder.path("no/such"), {}, {{"a", {4}}}, values),
                  tapestry::FileError);
}

TEST_CASE("N15, N16: safetensors files that are not sound are refused", "[io][safetensors][bad_input]") {
  const TemporaryFolder folder;
  const auto malformed = ErrorKind::malformed;
  const auto one = [](const std::string& type, const std::string& shape, const std::string& offsets,
                      std::size_t size) {
    return safetensors_bytes("{" + entry("a", type, shape, offsets) + "}", std::string(size, '\0'));
  };
  const auto two = [](const std::string& first, const std::string& second, std::size_t size) {
    return safetensors_bytes("{" + entry("a", "F32", "2", first) + "," + entry("b", "F32", "2", second) + "}",
                             std::string(size, '\0'));
  };
  const std::string second = "@66";  // where the entry of b begins
  auto long_header = safetensors_bytes("{}");
  long_header[0] = 100;
  auto endless_header = safetensors_bytes("{}");
  endless_header.replace(0, 8, "\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF");
  auto twice = two("0,8", "8,16", 16);
  twice.replace(twice.find("\"b\""), 3, "\"a\"");
  const std::string deep(100000, '[');
  tapestry::test::check_bad_files(
      {
          {"N15 empty", "", malformed, "@0", "8 bytes, found 0 bytes"},
          {"N15 seven bytes", "\2\0\0\0\0\0\0"s, malformed, "@0", "found 7 bytes"},
          {"N15 length beyond the file", long_header, malformed, "@0", "passes the end of the file"},
          {"N15 endless", endless_header, malformed, "@0", "passes the end of the file"},
          {"N15 length beyond the limit", safetensors_bytes("{" + std::string(16U << 20U, ' ') + "}"),
           ErrorKind::limit, "@0", "header too large"},
          {"N15 no header", std::string(8, '\0'), malformed, "@8", "expected '{', found no bytes"},
          {"N15 not JSON", safetensors_bytes("{abc}"), malformed, "@9", "not valid JSON"},
          {"N15 not UTF-8", safetensors_bytes("{\"\xFF\":1}"), malformed, "@10", "ill-formed UTF-8"},
          {"N15 array", safetensors_bytes("[]"), malformed, "@8", "expected '{'"},
          {"N15 blank first", safetensors_bytes(" {}"), malformed, "@8", "expected '{'"},
          {"N15 text behind", safetensors_bytes("{}{}"), malformed, "@10",
           "expected end of input; found '{}'"},
          {"N15 twice", twice, malformed, "@62", "key given twice; expected each key once, found 'a'"},
          {"N15 dtype twice", safetensors_bytes(R"({"a":{"dtype":"F32","dtype":"F32"}})"), malformed, "@28",
           "key given twice"},
          {"N15 metadata twice", safetensors_bytes(R"({"__metadata__":{"k":"1","k":"2"}})"), malformed, "@33",
           "key given twice"},
          {"N15 metadata of numbers", safetensors_bytes(R"({"__metadata__":{"k":1}})"), malformed, "@24",
           "__metadata__ makes no sense; expected an object of strings"},
          {"N15 deep tensor", safetensors_bytes("{\"a\":" + deep), malformed, "@15", "nested too deep"},
          {"N15 deep shape", safetensors_bytes(R"({"a":{"shape":)" + deep), malformed, "@23",
           "nested too deep"},
          {"N15 deep metadata", safetensors_bytes(R"({"__metadata__":)" + deep), malformed, "@26",
           "nested too deep; expected at most 3 levels"},
          {"N15 a number for a tensor", safetensors_bytes(R"({"a":1})"), malformed, "@13",
           "tensor 'a': not an entry; expected an object of dtype, shape and data_offsets, found number"},
          {"N15 a number for a shape",
           safetensors_bytes(R"({"a":{"dtype":"F32","shape":1,"data_offsets":[0,4]}})"), malformed, "@13",
           "tensor 'a': shape makes no sense; expected a list of whole numbers"},
          {"N15 a negative extent", one("F32", "-1", "0,4", 4), malformed, "@13", "shape makes no sense"},
          {"N15 an extent with a fraction", one("F32", "1.0", "0,4", 4), malformed, "@13",
           "shape makes no sense"},
          {"N15 an offset of 2^64", one("F32", "1", "0,18446744073709551616", 4), malformed, "@13",
           "data_offsets makes no sense"},
          {"N15 a number for a type",
           safetensors_bytes(R"({"a":{"dtype":7,"shape":[],"data_offsets":[0,4]}})"), malformed, "@13",
           "unknown dtype; expected F32, F64, F16, BF16 or an integer type, found number"},
          {"a page", "<html><body>not found", malformed, "@0", "HTML"},
          {"a zip archive", "PK\x03\x04" + std::string(40, '\0'), malformed, "@0", "zip"},
          {"N16 overlap", two("0,8", "4,12", 12), malformed, second,
           "tensor 'b': bytes overlap those of tensor 'a'; expected to begin at 8, found 4"},
          {"N16 same bytes", two("0,8", "0,8", 8), malformed, second, "overlap"},
          {"N16 gap", two("0,8", "12,20", 20), malformed, second, "tensor 'b': unused bytes before it"},
          {"N16 gap first", one("F32", "1", "4,8", 8), malformed, "@13", "tensor 'a': unused bytes"},
          {"N16 reversed", one("F32", "1", "4,0", 4), malformed, "@13",
           "tensor 'a': data_offsets run backwards; expected the end not before the beginning, found 4 to 0"},
          {"N16 past the end", two("0,8", "8,16", 12), malformed, second,
           "tensor 'b': data_offsets pass the end"},
          {"N16 far past the end", one("F32", "1", "18446744073709551612,18446744073709551615", 4), malformed,
           "@13", "pass the end"},
          {"N16 bytes left", one("F32", "1", "0,4", 5), malformed, "", "bytes after the last tensor"},
          {"N16 bytes without tensors", safetensors_bytes("{}", "x"), malformed, "",
           "bytes after the last tensor"},
          {"N16 shape too small", one("F32", "1", "0,8", 8), malformed, "@13",
           "expected 4 bytes for (1,) of F32, found 8"},
          {"N16 another type's size", one("F16", "2", "0,8", 8), malformed, "@13", "4 bytes for (2,) of F16"},
          {"N16 overflow", one("F32", "4294967296,4294967296", "0,0", 0), malformed, "@13",
           "shape too large"},
          {"N16 overflow by the type", one("F64", "2305843009213693952", "0,0", 0), malformed, "@13",
           "shape too large"},
          {"N16 many axes", one("F32", "1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1", "0,4", 4), malformed, "@13",
           "too many entries of shape; expected at most 16, found 17"},
          {"N16 unknown type", one("F31", "1", "0,4", 4), malformed, "@13", "tensor 'a': unknown dtype"},
          {"N16 three offsets", one("F32", "1", "0,4,4", 4), malformed, "@13",
           "too many entries of data_offsets; expected at most 2, found 3"},
          {"N16 one offset", one("F32", "1", "0", 4), malformed, "@13", "incomplete entry"},
          {"N16 no shape", safetensors_bytes(R"({"a":{"dtype":"F32","data_offsets":[0,0]}})"), malformed,
           "@13", "incomplete entry"},
          {"N16 unknown field", safetensors_bytes(R"({"a":{"type":"F32"}})"), malformed, "@13",
           "tensor 'a': unknown field; expected dtype, shape and data_offsets, found 'type'"},
      },
      folder.path("some"), [&](const std::string& bytes) {
        folder.write("some", bytes);
        const io::SafetensorsFile file(folder.path("some"));
      });
}

TEST_CASE("every cut and every changed byte of a header is refused or harmless",
          "[io][safetensors][bad_input]") {
  const TemporaryFolder folder;
  io::write_safetensors(folder.path("good"), {{"k", "v"}}, {{"a", {2, 1}}, {"b", {1}}},
                        std::vector<float>{1, 2, 3});
  const auto good = folder.read("good");
  const auto read = [&](const std::string& bytes) {
    folder.write("some", bytes);
    const io::SafetensorsFile file(folder.path("some"));
    for (std::size_t i = 0; i < file.tensors().size(); ++i)
      if (io::item_size(file.tensors()[i].type) >= 4 && io::type_name(file.tensors()[i].type)[0] == 'F')
        (void)copied(file, i);
  };
  for (std::size_t size = 0; size < good.size(); ++size)
    CHECK_THROWS_AS(read(good.substr(0, size)), tapestry::FileError);
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const char byte : "\0\x01\x20\"0\\9[]{}:,\x80\xFF"s) {
      auto changed = good;
      changed[at] = byte;
      try {
        read(changed);
      } catch (const tapestry::FileError&) {  // and nothing else
      }
    }
  }
}

TEST_CASE("W16: a safetensors file that is cut or grows while it is open is refused",
          "[io][safetensors][bad_input]") {
  const TemporaryFolder folder;
  const auto path = folder.path("some");
  io::write_safetensors(path, {}, {{"a", {1000, 10}}}, std::vector<float>(10000));
  const io::SafetensorsFile file(path);
  const std::size_t header_size = file.position(file.tensors()[0]);
  std::filesystem::resize_file(path, 5000);
  std::vector<float> values(10000);
  CHECK_THROWS_WITH(file.read(file.tensors()[0], values), path + ":@5000: file ends early; expected " +
                                                              std::to_string(header_size + 40000 - 5000) +
                                                              " more bytes, found none");
  CHECK_THROWS_WITH(file.read(file.tensors()[0], std::span(values).first(10)),
                    contains("changed while it was read; expected "));
  std::filesystem::resize_file(path, header_size + 40001);
  CHECK_THROWS_WITH(file.read(file.tensors()[0], values), contains("changed while it was read"));
}

TEST_CASE("a safetensors file that is deleted or replaced while it is open stays readable",
          "[io][safetensors]") {
  const TemporaryFolder folder;
  const auto path = folder.path("some");
  io::write_safetensors(path, {}, {{"a", {2}}}, std::vector<float>{1, 2});
  const io::SafetensorsFile file(path);
  io::write_safetensors(path, {}, {{"a", {3}}}, std::vector<float>{3, 4, 5});
  CHECK(copied(file, 0) == std::vector<float>{1, 2});
  std::filesystem::remove(path);
  CHECK(copied(file, 0) == std::vector<float>{1, 2});
}

TEST_CASE("a safetensors file is known by its first brace, whatever its header's length spells",
          "[io][safetensors]") {
  const TemporaryFolder folder;
  for (const std::size_t length :
       {0x3CU, 0x280U, 0x380U, 0x8B1FU, 0x4E89U}) {  // '<', two pickles, gzip, a prefix
    const auto path = folder.write("some", safetensors_bytes("{" + std::string(length - 2, ' ') + "}"));
    CHECK(io::SafetensorsFile(path).tensors().empty());
  }
}
