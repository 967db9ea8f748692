#include <tapestry/io/onnx/onnx_file.hpp>

#include "../../support/onnx_builder.hpp"
#include "../../support/refusal.hpp"
#include "../../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;
using onnx::bytes_field, onnx::changed, onnx::Extent, onnx::integer_field, onnx::ModelParts, onnx::node,
    onnx::Packing, onnx::with_tensor;

namespace {
constexpr auto malformed = ErrorKind::malformed;
constexpr auto limit = ErrorKind::limit;

std::string with_node(const std::string& fields) {
  return changed([&](ModelParts& parts) { parts.nodes.push_back(fields); });
}
std::string with_attribute(const std::string& fields) {
  return with_node(node("Other", {"logits"}, {"more"}, {fields}, "last one"));
}
std::string with_elements(onnx::Type type, const std::vector<std::int64_t>& dims, const std::string& fields) {
  return with_tensor(onnx::tensor("w", type, dims, fields));
}
std::string with_input(const std::string& fields) {
  return changed([&](ModelParts& parts) { parts.inputs.push_back(fields); });
}
std::string with_opset(std::int64_t version) {
  return changed([&](ModelParts& parts) { parts.opsets = {{"", version}}; });
}
std::string in_graph(const std::string& fields) {
  return changed([&](ModelParts& parts) { parts.more_of_graph = fields; });
}
std::string in_model(const std::string& fields) {
  return changed([&](ModelParts& parts) { parts.more_of_model = fields; });
}
/// The model without its last node, and instead these.
std::string with_end(const std::vector<std::string>& nodes) {
  return changed([&](ModelParts& parts) {
    parts.nodes.pop_back();
    parts.nodes.insert(parts.nodes.end(), nodes.begin(), nodes.end());
  });
}
/// A field of bytes that states another length.
std::string with_length(std::uint32_t tag, std::uint64_t length, const std::string& bytes) {
  std::string field(1, static_cast<char>(tag << 3U | 2U));
  for (; length >= 0x80; length >>= 7U) field += static_cast<char>((length & 0x7FU) | 0x80U);
  return field + static_cast<char>(length) + bytes;
}

void check_all_refused(const std::vector<BadContent>& rows) {
  for (const BadContent& row : rows) {
    INFO(row.id);
    check_refused(row.kind, row.text, [&] { (void)io::parse_onnx(row.file, "a.onnx"); });
  }
}

/// Reads arbitrary bytes: a description, or a FileError of the file.
bool is_accepted(const std::string& bytes) {
  try {
    (void)io::parse_onnx(bytes, "a.onnx");
    return true;
  } catch (const FileError& error) {
    CHECK(error.details().path == "a.onnx");
    return false;
  }
}
}  // namespace

TEST_CASE("files that are no ONNX models are refused", "[io][onnx][bad_input]") {
  check_all_refused({
      {"X01 empty", "", malformed,
       "a.onnx:@0: not an ONNX file; expected a ModelProto of ONNX, found 0 bytes"},
      {"X01 page", "<html><body>Not found</body></html>", malformed,
       "not an ONNX file; expected a ModelProto of ONNX, found an HTML or XML page"},
      {"X01 pointer", "version https://git-lfs.github.com/spec/v1\n", malformed, "found a Git LFS pointer"},
      {"X01 zip", "PK\x03\x04" + std::string(60, '\0'), malformed, "found a zip archive"},
      {"X01 PyTorch",
       "PK\x03\x04" + std::string(22, '\0') + '\x0e' + std::string(3, '\0') + "model/data.pkl" +
           std::string(60, '\0'),
       malformed, "found a PyTorch file; export"},
      {"X01 gzip", "\x1f\x8b\x08" + std::string(60, '\0'), malformed, "found a gzip archive"},
      {"X01 picture", "\x89PNG\r\n\x1a\n" + std::string(60, '\0'), malformed, "found a PNG image"},
      {"X01 text", "a sentence that means nothing to anybody", malformed, "not an ONNX file"},
      {"X01 zeros", std::string(100, '\0'), malformed, "no protobuf field begins here"},
      {"X01 protobuf", bytes_field(1, "x"), malformed, "not an ONNX file"},
      {"X01 other fields", bytes_field(40, "x"), malformed, "no version of the format"},
      {"X01 tensor", onnx::float_tensor("w", {2}, {1, 2}), malformed,
       "field producer_name has another wire type"},
      {"X05 version", changed([](ModelParts& parts) { parts.ir_version = 2; }), malformed,
       "a.onnx:@0: the model: version of the format is too old; expected 3 or more, found 2"},
      {"X05 no opset", changed([](ModelParts& parts) { parts.opsets.clear(); }), malformed,
       "the model: imports no version of ONNX's operators; expected opset 7 to 24"},
      {"X05 other opset", changed([](ModelParts& parts) {
         parts.opsets = {{"ai.onnx.ml", 13}};
       }),
       malformed, "imports no version of ONNX's operators"},
      {"X05 old", with_opset(6), malformed, "not supported; expected opset 7 to 24, found 6"},
      {"X05 new", with_opset(25), malformed, "not supported; expected opset 7 to 24, found 25"},
      {"X05 negative", with_opset(-1), malformed, "expected opset 7 to 24, found -1"},
      {"X05 without version", changed([](ModelParts& parts) {
         parts.opsets.clear();
         parts.more_of_model = bytes_field(8, "");
       }),
       malformed, "expected opset 7 to 24, found 0"},
      {"X06 no graph", integer_field(1, 8) + bytes_field(8, integer_field(2, 13)), malformed,
       "the model: has no graph"},
      {"X06 two graphs", in_model(bytes_field(7, "")), malformed, "the model: two graphs"},
      {"X06 empty", changed([](ModelParts& parts) { parts.nodes.clear(); }), malformed,
       "the graph: has no nodes"},
      {"X06 no outputs", changed([](ModelParts& parts) { parts.outputs.clear(); }), malformed,
       "a.onnx: the graph has no outputs"},
  });
}

TEST_CASE("damaged encodings are refused", "[io][onnx][bad_input]") {
  const std::string overlong(11, '\xff');
  check_all_refused({
      {"X03 graph", integer_field(1, 8) + integer_field(7, 1), malformed,
       "a.onnx:@2: the model: field graph has another wire type; expected bytes with their length, found a "
       "varint"},
      {"X03 name", with_node(node("Relu", {"logits"}, {"more"}, {}, "", integer_field(3, 1))), malformed,
       "node 4: field name has another wire type"},
      {"X03 integer", with_attribute(onnx::attribute("axis", 2, onnx::float_field(3, 1))), malformed,
       "attribute 'axis': field i has another wire type; expected a varint, found four bytes"},
      {"X03 number", with_attribute(onnx::attribute("alpha", 1, onnx::double_field(2, 1))), malformed,
       "field f has another wire type; expected four bytes, found eight bytes"},
      {"X03 list", with_attribute(onnx::attribute("axes", 7, onnx::float_field(8, 1))), malformed,
       "field ints has another wire type"},
      {"X03 elements", with_elements(onnx::float32, {1}, onnx::double_field(4, 1)), malformed,
       "initialiser 2 'w': field float_data has another wire type"},
      {"X03 cut number", with_elements(onnx::float32, {1}, bytes_field(4, "123")), malformed,
       "field float_data is cut; expected a multiple of 4 bytes, found 3 bytes"},
      {"X03 cut varint", with_elements(onnx::int64, {1}, bytes_field(7, "\x80")), malformed,
       "initialiser 2 'w': ends within a field"},
      {"X03 overlong", with_elements(onnx::int64, {1}, bytes_field(7, overlong + '\1')), malformed,
       "a varint is longer than 64 bits"},
      {"X03 overlong tag", in_model(overlong + '\1'), malformed, "a varint is longer than 64 bits"},
      {"X03 group", in_graph("\x0b"), malformed, "the graph: no protobuf field begins here"},
      {"X03 tag 0", in_model(std::string("\0", 1)), malformed, "the model: no protobuf field begins here"},
      {"X03 reserved tag", in_graph(integer_field(18999, 1) + "\xc0\xa3\x09"), malformed,
       "the graph: no protobuf field begins here"},
      {"X04 field", in_graph(with_length(2, 100, "name")), malformed,
       "the graph: what holds it ends within field 2; expected 100 bytes there, found 4"},
      {"X04 file", in_model(with_length(2, 100, "name")), malformed,
       "the model: the file ends within field 2; expected 100 bytes there, found 4"},
      {"X04 33 bits", in_graph(with_length(2, (std::uint64_t(1) << 32U) + 4, "name")), malformed,
       "expected 4294967300 bytes there, found 4"},
      {"X04 64 bits", in_graph(with_length(2, ~std::uint64_t(0), "name")), malformed,
       "expected 18446744073709551615 bytes there, found 4"},
      {"X04 fixed", in_graph(std::string("\x15\0\0", 3)), malformed, "expected 4 bytes there, found 2"},
  });
}

TEST_CASE("inputs, outputs and names that contradict each other are refused", "[io][onnx][bad_input]") {
  const auto typed = [](const std::string& type) {
    return with_input(bytes_field(1, "x") + bytes_field(2, type));
  };
  const std::string no_shape = integer_field(1, 1);
  check_all_refused({
      {"X07 input's name", with_input(bytes_field(2, bytes_field(1, no_shape))), malformed,
       "input 1: has no name"},
      {"X07 output's name", changed([](ModelParts& parts) { parts.outputs.emplace_back(""); }), malformed,
       "output 1: has no name"},
      {"X07 type", with_input(bytes_field(1, "x")), malformed, "input 1 'x': has no type; expected a tensor"},
      {"X07 empty type", typed(""), malformed, "input 1 'x': has no type; expected a tensor"},
      {"X07 sequence", typed(bytes_field(4, "")), malformed, "expected a tensor, found a sequence"},
      {"X07 map", typed(bytes_field(5, "")), malformed, "expected a tensor, found a map"},
      {"X07 sparse", typed(bytes_field(8, "")), malformed, "expected a tensor, found a sparse tensor"},
      {"X07 optional", typed(bytes_field(9, "")), malformed, "expected a tensor, found an optional value"},
      {"X07 shape", typed(bytes_field(1, no_shape)), malformed, "input 1 'x': has no shape"},
      {"X07 two shapes", typed(bytes_field(1, no_shape + bytes_field(2, "") + bytes_field(2, ""))), malformed,
       "two shapes"},
      {"X07 two types", typed(bytes_field(1, no_shape + bytes_field(2, "")) + bytes_field(1, "")), malformed,
       "two types"},
      {"X07 element", with_input(onnx::value("x", onnx::text, {})), malformed,
       "input 1 'x': element type is not supported; expected FLOAT, FLOAT16, BFLOAT16, DOUBLE, BOOL or "
       "integers, "
       "found STRING"},
      {"X07 negative", with_input(onnx::value("x", onnx::float32, {Extent(-2)})), malformed,
       "input 1 'x': negative extent; expected 0 or more, or -1, found -2"},
      {"X07 extents", with_input(onnx::value("x", onnx::float32, {Extent(1 << 24), Extent(1 << 24)})), limit,
       "fewer than 2^48 elements, found [16777216, 16777216]"},
      {"X07 axes", with_input(onnx::value("x", onnx::float32, std::vector<Extent>(33))), limit,
       "input has too many axes; expected at most 32"},
      {"X08 inputs", with_input(onnx::value("picture", onnx::float32, {})), malformed,
       "two inputs 'picture'"},
      {"X08 outputs",
       changed([](ModelParts& parts) { parts.outputs.push_back(onnx::value("logits", onnx::float32, {})); }),
       malformed, "two outputs 'logits'"},
      {"X08 initialisers", with_tensor(onnx::float_tensor("bias", {1}, {1})), malformed,
       "two initialisers 'bias'"},
      {"X08 made twice", with_node(node("Relu", {"logits"}, {"sums"})), malformed,
       "node 4, Relu 'sums': makes value 'sums' again; found node 0, Conv 'stem'"},
      {"X08 makes an input", with_node(node("Relu", {"logits"}, {"picture"})), malformed,
       "makes value 'picture' again; found an input or initialiser"},
      {"X08 within a node", with_node(node("Split", {"logits"}, {"a", "a"})), malformed,
       "makes value 'a' again"},
      {"X09 never", with_node(node("Add", {"logits", "scale"}, {"more"}, {}, "head")), malformed,
       "node 4, Add 'head': reads value 'scale', which is no input, initialiser or output of a node"},
      {"X09 cycle", with_end({node("Add", {"activations", "b"}, {"a"}), node("Neg", {"a"}, {"b", "logits"})}),
       malformed,
       "node 3, Add 'a': reads value 'b', which is made of its own results: a cycle; found node 4, "
       "Neg 'b' as its maker"},
      {"X09 behind a cycle",
       with_end({node("Relu", {"b"}, {"logits"}), node("Neg", {"a"}, {"b"}), node("Neg", {"c"}, {"a"}),
                 node("Neg", {"b"}, {"c"})}),
       malformed, "node 4, Neg 'b': reads value 'a', which is made of its own results: a cycle"},
      {"X09 itself", with_end({node("Neg", {"logits"}, {"logits"})}), malformed,
       "reads value 'logits', which is made of its own results: a cycle; found itself as its maker"},
      {"X09 output", with_end({node("Neg", {"sums"}, {"b"})}), malformed,
       "a.onnx: output 'logits' is made by no node"},
      {"X16 extents", with_input(onnx::value("bias", onnx::float32, {Extent(2)})), ErrorKind::mismatch,
       "input and initialiser 'bias' differ in extents or type; found [1]"},
      {"X16 type", with_input(onnx::value("bias", onnx::int64, {Extent(1)})), ErrorKind::mismatch,
       "input and initialiser 'bias' differ in extents or type"},
      {"X16 axes", with_input(onnx::value("bias", onnx::float32, {})), ErrorKind::mismatch,
       "input and initialiser 'bias' differ in extents or type"},
  });
}

TEST_CASE("nodes and attributes that make no sense are refused", "[io][onnx][bad_input]") {
  const std::string two_values = onnx::float_field(2, 1) + integer_field(3, 1);
  const auto constant = [](const std::vector<std::string>& attributes) {
    return with_node(node("Constant", {}, {"fixed"}, attributes));
  };
  check_all_refused({
      {"X10 no operator", with_node(node("", {"logits"}, {"more"})), malformed,
       "node 4: node without an operator"},
      {"X10 no output", with_node(node("Relu", {"logits"}, {}, {}, "idle")), malformed,
       "node 4, Relu 'idle': node without an output"},
      {"X10 no output's name", with_node(node("Relu", {"logits"}, {""})), malformed,
       "node without an output"},
      {"X10 no name", with_attribute(integer_field(3, 1)), malformed,
       "node 4, Other 'last one': attribute without a name"},
      {"X10 neither type nor value", with_attribute(bytes_field(1, "axis")), malformed,
       "node 4, Other 'last one', attribute 'axis': has neither type nor value"},
      {"X10 two values", with_attribute(onnx::attribute("axis", 2, two_values)), malformed,
       "attribute 'axis' has two values; expected one, found FLOAT and INT"},
      {"X10 other value", with_attribute(onnx::attribute("axis", 2, onnx::float_field(2, 1))), malformed,
       "value does not fit the type; expected INT, found FLOAT"},
      {"X10 unknown type", with_attribute(onnx::attribute("axis", 15, "")), malformed,
       "unknown type; expected 1 to 14, found 15"},
      {"X10 no tensor", with_attribute(onnx::attribute("value", 4, "")), malformed, "tensor is missing"},
      {"X10 tensor",
       with_attribute(
           onnx::tensor_attribute("value", onnx::tensor("t", onnx::int64, {2}, bytes_field(9, "")))),
       malformed, "attribute 'value', tensor 't': raw_data does not fit type and extents"},
      {"X10 twice",
       with_node(node("Other", {"logits"}, {"more"},
                      {onnx::int_attribute("axis", 1), onnx::int_attribute("axis", 2)})),
       malformed, "node 4, Other 'more': two attributes 'axis'"},
      {"X11 no graph", with_attribute(onnx::attribute("body", 5, "")), malformed,
       "node 4, Other 'last one', attribute 'body': graph is missing"},
      {"X11 node of a graph",
       with_attribute(onnx::graph_attribute("body", bytes_field(1, node("", {"logits"}, {"more"})))),
       malformed, "attribute 'body', graph, node 0: node without an operator"},
      {"X11 twice in a graph",
       with_attribute(onnx::graph_attribute("body", bytes_field(1, node("Relu", {"logits"}, {"more"})) +
                                                        bytes_field(1, node("Relu", {"logits"}, {"more"})))),
       malformed, "attribute 'body', graph: makes value 'more' again"},
      {"X11 captured",
       with_attribute(onnx::graph_attribute("body", bytes_field(1, node("Relu", {"nothing"}, {"more"})))),
       malformed, "reads value 'nothing', which is no input, initialiser or output of a node"},
      {"X11 graphs", with_attribute(onnx::attribute("all", 10, bytes_field(11, ""))), malformed,
       "attributes of this type are not supported; found GRAPHS"},
      {"X11 tensors", with_attribute(onnx::attribute("all", 9, bytes_field(10, ""))), malformed,
       "attributes of this type are not supported; found TENSORS"},
      {"X11 sparse", with_attribute(onnx::attribute("value", 11, bytes_field(22, ""))), malformed,
       "attributes of this type are not supported; found SPARSE_TENSOR"},
      {"X11 type", with_attribute(onnx::attribute("type", 13, bytes_field(14, ""))), malformed,
       "attributes of this type are not supported; found TYPE_PROTO"},
      {"X11 function", in_model(bytes_field(25, bytes_field(1, "Relu"))), malformed,
       "functions: function 'Relu' replaces an operator, which is not supported"},
      {"X11 sparse initialiser", in_graph(bytes_field(15, "")), malformed,
       "the graph: sparse initialisers are not supported"},
      {"X11 sparse initialiser of a graph within",
       with_attribute(onnx::graph_attribute("body", bytes_field(15, ""))), malformed,
       "sparse initialisers are not supported"},
      {"X11 segment", with_tensor(bytes_field(3, "") + onnx::float_tensor("w", {1}, {1})), malformed,
       "a tensor in segments is not supported"},
      {"X19 none", constant({}), malformed, "node 4, Constant 'fixed': not one constant"},
      {"X19 two", constant({onnx::int_attribute("value_int", 1), onnx::float_attribute("value_float", 1)}),
       malformed, "value_int, value_ints, found 2 attributes"},
      {"X19 text", constant({onnx::string_attribute("value_string", "a")}), malformed,
       "found attribute 'value_string'"},
      {"X19 other kind", constant({onnx::int_attribute("value", 1)}), malformed, "found attribute 'value'"},
      {"X19 inputs",
       with_node(node("Constant", {"logits"}, {"fixed"}, {onnx::int_attribute("value_int", 1)})), malformed,
       "found inputs"},
      {"X19 outputs", with_node(node("Constant", {}, {"a", "b"}, {onnx::int_attribute("value_int", 1)})),
       malformed, "found 2 outputs"},
  });
  CHECK(is_accepted(in_model(bytes_field(25, bytes_field(1, "Relu") + bytes_field(10, "own")))));
}

TEST_CASE("tensors whose elements do not fit are refused", "[io][onnx][bad_input]") {
  using onnx::floats_field, onnx::integers_field;
  const auto raw = [](std::size_t size) { return bytes_field(9, std::string(size, '\1')); };
  const std::int64_t huge = std::int64_t(1) << 40U;
  check_all_refused({
      {"X13 negative", with_elements(onnx::float32, {2, -1}, raw(8)), malformed,
       "initialiser 2: negative extent; expected 0 or more, found -1"},
      {"X13 wraps", with_elements(onnx::float32, {huge, huge, huge}, raw(4)), limit,
       "initialiser 2 'w': extents are more than any file can hold"},
      {"X13 wraps to 1", with_elements(onnx::float32, {0x7FFFFFFFFFFFFFFF, 0x7FFFFFFFFFFFFFFF}, raw(4)),
       limit, "extents are more than any file can hold"},
      {"X13 0 among huge", with_elements(onnx::float32, {huge, huge, 0}, ""), limit,
       "extents are more than any file can hold"},
      {"X13 axes", with_elements(onnx::float32, std::vector<std::int64_t>(33, 1), raw(4)), limit,
       "tensor has too many axes; expected at most 32"},
      {"X14 file too small", with_elements(onnx::float32, {huge}, raw(4)), malformed,
       "raw_data does not fit type and extents; expected 4398046511104 bytes for FLOAT [1099511627776], "
       "found 4"},
      {"X14 fewer", with_elements(onnx::float32, {2, 3}, raw(20)), malformed,
       "expected 24 bytes for FLOAT [2, 3], found 20"},
      {"X14 more", with_elements(onnx::float16, {3}, raw(8)), malformed,
       "expected 6 bytes for FLOAT16 [3], found 8"},
      {"X14 halves", with_elements(onnx::int4, {3}, raw(1)), malformed,
       "expected 2 bytes for INT4 [3], found 1"},
      {"X14 none", with_elements(onnx::float32, {2}, ""), malformed,
       "initialiser 2 'w': tensor without elements; expected 2 for FLOAT [2], found none"},
      {"X14 fewer floats", with_elements(onnx::float32, {huge}, floats_field(4, {1})), malformed,
       "number of elements does not fit the extents; expected 1099511627776 for FLOAT [1099511627776], found "
       "1"},
      {"X14 more floats", with_elements(onnx::float32, {1}, floats_field(4, {1, 2})), malformed,
       "expected 1 for FLOAT [1], found 2"},
      {"X14 fewer doubles", with_elements(onnx::float64, {2}, onnx::double_field(10, 1)), malformed,
       "expected 2 for DOUBLE [2], found 1"},
      {"X14 fewer integers", with_elements(onnx::int64, {2}, integers_field(7, {1}, Packing::packed)),
       malformed, "expected 2 for INT64 [2], found 1"},
      {"X14 fewer pairs", with_elements(onnx::uint4, {3}, integers_field(5, {1})), malformed,
       "expected 2 for UINT4 [3], found 1"},
      {"X14 elements of none", with_elements(onnx::float32, {0}, raw(4)), malformed,
       "expected 0 bytes for FLOAT [0], found 4"},
      {"X14 two fields", with_elements(onnx::float32, {1}, floats_field(4, {1}) + integers_field(5, {1})),
       malformed, "elements in two fields; expected one, found float_data and int32_data"},
      {"X14 raw and field", with_elements(onnx::float32, {1}, floats_field(4, {1}) + raw(4)), malformed,
       "elements both in raw_data and in a field of their type"},
      {"X14 field of another type", with_elements(onnx::float32, {1}, integers_field(7, {1})), malformed,
       "elements of FLOAT in the field of another type; expected float_data, found int64_data"},
      {"X14 range", with_elements(onnx::int8, {1}, integers_field(5, {128})), malformed,
       "no element of INT8 [1]; expected -128 to 127, found 128"},
      {"X14 range of bits", with_elements(onnx::float16, {1}, integers_field(5, {65536})), malformed,
       "no element of FLOAT16 [1]; expected 0 to 65535, found 65536"},
      {"X14 range of words", with_elements(onnx::uint32, {1}, integers_field(11, {1LL << 32U})), malformed,
       "expected 0 to 4294967295, found 4294967296"},
      {"X15 undefined", with_tensor(integers_field(1, {1}) + bytes_field(8, "w") + raw(4)), malformed,
       "initialiser 2 'w': element type is not supported; expected FLOAT, FLOAT16, BFLOAT16, DOUBLE, BOOL or "
       "integers, found UNDEFINED"},
      {"X15 text", with_elements(onnx::text, {1}, bytes_field(6, "a")), malformed, "found STRING"},
      {"X15 complex", with_elements(onnx::complex64, {1}, raw(8)), malformed, "found COMPLEX64"},
      {"X15 8 bits", with_elements(onnx::float8, {1}, raw(1)), malformed, "found FLOAT8E4M3FN"},
      {"X15 unknown", with_elements(onnx::Type(99), {1}, raw(1)), malformed, "found 99"},
      {"X15 negative", with_elements(onnx::Type(-1), {1}, raw(1)), malformed, "found -1"},
      {"X10 no name", with_tensor(onnx::float_tensor("", {1}, {1})), malformed,
       "initialiser 2: initialiser without a name"},
  });
}

TEST_CASE("a model that is cut anywhere is refused", "[io][onnx][bad_input]") {  // X02
  const std::string good = onnx::model(onnx::small_model());
  REQUIRE(is_accepted(good));
  for (std::size_t length = 0; length < good.size(); ++length) {
    INFO("cut to " << length << " bytes");
    CHECK_FALSE(is_accepted(good.substr(0, length)));
  }
}

TEST_CASE("a tensor's file that is cut anywhere is refused or has fewer fields", "[io][onnx][bad_input]") {
  const test::TemporaryFolder folder;
  const std::string good = onnx::float_tensor("w", {2, 2}, {1, 2, 3, 4});
  for (std::size_t length = 0; length < good.size(); ++length) {
    INFO("cut to " << length << " bytes");
    CHECK_THROWS_AS(io::read_onnx_tensor(folder.write("a.pb", good.substr(0, length))), FileError);
  }
  CHECK(io::read_onnx_tensor(folder.write("a.pb", good)).size() == 4);
}

TEST_CASE("every flipped bit of a model is refused or harmless", "[io][onnx][bad_input]") {
  const std::string good = onnx::model(onnx::small_model());
  std::size_t refused = 0;
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bytes = good;
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
    if (!is_accepted(bytes)) ++refused;
  }
  CHECK(refused > 4 * good.size());  // most bytes are lengths, names and tags
}

TEST_CASE("a model beyond the limits is refused", "[io][onnx][bad_input]") {  // X18
  const std::string good = onnx::model(onnx::small_model());
  std::size_t least = 0;
  const auto parse = [&](std::size_t records) { (void)io::parse_onnx(good, "a.onnx", {.records = records}); };
  for (;; ++least) {
    try {
      parse(least);
      break;
    } catch (const FileError& error) {
      CHECK(error.kind() == limit);
      CHECK_THAT(error.what(), contains("too many nodes, names, attributes and tensors"));
    }
  }
  // 4 nodes, 6 names read and 4 made, 4 attributes, 2 initialisers, 1 input, 1 output
  CHECK(least == 22);
  const test::TemporaryFolder folder;
  const std::string path = folder.write("a.onnx", good);
  check_refused(limit, "file too large", [&] { (void)io::read_onnx(path, {.file_bytes = good.size() - 1}); });
  CHECK(io::read_onnx(path, {.file_bytes = good.size()}).nodes.size() == 3);
}

TEST_CASE("names in messages are cut and cannot steer a terminal", "[io][onnx][bad_input]") {
  const std::string wild = "\x1b[2J" + std::string(5000, 'x');
  try {
    (void)io::parse_onnx(with_node(node(wild, {wild}, {"y"}, {}, wild)), "a.onnx");
    FAIL_CHECK("accepted");
  } catch (const FileError& error) {
    const std::string message = error.what();
    CHECK(message.size() < 400);
    CHECK(message.find('\x1b') == std::string::npos);
  }
}
