#include <tapestry/io/onnx/onnx_file.hpp>

#include "../../support/onnx_builder.hpp"
#include "../../support/refusal.hpp"
#include "../../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;
using onnx::Extent, onnx::ModelParts, onnx::Packing;

namespace {
using Integers = std::vector<std::int64_t>;

nn::NetworkDescription parse(const ModelParts& parts) { return io::parse_onnx(onnx::model(parts), "a.onnx"); }

/// The constant that an initialiser of this tensor becomes, read from a model and from a file of its own.
nn::Constant read_tensor(const std::string& tensor) {
  ModelParts parts = onnx::small_model();
  parts.initialisers.push_back(tensor + onnx::bytes_field(8, "under_test"));
  const nn::Constant constant = parse(parts).constants.at("under_test");
  const test::TemporaryFolder folder;
  const nn::Constant alone = io::read_onnx_tensor(folder.write("a.pb", tensor));
  CHECK(alone.shape == constant.shape);
  CHECK(alone.type == constant.type);
  CHECK(alone.values == constant.values);
  return constant;
}

std::vector<double> elements(const nn::Constant& constant) {
  std::vector<double> all;
  for (std::size_t i = 0; i < constant.size(); ++i) all.push_back(constant.at(i));
  return all;
}

template <class Value>
Value read_attribute(const std::string& attribute) {
  ModelParts parts = onnx::small_model();
  parts.nodes.push_back(onnx::node("Other", {"logits"}, {"more"}, {attribute}));
  return std::get<Value>(parse(parts).nodes.back().attributes.at("under_test"));
}
}  // namespace

TEST_CASE("a network comes back from its file", "[io][onnx]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.write("a.onnx", onnx::model(onnx::small_model()));
  const nn::NetworkDescription network = io::read_onnx(path);
  CHECK(network.path == path);
  CHECK(network.opset == 13);
  REQUIRE(network.inputs.size() == 1);
  CHECK(network.inputs[0].name == "picture");
  CHECK(network.inputs[0].type == nn::ElementType::floating);
  CHECK(network.inputs[0].shape == std::vector<std::optional<std::size_t>>{{}, 2, 3, {}});
  CHECK(network.outputs == std::vector<std::string>{"logits"});

  REQUIRE(network.constants.size() == 3);
  const nn::Constant& weight = network.constants.at("weight");
  CHECK(weight.shape == nn::Shape{1, 2, 1, 1});
  CHECK(weight.type == nn::ElementType::floating);
  CHECK(std::get<std::vector<float>>(weight.values) == std::vector<float>{0.5F, -2.0F});
  CHECK(elements(network.constants.at("bias")) == std::vector<double>{0.25});
  const nn::Constant& extents = network.constants.at("extents");
  CHECK(extents.type == nn::ElementType::integer);
  CHECK(std::get<std::vector<double>>(extents.values) == std::vector<double>{1, -1});

  REQUIRE(network.nodes.size() == 3);
  CHECK(network.nodes[0].name == "stem");
  CHECK(network.nodes[0].operation == "Conv");
  CHECK(network.nodes[0].inputs == std::vector<std::string>{"picture", "weight", "bias"});
  CHECK(network.nodes[0].outputs == std::vector<std::string>{"sums"});
  CHECK(network.nodes[0].attributes.size() == 2);
  CHECK(std::get<Integers>(network.nodes[0].attributes.at("strides")) == Integers{1, 1});
  CHECK(std::get<double>(network.nodes[1].attributes.at("alpha")) == 0.125);
  CHECK(network.nodes[2].operation == "Reshape");
}

TEST_CASE("floats of a tensor are the same numbers in every encoding", "[io][onnx]") {
  const std::vector<float> values = {1.5F, -0.1F, 3e38F, 1e-45F, std::numeric_limits<float>::infinity(),
                                     0.0F};
  const auto fields = {onnx::bytes_field(9, onnx::raw_floats(values)),
                       onnx::floats_field(4, values, Packing::packed), onnx::floats_field(4, values),
                       onnx::floats_field(4, {1.5F, -0.1F}, Packing::packed) +
                           onnx::floats_field(4, {3e38F, 1e-45F}) +
                           onnx::floats_field(4, {values[4], 0.0F}, Packing::packed)};
  for (const std::string& field : fields)
    for (const Packing packing : {Packing::packed, Packing::unpacked}) {
      const nn::Constant constant = read_tensor(onnx::tensor("", onnx::float32, {2, 3}, field, packing));
      CHECK(constant.shape == nn::Shape{2, 3});
      CHECK(std::get<std::vector<float>>(constant.values) == values);
    }
}

TEST_CASE("16-bit floats become floats, exactly", "[io][onnx]") {
  // 1.5, -2, the smallest above 0, the largest, infinity. Source: IEEE 754, binary16.
  const std::vector<std::int64_t> halves = {0x3E00, 0xC000, 0x0001, 0x7BFF, 0x7C00};
  const std::vector<float> half_values = {1.5F, -2.0F, 0x1p-24F, 65504.0F, INFINITY};
  const std::vector<std::int64_t> brains = {0x3FC0, 0xC000, 0x0001, 0x7F7F, 0x7F80};
  const std::vector<float> brain_values = {1.5F, -2.0F, 0x1p-133F, 0x1.FEp127F, INFINITY};
  for (const bool is_half : {true, false}) {
    const auto& bits = is_half ? halves : brains;
    for (const std::string& field : {onnx::bytes_field(9, onnx::raw_integers(bits, 2)),
                                     onnx::integers_field(5, bits, Packing::packed)}) {
      const nn::Constant constant =
          read_tensor(onnx::tensor("", is_half ? onnx::float16 : onnx::bfloat16, {5}, field));
      CHECK(constant.type == nn::ElementType::floating);
      CHECK(std::get<std::vector<float>>(constant.values) == (is_half ? half_values : brain_values));
    }
  }
}

TEST_CASE("doubles stay doubles", "[io][onnx]") {
  const std::vector<double> values = {0.1, -1e300};
  for (const std::string& field :
       {onnx::bytes_field(9, onnx::raw_doubles(values)), onnx::doubles_field(10, values, Packing::packed),
        onnx::doubles_field(10, values)}) {
    const nn::Constant constant = read_tensor(onnx::tensor("", onnx::float64, {2}, field));
    CHECK(constant.type == nn::ElementType::floating);
    CHECK(std::get<std::vector<double>>(constant.values) == values);
  }
}

TEST_CASE("integers of every type become doubles, in every encoding", "[io][onnx]") {
  struct Row {
    onnx::Type type;
    std::size_t size;
    std::uint32_t field;
    std::vector<std::int64_t> values;
  };
  const Row rows[] = {
      {onnx::uint8, 1, 5, {0, 1, 255}},
      {onnx::int8, 1, 5, {-128, -1, 127}},
      {onnx::uint16, 2, 5, {0, 256, 65535}},
      {onnx::int16, 2, 5, {-32768, -1, 32767}},
      {onnx::int32, 4, 5, {-2147483648, -1, 2147483647}},
      {onnx::int64, 8, 7, {-9007199254740992, -1, 9007199254740992}},
      {onnx::uint32, 4, 11, {0, 1, 4294967295}},
      {onnx::uint64, 8, 11, {0, 1, 9007199254740992}},
  };
  for (const Row& row : rows) {
    INFO(row.type);
    for (const std::string& field : {onnx::bytes_field(9, onnx::raw_integers(row.values, row.size)),
                                     onnx::integers_field(row.field, row.values, Packing::packed),
                                     onnx::integers_field(row.field, row.values)}) {
      const nn::Constant constant = read_tensor(onnx::tensor("", row.type, {3}, field));
      CHECK(constant.type == nn::ElementType::integer);
      CHECK(std::get<std::vector<double>>(constant.values) ==
            std::vector<double>(row.values.begin(), row.values.end()));
    }
  }
}

TEST_CASE("negative numbers may be cut to 32 bits, as some writers do", "[io][onnx]") {
  CHECK(elements(read_tensor(onnx::tensor("", onnx::int32, {1}, onnx::integers_field(5, {0xFFFFFFFF})))) ==
        std::vector<double>{-1});
}

TEST_CASE("integers beyond 2^53 are rounded to the nearest double", "[io][onnx]") {  // X20
  const std::int64_t largest = std::numeric_limits<std::int64_t>::max();
  CHECK(elements(read_tensor(onnx::int64_tensor("", {3}, {largest, -largest, 9007199254740993}))) ==
        std::vector<double>{0x1p63, -0x1p63, 9007199254740992.0});
  CHECK(elements(read_tensor(onnx::tensor("", onnx::uint64, {1}, onnx::integers_field(11, {-1})))) ==
        std::vector<double>{0x1p64});
}

TEST_CASE("truth is 0 or 1", "[io][onnx]") {
  for (const std::string& field : {onnx::bytes_field(9, std::string("\0\1\2", 3)),
                                   onnx::integers_field(5, {0, 1, 1}, Packing::packed)}) {
    const nn::Constant constant = read_tensor(onnx::tensor("", onnx::boolean, {3}, field));
    CHECK(constant.type == nn::ElementType::boolean);
    CHECK(elements(constant) == std::vector<double>{0, 1, 1});
  }
}

TEST_CASE("four-bit integers lie two in a byte, the lower half first", "[io][onnx]") {
  for (const std::string& field : {onnx::bytes_field(9, "\xF1\x08"), onnx::integers_field(5, {0xF1, 0x08})}) {
    CHECK(elements(read_tensor(onnx::tensor("", onnx::uint4, {3}, field))) == std::vector<double>{1, 15, 8});
    CHECK(elements(read_tensor(onnx::tensor("", onnx::int4, {3}, field))) == std::vector<double>{1, -1, -8});
  }
}

TEST_CASE("scalars and tensors without elements are read", "[io][onnx]") {
  const nn::Constant scalar = read_tensor(onnx::float_tensor("", {}, {2.0F}));
  CHECK(scalar.shape.empty());
  CHECK(elements(scalar) == std::vector<double>{2});
  for (const std::string& field : {std::string(), onnx::bytes_field(9, "")}) {
    const nn::Constant empty = read_tensor(onnx::tensor("", onnx::float32, {3, 0}, field));
    CHECK(empty.shape == nn::Shape{3, 0});
    CHECK(empty.size() == 0);
  }
}

TEST_CASE("attributes of every kind come back", "[io][onnx]") {
  const std::string name = "under_test";
  CHECK(read_attribute<double>(onnx::float_attribute(name, 0.1F)) == static_cast<double>(0.1F));
  CHECK(read_attribute<std::int64_t>(onnx::int_attribute(name, -3)) == -3);
  CHECK(read_attribute<std::string>(onnx::string_attribute(name, "linear")) == "linear");
  for (const Packing packing : {Packing::packed, Packing::unpacked}) {
    CHECK(read_attribute<std::vector<double>>(onnx::floats_attribute(name, {0.5F, -1.0F}, packing)) ==
          std::vector<double>{0.5, -1.0});
    CHECK(read_attribute<Integers>(onnx::ints_attribute(name, {3, -4}, packing)) == Integers{3, -4});
  }
  CHECK(read_attribute<std::vector<std::string>>(onnx::strings_attribute(name, {"a", ""})) ==
        std::vector<std::string>{"a", ""});
  CHECK(elements(read_attribute<nn::Constant>(onnx::tensor_attribute(
            name, onnx::float_tensor("", {2}, {1.0F, 2.0F})))) == std::vector<double>{1, 2});
}

TEST_CASE("an attribute may leave out a value that is 0 or empty, or its type", "[io][onnx]") {
  const std::string name = "under_test";
  CHECK(read_attribute<double>(onnx::attribute(name, 1, "")) == 0.0);
  CHECK(read_attribute<std::int64_t>(onnx::attribute(name, 2, "")) == 0);
  CHECK(read_attribute<std::string>(onnx::attribute(name, 3, "")).empty());
  CHECK(read_attribute<Integers>(onnx::attribute(name, 7, "")).empty());
  CHECK(read_attribute<std::int64_t>(onnx::bytes_field(1, name) + onnx::integer_field(3, 5)) == 5);
}

TEST_CASE("a node Constant becomes a constant", "[io][onnx]") {
  const auto read = [](const std::string& attribute) {
    ModelParts parts = onnx::small_model();
    parts.nodes.insert(parts.nodes.begin(), onnx::node("Constant", {}, {"fixed"}, {attribute}));
    nn::NetworkDescription network = parse(parts);
    CHECK(network.nodes.size() == 3);
    return network.constants.at("fixed");
  };
  CHECK(elements(read(onnx::float_attribute("value_float", 0.5F))) == std::vector<double>{0.5});
  CHECK(read(onnx::float_attribute("value_float", 0.5F)).shape.empty());
  const nn::Constant floats = read(onnx::floats_attribute("value_floats", {0.5F, 0.1F}));
  CHECK(floats.shape == nn::Shape{2});
  CHECK(std::get<std::vector<float>>(floats.values) == std::vector<float>{0.5F, 0.1F});
  CHECK(read(onnx::int_attribute("value_int", 7)).type == nn::ElementType::integer);
  CHECK(elements(read(onnx::int_attribute("value_int", 7))) == std::vector<double>{7});
  const nn::Constant integers = read(onnx::ints_attribute("value_ints", {1, 2, 3}));
  CHECK(integers.shape == nn::Shape{3});
  CHECK(elements(integers) == std::vector<double>{1, 2, 3});
}

TEST_CASE("an initialiser that is listed as an input is a constant", "[io][onnx]") {  // X16
  ModelParts parts = onnx::small_model();
  parts.inputs.push_back(onnx::value("bias", onnx::float32, {Extent("C")}));
  parts.inputs.push_back(onnx::value("weight", onnx::float32, {Extent(1), Extent(2), Extent(1), Extent(1)}));
  const nn::NetworkDescription network = parse(parts);
  CHECK(network.inputs.size() == 1);
  CHECK(network.constants.size() == 3);
}

TEST_CASE("inputs have the type of their elements, and open extents none", "[io][onnx]") {
  ModelParts parts = onnx::small_model();
  parts.inputs.push_back(onnx::value("index", onnx::int64, {}));
  parts.inputs.push_back(onnx::value("flag", onnx::boolean, {Extent(0), Extent("K"), Extent()}));
  parts.inputs.push_back(onnx::value("half", onnx::float16, {Extent(4)}));
  const nn::NetworkDescription network = parse(parts);
  REQUIRE(network.inputs.size() == 4);
  CHECK(network.inputs[1].type == nn::ElementType::integer);
  CHECK(network.inputs[1].shape.empty());
  CHECK(network.inputs[2].type == nn::ElementType::boolean);
  CHECK(network.inputs[2].shape == std::vector<std::optional<std::size_t>>{0, {}, {}});
  CHECK(network.inputs[3].type == nn::ElementType::floating);
}

TEST_CASE("operators of other domains are named with theirs", "[io][onnx]") {  // X12
  ModelParts parts = onnx::small_model();
  parts.nodes.push_back(onnx::node("Gelu", {"logits"}, {"a"}, {}, "", onnx::domain("com.microsoft")));
  parts.nodes.push_back(onnx::node("Relu", {"a"}, {"b"}, {}, "", onnx::domain("ai.onnx")));
  parts.opsets.emplace_back("com.microsoft", 1);
  const nn::NetworkDescription network = parse(parts);
  CHECK(network.nodes[3].operation == "com.microsoft.Gelu");
  CHECK(network.nodes[4].operation == "Relu");
  CHECK(network.opset == 13);
}

TEST_CASE("of several opsets of ONNX's own domain the highest counts", "[io][onnx]") {
  ModelParts parts = onnx::small_model();
  parts.opsets = {{"", 11}, {"ai.onnx", 17}, {"ai.onnx.ml", 30}};
  CHECK(parse(parts).opset == 17);
  for (const std::int64_t opset : {7, 21}) {
    parts.opsets = {{"", opset}};
    CHECK(parse(parts).opset == opset);
  }
}

TEST_CASE("optional inputs and outputs may be left out", "[io][onnx]") {
  ModelParts parts = onnx::small_model();
  parts.nodes.push_back(onnx::node("Clip", {"logits", "", "bias"}, {"", "clipped"}));
  const nn::NetworkDescription network = parse(parts);
  CHECK(network.nodes.back().inputs == std::vector<std::string>{"logits", "", "bias"});
  CHECK(network.nodes.back().outputs == std::vector<std::string>{"", "clipped"});
}

TEST_CASE("what concerns training or people alone is left out", "[io][onnx]") {  // X21
  ModelParts parts = onnx::small_model();
  parts.more_of_graph = onnx::bytes_field(10, "about") +
                        onnx::bytes_field(13, onnx::value("sums", onnx::text, {})) +
                        onnx::bytes_field(14, onnx::bytes_field(1, "weight")) + onnx::bytes_field(500, "new");
  parts.more_of_model = onnx::bytes_field(14, onnx::bytes_field(1, "author")) +
                        onnx::bytes_field(20, "no training graph") + onnx::float_field(501, 1.0F);
  CHECK(parse(parts).nodes.size() == 3);
}

TEST_CASE("the order of fields makes no difference", "[io][onnx]") {
  ModelParts parts = onnx::small_model();
  const std::string fields = onnx::graph(parts);
  parts.initialisers.clear();
  const std::string rest = onnx::graph(parts);
  ModelParts first;
  first.initialisers = onnx::small_model().initialisers;
  const std::string model = onnx::bytes_field(8, onnx::integer_field(2, 13)) +
                            onnx::bytes_field(7, onnx::graph(first) + rest) + onnx::integer_field(1, 8);
  CHECK(io::parse_onnx(model, "a.onnx").constants.size() == 3);
  const std::string values = onnx::bytes_field(9, onnx::raw_floats({1, 2}));
  CHECK(elements(read_tensor(values + onnx::integer_field(2, 1) + onnx::integers_field(1, {2}))) ==
        std::vector<double>{1, 2});
}

TEST_CASE("nodes out of order are sorted, and else keep the order of the file", "[io][onnx]") {
  ModelParts parts = onnx::small_model();
  parts.nodes.push_back(onnx::node("Relu", {"half"}, {"bent"}));
  parts.nodes.push_back(onnx::node("Neg", {"logits"}, {"other"}));
  parts.nodes.push_back(onnx::node("Cast", {"logits"}, {"half"}, {onnx::int_attribute("to", 10)}));
  parts.nodes.push_back(onnx::node("Abs", {"bent"}, {"last"}));
  parts.outputs.push_back(onnx::value("last", onnx::float32, {}));
  const auto nodes_of = [](const ModelParts& given) {
    std::string names;
    for (const nn::Node& node : parse(given).nodes) names += node.outputs.front() + " ";
    return names;
  };
  const std::string first = nodes_of(onnx::small_model());
  CHECK(nodes_of(parts) == first + "other half bent last ");
  std::ranges::reverse(parts.nodes);
  CHECK(nodes_of(parts) == first + "half other bent last ");
}

TEST_CASE("an extent of -1 is an open one", "[io][onnx]") {
  ModelParts parts = onnx::small_model();
  parts.inputs = {onnx::value("picture", onnx::float32, {Extent(-1), Extent(2), Extent(-1), Extent(4)})};
  CHECK(parse(parts).inputs.front().shape ==
        std::vector<std::optional<std::size_t>>{std::nullopt, 2, std::nullopt, 4});
}

TEST_CASE("a chain of 50,000 nodes is read", "[io][onnx]") {
  ModelParts parts = onnx::small_model();
  const std::string prefix(100, 'v');  // long equal beginnings of names must not make looking them up slow
  std::string last = "logits";
  for (int i = 0; i < 50000; ++i) {
    const std::string next = prefix + std::to_string(i);
    parts.nodes.push_back(onnx::node("Relu", {last}, {next}));
    last = next;
  }
  CHECK(parse(parts).nodes.size() == 50003);
}
