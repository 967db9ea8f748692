#include <tapestry/io/onnx/onnx_file.hpp>

#include "../../support/onnx_builder.hpp"
#include "../../support/refusal.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
std::string bytes_with(const std::string& initialiser) {
  auto parts = onnx::small_model();
  parts.initialisers[0] = initialiser;
  return onnx::model(parts);
}

void check_values(const std::string& bytes, const std::string& name, const std::vector<double>& expected) {
  const auto network = io::parse_onnx(bytes, "net.onnx");
  const auto& constant = network.constants.at(name);
  REQUIRE(constant.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(constant.at(i) == expected[i]);
}
}  // namespace

TEST_CASE("weights are replaced where they are, all other bytes stay", "[io][onnx][weight_replacement]") {
  auto parts = onnx::small_model();  // weights in raw_data, the bias in a packed field, of a node Constant
  parts.initialisers.pop_back();
  parts.nodes.insert(
      parts.nodes.begin(),
      onnx::node("Constant", {}, {"bias"},
                 {onnx::tensor_attribute(
                     "value", onnx::tensor("elsewhere", onnx::float32, {1},
                                           onnx::floats_field(4, {0.25F}, onnx::Packing::packed)))}));
  parts.more_of_model =
      onnx::bytes_field(14, onnx::bytes_field(1, "author") + onnx::bytes_field(2, "nobody"));
  const std::string bytes = onnx::model(parts);
  const std::string changed =
      io::with_weights(bytes, "net.onnx", {{"weight", {3.0F, -0.125F}}, {"bias", {8.0F}}});
  check_values(changed, "weight", {3, -0.125});
  check_values(changed, "bias", {8});
  REQUIRE(changed.size() == bytes.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) different += bytes[i] != changed[i];
  CHECK(different <= 12);  // three floats
  CHECK(io::with_weights(changed, "net.onnx", {{"weight", {0.5F, -2.0F}}, {"bias", {0.25F}}}) == bytes);
  CHECK(io::with_weights(bytes, "net.onnx", {}) == bytes);
}

TEST_CASE("weights that cannot be replaced are refused by name", "[io][onnx][weight_replacement]") {
  const auto replace = [](const std::string& bytes, std::vector<float> values, const char* name = "weight") {
    (void)io::with_weights(bytes, "net.onnx", {{name, std::move(values)}});
  };
  const std::string sound = onnx::model(onnx::small_model());
  check_refused(ErrorKind::mismatch,
                "weights 'other' cannot be replaced; expected an initialiser or a node Constant with a "
                "tensor, found none",
                [&] {
                  replace(sound, {1, 2}, "other");
                });
  check_refused(ErrorKind::mismatch,
                "weights 'extents' cannot be replaced; expected elements of FLOAT, found INT64", [&] {
                  replace(sound, {1, 2}, "extents");
                });
  check_refused(ErrorKind::mismatch, "weights 'weight' cannot be replaced; expected 3 elements, found 2",
                [&] {
                  replace(sound, {1, 2, 3});
                });
  const auto half = onnx::tensor("weight", onnx::float16, {1, 2, 1, 1},
                                 onnx::bytes_field(9, onnx::raw_integers({0x3800, 0x3C00}, 2)));
  check_refused(ErrorKind::mismatch, "expected elements of FLOAT, found FLOAT16", [&] {
    replace(bytes_with(half), {1, 2});
  });
  const auto elsewhere =
      onnx::tensor("weight", onnx::float32, {1, 2, 1, 1}, onnx::external({{"location", "w.bin"}}));
  check_refused(ErrorKind::mismatch, "'weight' has its elements in another file", [&] {
    replace(bytes_with(elsewhere), {1, 2});
  });
  const auto scattered =
      onnx::tensor("weight", onnx::float32, {1, 2, 1, 1}, onnx::floats_field(4, {1.0F, 2.0F}));
  check_refused(ErrorKind::mismatch, "expected elements in one piece within the file, found 0", [&] {
    replace(bytes_with(scattered), {1, 2});
  });
  check_refused(ErrorKind::malformed, "", [&] { replace(sound.substr(0, sound.size() / 2), {1, 2}); });
}

TEST_CASE("weights that nodes have moved are the file's again, unless some of them are not read",
          "[io][onnx][weight_replacement]") {
  nn::NetworkDescription network;
  network.opset = 13;
  network.inputs = {{"x", {1, 2}}};
  network.constants["w"] = {{4, 2}, nn::ElementType::floating, std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8}};
  for (const auto& [name, value] : std::map<std::string, double>{{"0", 0}, {"2", 2}, {"4", 4}})
    network.constants[name] = {{1}, nn::ElementType::integer, std::vector<double>{value}};
  network.nodes = {{"", "Slice", {"w", "0", "2", "0"}, {"first"}, {}},
                   {"", "Slice", {"w", "2", "4", "0"}, {"second"}, {}},
                   {"", "Transpose", {"first"}, {"turned"}, {}},
                   {"", "MatMul", {"x", "turned"}, {"a"}, {}},
                   {"", "MatMul", {"x", "second"}, {"b"}, {}}};
  network.outputs = {"a", "b"};
  const auto values = io::weight_values(nn::Network<float>(network, {}, false, false));
  CHECK(values == io::WeightValues{{"w", {1, 2, 3, 4, 5, 6, 7, 8}}});
  network.nodes[4].inputs[1] = "first";  // as many elements, but half of them twice
  CHECK_THROWS_WITH(io::weight_values(nn::Network<float>(network, {}, false, false)),
                    "weights 'w': 4 of them are not used");
}
