#include "../support/old_detector.hpp"

#include "../support/bad_file.hpp"
#include "../support/random_model.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;

namespace {
struct OldFile {
  test::TemporaryFolder folder{};
  std::string text = test::relatives_layers;
  detect::DarknetModel<float> model =
      test::random_model<float>(io::parse_network_config(text, "some.cfg"), 3);
  std::string path = folder.path("old.safetensors");

  void refused(ErrorKind kind, const std::string& message, const std::string& bytes) const {
    INFO(message);
    folder.write("old.safetensors", bytes);
    test::check_refused(kind, message, [&] { (void)shell::read_old_detector(path); });
  }
};
}  // namespace

TEST_CASE("a detector of an earlier release is read with its bits", "[programs]") {
  const OldFile old;
  const auto header = test::old_header(old.model, old.text);
  CHECK(header.at("layers.0.weight").at("shape") == nlohmann::json{16, 3, 3, 3});
  CHECK(header.at("layers.4.bias").at("dtype") == "F32");
  old.folder.write("old.safetensors", test::old_detector(old.model, old.text));
  const auto [model, cfg] = shell::read_old_detector(old.path);
  CHECK(cfg == old.text);
  CHECK(model.parameters() == old.model.parameters());
  CHECK(model.images_seen() == old.model.images_seen());
}

TEST_CASE("N15, N16: detectors of earlier releases that are damaged are refused", "[programs][bad_input]") {
  const OldFile old;
  const auto good = test::old_header(old.model, old.text);
  const std::string numbers = test::old_numbers(old.model);
  const auto malformed = ErrorKind::malformed, mismatch = ErrorKind::mismatch;
  const std::string passes =
      "old.safetensors:@0: header passes the end of the file, or 16 MiB; expected 1 to ";
  old.refused(malformed, passes + "0 bytes", "");
  old.refused(malformed, passes + "0 bytes", "\x09\x02{}");
  old.refused(malformed, passes + "2 bytes, found 0 bytes", std::string(8, '\0') + "{}");
  old.refused(malformed, passes + "2 bytes, found 3 bytes", std::string("\3\0\0\0\0\0\0\0{}", 10));
  old.refused(malformed, passes + "2 bytes, found 18446744073709551615 bytes", std::string(8, '\xFF') + "{}");
  old.refused(malformed, "old.safetensors:@9: not valid JSON", test::old_file("{"));
  old.refused(malformed, "key given twice", test::old_file(R"({"a": 1, "a": 1})"));
  old.refused(malformed, "old.safetensors:@", test::old_file(R"({"a": [[[[1]]]]})"));
  for (const char* header : {"[]", "1", "{}", R"({"__metadata__": 1})", R"({"__metadata__": {"cfg": 1}})"})
    old.refused(malformed, "@8: not the header of a detector", test::old_file(header));
  old.refused(mismatch, "metadata field 'format' is missing", test::old_file(R"({"__metadata__": {}})"));

  const auto with = [&](const std::string& pointer, const nlohmann::json& value) {
    auto header = good;
    header[nlohmann::json::json_pointer(pointer)] = value;
    return test::old_file(header.dump(), numbers);
  };
  const std::string first = "tensor 'layers.0.bn.bias' is not that of", weights = "/layers.1.weight/";
  old.refused(malformed, "'cfg' does not have its hash", with("/__metadata__/cfg", old.text + "\n"));
  old.refused(mismatch, first, with("/layers.0.bn.bias/dtype", "F16"));
  old.refused(mismatch, first, with("/layers.0.bn.bias", "text"));
  old.refused(mismatch, first, with("/layers.0.bn.bias/more", 1));
  old.refused(mismatch, "\"shape\":[5,5,1,16]", with(weights + "shape", {5, 5, 1, 16}));
  old.refused(mismatch, "tensor 'layers.1.weight' is not that of", with(weights + "data_offsets", {0, 1600}));
  old.refused(mismatch, "tensor 'layers.1.weight' is not that of", with(weights + "data_offsets", {-4, 1}));
  old.refused(mismatch, "tensors of no layer; expected 19, found 20", with("/extra", 1));
  auto header = good;
  header.erase("layers.0.bn.bias");
  old.refused(mismatch, first, test::old_file(header.dump(), numbers));

  for (const std::string& other : {numbers.substr(4), numbers + "1234"})
    old.refused(mismatch, "another size than that of its tensors", test::old_file(good.dump(), other));
  auto infinite = old.model;
  infinite.parameters()[3] = HUGE_VALF;
  old.refused(malformed, "old.safetensors: weights that are not finite",
              test::old_detector(infinite, old.text));
}
