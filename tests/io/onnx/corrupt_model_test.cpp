// Models that are wrong in one way each, read and made into a network that could be run: each is refused with
// one error that names the fault, in bounded time and memory.
#include <tapestry/io/onnx/onnx_file.hpp>

#include <tapestry/core/random.hpp>

#include "../../support/onnx_builder.hpp"
#include "../../support/refusal.hpp"
#include "../../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;
using onnx::changed, onnx::Extent, onnx::ModelParts, onnx::node, onnx::with_tensor;
using Integers = std::vector<std::int64_t>;

namespace {
constexpr auto malformed = ErrorKind::malformed;
constexpr auto mismatch = ErrorKind::mismatch;
constexpr auto limit = ErrorKind::limit;
const std::int64_t huge = std::int64_t(1) << 40U;
const std::int64_t largest = 2147483647;

/// With these nodes, which make "logits" of "activations" [1, 1, 3, 4], in the place of the last one.
std::string ending(const std::vector<std::string>& nodes, const std::vector<std::string>& tensors = {},
                   std::int64_t opset = 13) {
  return changed([&](ModelParts& parts) {
    parts.opsets = {{"", opset}};
    parts.nodes.pop_back();
    parts.nodes.insert(parts.nodes.end(), nodes.begin(), nodes.end());
    parts.initialisers.insert(parts.initialisers.end(), tensors.begin(), tensors.end());
  });
}
/// With one node more, whose further operands are these integers.
std::string ending(const std::string& operation, const std::vector<Integers>& operands,
                   const std::vector<std::string>& attributes = {}, std::int64_t opset = 13) {
  std::vector<std::string> names{"activations"}, tensors;
  for (const Integers& values : operands) {
    names.push_back("k" + std::to_string(names.size()));
    tensors.push_back(onnx::int64_tensor(names.back(), {static_cast<std::int64_t>(values.size())}, values));
  }
  return ending({node(operation, names, {"logits"}, attributes)}, tensors, opset);
}
/// A constant of so many zeros or ones, which takes no bytes of the file.
std::vector<std::string> filled(const std::string& name, const std::string& shape) {
  return {node("ConstantOfShape", {shape}, {name})};
}
std::string with_convolution(const std::vector<std::string>& attributes, const std::string& weights) {
  return changed([&](ModelParts& parts) {
    parts.nodes[0] = node("Conv", {"picture", "weight", "bias"}, {"sums"}, attributes, "stem");
    if (!weights.empty()) parts.initialisers[0] = weights;
  });
}
std::string external(const std::string& location, const std::string& length = "8") {
  return with_tensor(
      onnx::tensor("far", onnx::float32, {2}, onnx::external({{"location", location}, {"length", length}})));
}

std::vector<BadContent> of_the_file() {
  const std::string good = onnx::model(onnx::small_model());
  const auto more = [](const std::string& fields) {
    return changed([&](ModelParts& parts) { parts.nodes.push_back(fields); });
  };
  std::string nested = node("Relu", {"a"}, {"b"});
  for (int depth = 0; depth < 2000; ++depth)
    nested = node("If", {"a"}, {"b"}, {onnx::graph_attribute("then_branch", onnx::bytes_field(1, nested))});
  return {
      {"half of it", good.substr(0, good.size() / 2), malformed, "the file ends within field"},
      {"length beyond the file",
       changed([](ModelParts& parts) { parts.more_of_graph = "\x12\xff\xff\xff\xff\x7f"; }), malformed,
       "bytes there"},
      {"missing initialiser", changed([](ModelParts& parts) { parts.initialisers.pop_back(); }), malformed,
       "node 0, Conv 'stem': reads value 'bias', which is no input, initialiser or output"},
      {"X13 extents whose product wraps", with_tensor(onnx::float_tensor("w", {huge, huge, huge}, {1})),
       limit, "more than any file can hold"},
      {"huge tensor without elements", with_tensor(onnx::tensor("w", onnx::float32, {huge}, "")), malformed,
       "tensor without elements"},
      {"X11 graphs within graphs", more(nested), limit, "graphs within graphs; expected at most 16"},
      {"external path above the folder", external("../far.bin"), malformed, "leaves its folder by '..'"},
      {"external path from the root", external("/etc/hostname"), malformed, "is an absolute path"},
      {"external file that is not there", external("absent.bin"), malformed, "cannot be opened"},
      {"external data beyond its file", external("short.bin", "800"), mismatch, "ends early"},
      {"a megabyte of control characters as a name",
       more(node(std::string(1 << 20U, '\x1b'), {"logits"}, {"x", "x"})), malformed, "again"},
  };
}

std::vector<BadContent> of_nodes() {  // X22
  const std::string ints =
      onnx::tensor("weight", onnx::int64, {1, 2, 1, 1}, onnx::bytes_field(9, onnx::raw_integers({1, 2}, 8)));
  const auto attribute = [](const char* name, const Integers& values) {
    return with_convolution({onnx::ints_attribute(name, values)}, "");
  };
  return {
      {"unknown operator", ending({node("Foo", {"activations"}, {"logits"}, {}, "last")}), mismatch,
       "1 node cannot be run: Foo \"last\" (opset 13): the operator is not supported"},
      {"operator of another domain",
       ending({node("Relu", {"activations"}, {"logits"}, {}, "", onnx::domain("com.x"))}), mismatch,
       "com.x.Relu \"logits\" (opset 13): the operator is not supported"},
      {"operator that steers a terminal", ending({node("\x1b[2J", {"activations"}, {"logits"})}), mismatch,
       "cannot be run: ?[2J \"logits\""},
      {"unknown attribute", ending("Relu", {}, {onnx::int_attribute("speed", 3)}), mismatch,
       "attribute 'speed' is not supported"},
      {"attribute of another type", ending("Elu", {}, {onnx::int_attribute("alpha", 1)}), mismatch,
       "attribute 'alpha' is not a number"},
      {"node without operands", ending({node("Shape", {}, {"logits"})}), mismatch, "0 operands, expected 1"},
      {"weights of integers", with_convolution({}, ints), mismatch,
       "input 1 holds integers, expected floating-point numbers"},
      {"weights of no channels", with_convolution({}, onnx::float_tensor("weight", {1, 0, 1, 1}, {})),
       mismatch, "the weights are empty"},
      {"weights of other channels", with_convolution({}, onnx::float_tensor("weight", {1, 1, 1, 1}, {1})),
       mismatch, "do not fit 2 channels"},
      {"kernel_shape that contradicts the weights", attribute("kernel_shape", {3, 3}), mismatch,
       "'kernel_shape' is [3, 3], but the weights have [1, 1]"},
      {"no groups", with_convolution({onnx::int_attribute("group", 0)}, ""), mismatch,
       "'group' is out of range: 0"},
      {"groups whose channels wrap", with_convolution({onnx::int_attribute("group", -huge)}, ""), mismatch,
       "'group' is out of range"},
      {"stride 0", attribute("strides", {0, 1}), mismatch, "'strides' is out of range: 0"},
      {"negative padding", attribute("pads", {0, 0, -1, 0}), mismatch, "'pads' is out of range: -1"},
      {"padding of terabytes", attribute("pads", {huge, 0, 0, 0}), mismatch, "'pads' is out of range"},
      {"dilation of terabytes", attribute("dilations", {huge, 1}), mismatch, "'dilations' is out of range"},
      {"three strides", attribute("strides", {1, 1, 1}), mismatch, "has 3 values, expected 2"},
      {"window larger than the picture",
       ending("MaxPool", {}, {onnx::ints_attribute("kernel_shape", {5, 5})}), mismatch, "does not fit into"},
      {"operands of two types",
       ending({node("Add", {"activations", "k"}, {"logits"})}, {onnx::int64_tensor("k", {1}, {1})}), mismatch,
       "input 1 holds integers, expected floating-point numbers"},
      {"operands that do not go together",
       ending({node("Add", {"activations", "k"}, {"logits"})}, {onnx::float_tensor("k", {3}, {1, 2, 3})}),
       mismatch, "do not go together"},
      {"indices of floats",
       ending({node("Gather", {"activations", "k"}, {"logits"})}, {onnx::float_tensor("k", {1}, {0})}),
       mismatch, "input 1 holds floating-point numbers, expected integers"},
      {"index out of range",
       ending({node("Gather", {"bias", "k"}, {"logits"})}, {onnx::int64_tensor("k", {1}, {7})}), mismatch,
       "index 7"},
      {"axis out of range", ending("Softmax", {}, {onnx::int_attribute("axis", 9)}), mismatch, "axis 9 of 4"},
      {"axis named twice", ending("Transpose", {}, {onnx::ints_attribute("perm", {0, 0, 1, 2})}), mismatch,
       "not a permutation"},
      {"parts that are more than the whole", ending("Split", {{3, 9}}), mismatch, "12 of 1"},
      {"parts without end", ending("Split", {}, {onnx::int_attribute("num_outputs", huge)}, 18), mismatch,
       "num_outputs is 1099511627776 of a node with 1 results"},
      {"step 0", ending("Slice", {{0}, {1}, {0}, {0}}), mismatch, "a step is 0"},
      {"boxes without a number",
       ending({node("NonMaxSuppression", {"boxes", "activations", "k"}, {"logits"})},
              {onnx::float_tensor("boxes", {1, 1, 4}, {0, 0, 1, 1}), onnx::int64_tensor("k", {0}, {})}),
       mismatch, "input 2 has 0 elements, expected 1"},
  };
}

std::vector<BadContent> of_extents() {  // X23, X24, X25
  const std::vector<std::string> scalar{node("Squeeze", {"bias"}, {"scalar"})};
  const auto of_scalar = [&](const std::string& last, const std::vector<std::string>& tensors) {
    return ending({scalar.front(), last}, tensors, 18);
  };
  std::vector<std::string> many_unknown, growing, growing_shapes;
  for (int i = 0; i < 20000; ++i) many_unknown.push_back(node("Foo", {"activations"}, {std::to_string(i)}));
  many_unknown.push_back(node("Relu", {"activations"}, {"logits"}));
  for (int i = 0; i < 100; ++i) {
    growing.push_back(filled("grown" + std::to_string(i), "k").front());
    growing.push_back(node("Neg", {"grown" + std::to_string(i)}, {"turned" + std::to_string(i)}));
  }
  growing.push_back(node("Relu", {"activations"}, {"logits"}));
  const auto tensor = [](const char* name, const Integers& values) {
    return onnx::int64_tensor(name, {static_cast<std::int64_t>(values.size())}, values);
  };
  return {
      // 60 · 5581 · 8681 · 49477 · 384773 = 3 · 2⁶⁴ + 12, for 12 elements
      {"shape that overflows to what is there", ending("Reshape", {{60, 5581, 8681, 49477, 384773}}),
       mismatch, "a tensor [60, 5581, 8681, 49477, 384773] is too large"},
      {"negative extent", ending("Reshape", {{-5, -1}}), mismatch, "extent -5, expected 0 to 2147483647"},
      {"two open extents", ending("Reshape", {{-1, -1}}), mismatch, "extent -1"},
      {"extent beyond 31 bits", ending("Reshape", {{huge}}), mismatch, "extent 1099511627776"},
      {"extents of floats",
       ending({node("Reshape", {"activations", "k"}, {"logits"})}, {onnx::float_tensor("k", {1}, {12})}),
       mismatch, "input 1 holds floating-point numbers, expected integers"},
      {"extents that are computed",
       ending({node("Cast", {"activations"}, {"k"}, {onnx::int_attribute("to", 7)}),
               node("Reshape", {"activations", "k"}, {"logits"})}),
       mismatch, "input 1 is computed"},
      {"forty axes", ending("Reshape", {Integers(40, 1)}), mismatch, "a tensor of 40 axes"},
      {"a hundred thousand axes",
       ending(
           {node("Range", {"from", "to", "by"}, {"k"}), node("Unsqueeze", {"activations", "k"}, {"logits"})},
           {onnx::int64_tensor("from", {}, {0}), onnx::int64_tensor("to", {}, {100000}),
            onnx::int64_tensor("by", {}, {1})}),
       mismatch, "has 100000 elements, expected at most 1024"},
      {"constant of terabytes",
       ending({filled("c", "k").front(), node("Relu", {"activations"}, {"logits"})},
              {tensor("k", {largest, largest})}),
       mismatch, "a tensor [2147483647, 2147483647] is too large"},
      {"constant whose size wraps to 0",
       ending({filled("c", "k").front(), node("Relu", {"activations"}, {"logits"})},
              {tensor("k", {65536, 65536, 65536, 65536})}),
       mismatch, "is too large"},
      {"constant of gigabytes",
       ending({filled("c", "k").front(), node("Relu", {"activations"}, {"logits"})},
              {tensor("k", {largest})}),
       mismatch, "a constant result [2147483647] is too large"},
      {"constants that are gigabytes together", ending(growing, {tensor("k", {1 << 20})}), mismatch,
       "a constant result [1048576] is too large"},
      {"expanded beyond any memory", ending("Expand", {{largest, largest, 1, 1, 3, 4}}), mismatch,
       "is too large"},
      {"tiled beyond any memory", ending("Tile", {{largest, largest, 1, 1}}), mismatch, "is too large"},
      {"tiles whose count wraps", ending("Tile", {{65536, 65536, 65536, 65536}}), mismatch, "is too large"},
      {"range without end",
       ending(
           {node("Range", {"zero", "one", "zero"}, {"k"}), node("Reshape", {"activations", "k"}, {"logits"})},
           {onnx::int64_tensor("zero", {}, {0}), onnx::int64_tensor("one", {}, {1})}),
       mismatch, "a range of inf elements"},
      {"padded by terabytes", ending("Pad", {{0, 0, huge, 0, 0, 0, 0, 0}}), mismatch,
       "pads are out of range"},
      {"reflected too often",
       ending("Pad", {{0, 0, 1 << 14, 1 << 14, 0, 0, 0, 0}}, {onnx::string_attribute("mode", "reflect")}),
       mismatch, "pads repeat the tensor too often"},
      {"a scalar that is padded",
       of_scalar(node("Pad", {"scalar", "k", "", "zero"}, {"logits"}),
                 {tensor("k", {1, 1}), tensor("zero", {0})}),
       mismatch, "a scalar has no axes"},
      {"a scalar that is resized",
       of_scalar(node("Resize", {"scalar", "", "k"}, {"logits"}, {onnx::ints_attribute("axes", {0})}),
                 {onnx::float_tensor("k", {1}, {2})}),
       mismatch, "of a scalar"},
      {"resized beyond any memory", ending("Resize", {{}, {}, {1, 1, huge, huge}}), mismatch,
       "after resizing"},
      {"an axis that is resized twice",
       ending({node("Resize", {"activations", "", "k"}, {"logits"}, {onnx::ints_attribute("axes", {2, 2})})},
              {onnx::float_tensor("k", {2}, {2, 2})}, 18),
       mismatch, "is named twice"},
      {"a range to read that is no number",  // whose coordinates would be indices
       ending(
           {node("Resize", {"activations", "roi", "", "k"}, {"logits"},
                 {onnx::string_attribute("coordinate_transformation_mode", "tf_crop_and_resize")})},
           {onnx::float_tensor("roi", {8}, {0, 0, 0, std::nanf(""), 1, 1, 1, 1}), tensor("k", {1, 1, 3, 4})}),
       mismatch, "lies at nan among the inputs; roi is nan to 1"},
      {"a range to read without an end",
       ending({node("Resize", {"activations", "roi", "", "k"}, {"logits"},
                    {onnx::string_attribute("coordinate_transformation_mode", "tf_crop_and_resize")})},
              {onnx::float_tensor("roi", {8}, {0, 0, 0, 0, 1, 1, std::numeric_limits<float>::infinity(), 1}),
               tensor("k", {1, 1, 3, 4})}),
       mismatch, "among the inputs; roi is 0.000000 to inf"},
      {"an index from an infinity",
       ending({node("Cast", {"k"}, {"end"}, {onnx::int_attribute("to", 7)}),
               node("Slice", {"activations", "zero", "end"}, {"logits"})},
              {onnx::float_tensor("k", {1}, {std::numeric_limits<float>::infinity()}), tensor("zero", {0})}),
       mismatch, "an integer is inf"},
      {"a scale that is no number",
       ending({node("Resize", {"activations", "", "k"}, {"logits"})},
              {onnx::float_tensor("k", {4}, {1, 1, -2, 1})}),
       mismatch, "a scale is -2"},
      {"more matrices than memory",
       ending({filled("a", "k").front(), filled("b", "m").front(), node("MatMul", {"a", "b"}, {"logits"})},
              {tensor("k", {65536, 1, 1, 1}), tensor("m", {65536, 1, 1})}),
       mismatch, "more than 1048576 matrices"},
      {"more boxes than can be compared",
       ending({filled("a", "k").front(), filled("b", "m").front(),
               node("NonMaxSuppression", {"a", "b", "n"}, {"logits"})},
              {tensor("k", {1, 100000, 4}), tensor("m", {1, 1, 100000}), tensor("n", {100000})}),
       mismatch, "100000 constant boxes are too many"},
      {"input beyond any memory", changed([](ModelParts& parts) {
         parts.inputs = {
             onnx::value("picture", onnx::float32, {Extent(1), Extent(2), Extent(1 << 20), Extent(1 << 20)})};
       }),
       limit, "input 'picture': a tensor [1, 2, 1048576, 1048576] is too large"},
      {"input of an open size", changed([](ModelParts& parts) {
         parts.inputs = {onnx::value("picture", onnx::float32, {Extent("N"), Extent(2), Extent(), Extent()})};
       }),
       mismatch, "has an open extent at axis 2"},
      {"thousands of nodes that cannot be run", ending(many_unknown), mismatch, "20000 nodes cannot be run"},
  };
}

/// Reads a model and makes the network that it describes, at 3 × 4 pixels where the last extent is open.
void make_network(const std::string& bytes, const std::string& path) {
  const nn::NetworkDescription description = io::parse_onnx(bytes, path);
  std::map<std::string, nn::Shape> shapes;
  for (const nn::InputDescription& input : description.inputs)
    if (input.shape.size() == 4 && input.shape[2] == 3 && !input.shape[3])
      shapes[input.name] = {1, input.shape[1].value_or(2), 3, 4};
  const nn::Network<float> network(description, shapes);
}

double peak_mib() { return platform::process_cost().peak_mib; }
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }
}  // namespace

TEST_CASE("each of many corruptions of a small model is one clear error, in bounded time and memory",
          "[io][onnx][network][bad_input]") {  // X01 to X25
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("models"));
  folder.write("models/short.bin", "1234");
  const std::string path = folder.write("models/a.onnx", "");
  folder.write("far.bin", "12345678");
  make_network(onnx::model(onnx::small_model()), path);
  std::vector<BadContent> all = of_the_file();
  for (const auto& table : {of_nodes(), of_extents()}) all.insert(all.end(), table.begin(), table.end());
  CHECK(all.size() >= 40);
  for (const BadContent& corruption : all) {
    INFO(corruption.id);
    const double memory = peak_mib(), start = cpu_seconds();
    try {
      make_network(corruption.file, path);
      FAIL_CHECK("was accepted; expected '" << corruption.text << "'");
    } catch (const Error& error) {
      const std::string message = error.what();
      CAPTURE(message.substr(0, 2000));
      CHECK(static_cast<int>(error.kind()) == static_cast<int>(corruption.kind));
      CHECK(message.find(corruption.text) != std::string::npos);
      CHECK(message.size() < 20000);
      CHECK(std::ranges::none_of(message, [](char c) { return c == '\x1b'; }));
    }
    // Folded constants have 32 MiB and a few times that on the way; a sanitizer keeps what was freed for a
    // while.
    CHECK(peak_mib() - memory < 2500);
    CHECK(cpu_seconds() - start < 20);
  }
}

TEST_CASE("a model of many operators with a flipped bit is refused, or runs",
          "[io][onnx][network][bad_input]") {
  const std::string good = onnx::model(onnx::model_of_many());
  Random random(3);
  std::size_t refused = 0;
  for (std::size_t byte = 0; byte <= good.size(); ++byte) {  // the last one as it is
    std::string bytes = good;
    if (byte < good.size()) bytes[byte] = static_cast<char>(bytes[byte] ^ (1 << random.index(8)));
    INFO("byte " << byte);
    try {
      const nn::Network<float> network(io::parse_onnx(bytes, "a.onnx"));
      std::vector<nn::Buffer<float>> values;
      std::vector<const float*> inputs;
      for (std::size_t i = 0; i < network.input_count(); ++i) {
        values.emplace_back(nn::size_of(network.input_shape(i)));
        std::fill_n(values.back().data(), values.back().size(), 0.5F);
        inputs.push_back(values.back().data());
      }
      nn::NetworkPass<float> pass;
      network.forward(inputs, pass, nn::Mode::input_gradient);
      CHECK(network.output_count() >= 1);
    } catch (const Error& error) {
      ++refused;
      CHECK(byte < good.size());
      CHECK(std::string(error.what()).size() < 20000);
    }
  }
  CHECK(refused > good.size() / 2);
}

TEST_CASE("a node of a model with an operand too many or too few is refused by name",
          "[io][onnx][network][bad_input]") {
  // ONNX's least and most numbers of operands, of the nodes of model_of_many() at opset 13.
  const std::vector<std::pair<std::size_t, std::size_t>> counts{
      {2, 3}, {5, 5}, {2, 2}, {1, 1}, {1, 4}, {2, 3}, {1, 99}, {3, 5}, {1, 1},
      {1, 1}, {2, 3}, {1, 1}, {2, 2}, {2, 2}, {2, 2}, {1, 1},  {2, 2}, {2, 2}};
  const nn::NetworkDescription good = io::parse_onnx(onnx::model(onnx::model_of_many()), "a.onnx");
  REQUIRE(good.nodes.size() == counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i)
    for (std::size_t count = 0; count <= 8; ++count) {
      nn::NetworkDescription changed = good;
      auto& inputs = changed.nodes[i].inputs;
      inputs.resize(count, inputs.front());
      CAPTURE(changed.nodes[i].operation, count);
      const std::string complaint =
          nn::label_of(changed.nodes[i]) + " (opset 13): " + std::to_string(count) + " operands, expected ";
      std::string message;
      try {
        const nn::Network<float> network(changed);
      } catch (const Error& error) {
        message = error.what();
      }
      const bool fits = count >= counts[i].first && count <= counts[i].second;
      CHECK((message.find(complaint) == std::string::npos) == fits);
    }
}

TEST_CASE("a chain of thousands of nodes becomes a network in time", "[io][onnx][network][bad_input]") {
  ModelParts parts = onnx::small_model();
  std::string last = "logits";
  for (int i = 0; i < 6000; ++i) {
    const std::string next = "v" + std::to_string(i);
    parts.nodes.push_back(
        node(i % 3 == 0   ? "Identity"
             : i % 3 == 1 ? "Sigmoid"
                          : "Mul",
             i % 3 == 2 ? std::vector{last, "v" + std::to_string(i - 2)} : std::vector{last}, {next}));
    last = next;
  }
  parts.outputs = {onnx::value(last, onnx::float32, {})};
  const double start = cpu_seconds();
  const nn::Network<float> network(io::parse_onnx(onnx::model(parts), "a.onnx"), {{"picture", {1, 2, 3, 4}}});
  CHECK(network.output_shape(0) == nn::Shape{1, 12});
  CHECK(cpu_seconds() - start < 20);
}
