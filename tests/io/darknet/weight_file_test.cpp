#include <tapestry/io/darknet/model_file.hpp>

#if defined(__unix__)
#include <sys/stat.h>
#endif

#include "../../support/bad_file.hpp"
#include "../../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;
namespace fs = std::filesystem;

namespace {
constexpr const char* cfg =
    "[net]\nwidth=32\nheight=32\nchannels=3\n"
    "[convolutional]\nfilters=4\nsize=3\nstride=2\npad=1\nbatch_normalize=1\nactivation=leaky\n"
    "[convolutional]\nfilters=18\nsize=1\nactivation=linear\n"
    "[yolo]\nmask=0,1,2\nanchors=10,13, 16,30, 33,23\nclasses=1\nnum=3\n";

struct Model {
  detect::NetworkConfig config = io::parse_network_config(cfg, "some.cfg");
  detect::ParameterLayout layout = detect::parameter_layout(config, detect::infer_shapes(config, 32, 32));
  TemporaryFolder folder{};
  std::string path = folder.path("some.weights");

  [[nodiscard]] std::string good_bytes(std::size_t header = 20) const {
    std::string bytes(header + 4 * layout.count, '\0');
    bytes[4] = header == 20 ? 2 : 1;
    bytes[12] = 77;  // images seen
    for (std::size_t i = 0; i < layout.count; ++i) {
      const float value = 0.01F * static_cast<float>(i % 50 + 1);
      std::memcpy(&bytes[header + 4 * i], &value, 4);
    }
    return bytes;
  }
  void write(const std::string& bytes) const { folder.write("some.weights", bytes); }
  [[nodiscard]] io::WeightFile read(const io::WeightFileOptions& options = {}) const {
    return io::read_weight_file(path, config, layout, options);
  }
};

void put(std::string& bytes, std::size_t element, float value) {
  std::memcpy(&bytes[20 + 4 * element], &value, 4);
}

std::vector<BadFile> rows(const Model& model) {
  using namespace std::string_literals;
  const auto malformed = ErrorKind::malformed;
  const auto good = model.good_bytes();
  const auto with = [&](std::size_t element, float value) {
    std::string bytes = good;
    put(bytes, element, value);
    return bytes;
  };
  auto swapped = good;
  std::swap(swapped[4], swapped[7]);
  auto transposed = good;
  transposed[1] = 8;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  return {
      {"W01", good.substr(0, 20 + 4 * 20), malformed, "@84",
       "weights of layer 0 (convolutional, some.cfg:5)"},
      {"W01 in the biases of the second", good.substr(0, 20 + 4 * 130), malformed, "@516",
       "biases of layer 1"},
      {"W02", good.substr(0, good.size() - 3), malformed, "", "not a multiple of 4"},
      {"W03", "", malformed, "@0", "expected a header of 20 bytes, found 0 bytes"},
      {"W04", good.substr(0, 20), malformed, "@20",
       "expected 16 bytes there and 214 floats in all, found 0 bytes"},
      {"W05", good + std::string(4096, 'x'), ErrorKind::mismatch, "@876", "1024 floats unused"},
      {"W06", std::string(good).append(4 * 196, '\1'), ErrorKind::mismatch, "@876",
       "belong to another cfg than some.cfg"},
      {"W09", transposed, malformed, "@0", "transposed layout"},
      {"W10 neither fits", good + std::string(4, 'x'), ErrorKind::mismatch, "@876",
       "expected 214 floats, found 215"},
      {"W11", swapped, malformed, "@0", "big-endian"},
      {"W12 page", "\n<!DOCTYPE html><html><body>404", malformed, "@0", "HTML"},
      {"W12 pointer", "version https://git-lfs.github.com/spec/v1\noid sha256:", malformed, "@0", "Git LFS"},
      {"W12 gzip", "\x1f\x8b\x08" + good, malformed, "@0", "gzip"},
      {"W12 zip", "PK\x03\x04" + good, malformed, "@0", "zip"},
      {"W12 pickle", "\x80\x02" + good, malformed, "@0", "pickle"},
      {"W12 onnx", "\x08\x07\x12\x0bpytorch1.13" + good, malformed, "@0", "ONNX"},
      {"W12 safetensors", "\x40\0\0\0\0\0\0\0{\"__metadata__\":"s + good, malformed, "@0", "safetensors"},
      {"W13 NaN", with(17, nan), malformed, "@88", "element 1 of the weights of layer 0"},
      {"W13 infinity", with(2, -infinity), malformed, "@28", "element 2 of the biases of layer 0"},
      {"W14", with(13, -0.5F), malformed, "@72", "running variances of layer 0"},
  };
}
}  // namespace

TEST_CASE("damaged weight files are refused with layer and offset", "[io][darknet][bad_input]") {
  const Model model;
  REQUIRE(model.layout.count == 4 * 4 + 4 * 27 + 18 + 72);
  test::check_bad_files(rows(model), model.path, [&](const std::string& bytes) {
    model.write(bytes);
    (void)model.read();
  });
}

TEST_CASE("W01: every length but the right one is refused", "[io][darknet][bad_input]") {
  const Model model;
  const auto good = model.good_bytes();
  for (std::size_t length = 0; length < good.size(); ++length) {
    if (length % 4 != 0 && length > 40 && length + 8 < good.size()) continue;
    model.write(good.substr(0, length));
    CHECK_THROWS_AS(model.read(), FileError);
  }
}

TEST_CASE("W08, W10: both header sizes are read, and the exact size decides", "[io][darknet][weight_file]") {
  const Model model;
  for (const std::size_t header : {std::size_t(16), std::size_t(20)}) {
    for (const char minor : {char(1), char(2)}) {
      auto bytes = model.good_bytes(header);
      bytes[4] = minor;
      model.write(bytes);
      const auto weights = model.read();
      CHECK(weights.images_seen == 77);
      CHECK(weights.parameters.size() == model.layout.count);
      CHECK(weights.parameters(0) == 0.01F);
      CHECK(weights.warnings.empty());
    }
  }
}

TEST_CASE("W05, W13: flags let trailing and non-finite values pass", "[io][darknet][weight_file]") {
  const Model model;
  auto bytes = model.good_bytes() + std::string(4096, 'x');
  put(bytes, 0, std::numeric_limits<float>::quiet_NaN());
  model.write(bytes);
  CHECK_THROWS_AS(model.read({.allow_trailing = true}), FileError);
  CHECK(model.read({.allow_trailing = true, .allow_nonfinite = true}).parameters.size() ==
        model.layout.count);
}

TEST_CASE("W16: a file that changes while it is read is refused", "[io][darknet][bad_input]") {
  const Model model;
  model.write(model.good_bytes());
  const io::RegularFile file(model.path);
  fs::resize_file(model.path, 100);
  std::vector<std::byte> bytes(static_cast<std::size_t>(file.size()));
  CHECK_THROWS_WITH(file.read_at(0, bytes), contains("@100: file ends early"));
}

TEST_CASE("W07, W15: suspicious values are remarked on", "[io][darknet][weight_file]") {
  const Model model;
  auto bytes = model.good_bytes();
  put(bytes, 9, 5e3F);  // a running mean
  put(bytes, 130, 1e-40F);
  for (std::size_t i = 0; i < 72; ++i) put(bytes, model.layout.count - 1 - i, 0);
  model.write(bytes);
  const auto warnings = model.read().warnings;
  REQUIRE(warnings.size() == 3);
  CHECK_THAT(warnings[0], contains("running means of layer 0"));
  CHECK_THAT(warnings[1], contains("denormal"));
  CHECK_THAT(warnings[2], contains("all zero"));
}

#if defined(__unix__)
TEST_CASE("W17, W18: only regular files of a sane size are opened", "[io][darknet][bad_input]") {
  Model model;
  model.path = model.folder.path();
  CHECK_THROWS_WITH(model.read(), contains("folder"));
  model.path = model.folder.path("fifo\nä");
  REQUIRE(::mkfifo(model.path.c_str(), 0600) == 0);
  CHECK_THROWS_WITH(model.read(), contains("not a regular file"));
  model.path = "/dev/zero";
  CHECK_THROWS_WITH(model.read(), contains("not a regular file"));
  model.path = model.folder.path("dangling");
  fs::create_symlink("nowhere", model.path);
  CHECK_THROWS_WITH(model.read(), contains("cannot open"));
  model.path = model.folder.write("sparse", model.good_bytes());
  fs::resize_file(model.path, std::uintmax_t(5) << 30U);
  CHECK_THROWS_WITH(model.read(), contains("too large"));
}
#endif

TEST_CASE("a weight file that is written reads back to the same bits", "[io][darknet][weight_file]") {
  const Model model;
  model.write(model.good_bytes());
  const auto weights = model.read();
  io::write_weight_file(model.path, weights.images_seen + (std::uint64_t(1) << 40U), weights.parameters);
  const auto again = model.read();
  CHECK(again.images_seen == 77 + (std::uint64_t(1) << 40U));
  CHECK(std::ranges::equal(again.parameters, weights.parameters));
  CHECK_THROWS_AS(io::write_weight_file(model.folder.path("no/such"), 0, weights.parameters), FileError);
}
