#include <filesystem>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../../support/onnx_builder.hpp"
#include "../../support/paths.hpp"
#include "../../support/refusal.hpp"

using namespace tapestry;
using namespace tapestry::test;
using onnx::Extent, onnx::ModelParts;

namespace {
/// The small model of a picture [1, 2, 3, 4]: sums and activations are [1, 1, 3, 4], logits [1, 12].
ModelParts small_model() {
  ModelParts parts = onnx::small_model();
  parts.inputs = {onnx::value("picture", onnx::float32, {Extent(1), Extent(2), Extent(3), Extent(4)})};
  parts.outputs = {onnx::value("logits", onnx::float32, {Extent(1), Extent(12)})};
  return parts;
}

/// The small model with this field of value_info.
ModelParts with_value(const std::string& value) {
  ModelParts parts = small_model();
  parts.more_of_graph = onnx::bytes_field(13, value);
  return parts;
}

std::string word_on(const ModelParts& parts) {
  return nn::untrue_shape(io::parse_onnx(onnx::model(parts), "a.onnx")).value_or("");
}
}  // namespace

TEST_CASE("extents that a file states and its nodes contradict are named", "[io][onnx][bad_input]") {  // X26
  ModelParts parts = small_model();
  CHECK(word_on(parts).empty());
  parts.outputs = {onnx::value("logits", onnx::float32, {Extent(1), Extent(13)})};
  CHECK(word_on(parts) == "a.onnx: states [1, 13] for 'logits', which is [1, 12]; this is ignored");
  parts.outputs = {onnx::value("logits", onnx::float32, {Extent("N"), Extent(13)})};
  CHECK(word_on(parts) == "a.onnx: states [?, 13] for 'logits', which is [1, 12]; this is ignored");
  for (const auto& extents : {std::vector<Extent>{}, {Extent(12)}, {Extent(1), Extent(12), Extent()}}) {
    parts.outputs = {onnx::value("logits", onnx::float32, extents)};
    CHECK_THAT(word_on(parts), contains("for 'logits', which is [1, 12]"));
  }
  CHECK(
      word_on(with_value(onnx::value("sums", onnx::float32, {Extent(1), Extent(1), Extent(4), Extent(3)}))) ==
      "a.onnx: states [1, 1, 4, 3] for 'sums', which is [1, 1, 3, 4]; this is ignored");
}

TEST_CASE("of many untrue extents one is named, that of an output, and the others are counted",
          "[io][onnx][bad_input]") {
  ModelParts parts = small_model();
  parts.outputs = {onnx::value("logits", onnx::float32, {Extent(4), Extent(12)})};
  const std::vector<Extent> four{Extent(4), Extent(1), Extent(3), Extent(4)};
  for (const char* name : {"sums", "activations"})
    parts.more_of_graph += onnx::bytes_field(13, onnx::value(name, onnx::float32, four));
  CHECK(word_on(parts) ==
        "a.onnx: states [4, 12] for 'logits', which is [1, 12]; this is ignored, as are the extents of 2 "
        "other values");
}

TEST_CASE("extents that nobody can contradict bring no warning", "[io][onnx]") {
  const auto sums = [](const std::vector<Extent>& extents) {
    return word_on(with_value(onnx::value("sums", onnx::float32, extents)));
  };
  CHECK(sums({Extent(1), Extent(1), Extent(3), Extent(4)}).empty());
  CHECK(sums({Extent("N"), Extent(), Extent(-1), Extent(-7)}).empty());
  CHECK(word_on(with_value(onnx::value("no such", onnx::float32, {Extent(5)}))).empty());
  CHECK(word_on(with_value("")).empty());
  CHECK(word_on(with_value(onnx::bytes_field(1, "sums"))).empty());  // neither type nor extents
  CHECK(word_on(with_value(onnx::value("", onnx::float32, {Extent(5)}))).empty());

  ModelParts parts = with_value(onnx::value("sums", onnx::float32, {Extent(7)}));
  parts.inputs = {onnx::value("picture", onnx::float32, {Extent("N"), Extent(2), Extent(3), Extent(4)})};
  CHECK(word_on(parts).empty());  // stated for another batch, maybe
  parts.inputs = {
      onnx::value("picture", onnx::float32, {Extent(1), Extent(2), Extent(1 << 20), Extent(1 << 20)})};
  CHECK(word_on(parts).empty());  // beyond any memory

  parts = small_model();  // values behind nodes that cannot be run are not known
  parts.nodes.push_back(onnx::node("Other", {"logits"}, {"more"}));
  parts.nodes.push_back(onnx::node("Relu", {"more"}, {"most"}));
  parts.outputs.push_back(onnx::value("most", onnx::float32, {Extent(9)}));
  CHECK(word_on(parts).empty());
  parts.outputs.front() = onnx::value("logits", onnx::float32, {Extent(9)});
  CHECK_THAT(word_on(parts), contains("states [9] for 'logits'"));
}

TEST_CASE("facts about values in between are read as protobuf, or refused", "[io][onnx][bad_input]") {
  check_refused(ErrorKind::malformed, "value_info: field type has another wire type",
                [] { (void)word_on(with_value(onnx::bytes_field(1, "sums") + onnx::integer_field(2, 5))); });
  check_refused(ErrorKind::malformed, "ends within",
                [] { (void)word_on(with_value(onnx::bytes_field(1, "sums") + "\x12\x7f")); });
}

TEST_CASE("models that others exported state true extents", "[io][onnx]") {
  const std::string folder = test::in_shared("data/exports");
  if (is_absent(folder)) return;
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".onnx") continue;
    std::optional<nn::NetworkDescription> network;
    try {
      network = io::read_onnx(entry.path().string());
    } catch (const FileError&) {  // of a version that is not supported
      continue;
    }
    INFO(entry.path());
    CHECK(nn::untrue_shape(*network).value_or("").empty());
    ++count;
  }
  CHECK(count > 10);
}
