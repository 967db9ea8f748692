#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/file_source.hpp>

#include <nlohmann/json.hpp>

#include "../support/bad_file.hpp"
#include "../support/catch.hpp"
#include "../support/random_array.hpp"
#include "../support/random_model.hpp"
#include "../support/refusal.hpp"
#include "../support/safetensors_bytes.hpp"
#include "../support/temporary_folder.hpp"

namespace detect = tapestry::detect;
namespace io = tapestry::io;
using tapestry::ErrorKind;
using tapestry::test::BadFile;
using tapestry::test::check_refused;
using tapestry::test::TemporaryFolder;

namespace {
/// A detector as Darknet files and, once convert() has been called, as a converted file.
struct Model {
  std::string text = tapestry::test::relatives_layers;
  TemporaryFolder folder{};
  std::string cfg = folder.write("some.cfg", text);
  std::string weights = folder.path("some.weights");
  std::string converted = folder.path("some.safetensors");
  detect::DarknetModel<float> network =
      tapestry::test::random_model<float>(io::parse_network_config(text, "some.cfg"), 3);

  Model() {
    network.set_images_seen((std::uint64_t(1) << 40U) + 5);
    io::write_weight_file(weights, network);
  }
  void convert(bool is_folded = false) const {
    io::write_detector_file(converted, {text, network.images_seen(), is_folded}, network.parameters(), cfg);
  }
};

bool same_bits(const tapestry::Array<float, 1>& a, const tapestry::Array<float, 1>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 4 * a.size()) == 0;
}

/// The logits of all heads for one picture of noise, in one list.
template <class T>
std::vector<T> logits_of(const detect::DarknetModel<T>& network, std::uint64_t seed) {
  const tapestry::Array<T, 4> images =
      tapestry::test::random_array<T>({1, network.input_height(), network.input_width(), 3}, seed);
  detect::Pass<T> pass;
  network.detector().forward(images, pass);
  std::vector<T> logits;
  for (const auto& head : pass.logits) logits.insert(logits.end(), head.data(), head.data() + head.size());
  return logits;
}

/// The tensors and the metadata of a converted file, to be changed and written again.
struct Parts {
  std::map<std::string, std::string> metadata{};
  std::vector<io::NamedShape> tensors{};
  std::vector<float> values{};

  explicit Parts(const std::string& path) {
    const io::SafetensorsFile file(path);
    metadata = file.metadata();
    for (const auto& tensor : file.tensors()) tensors.push_back({tensor.name, tensor.shape});
    for (const auto& tensor : file.tensors()) {
      const std::size_t begin = values.size();
      values.resize(begin + tensor.size());
      file.read(tensor, std::span(values).subspan(begin));
    }
  }
  void write(const std::string& path) const { io::write_safetensors(path, metadata, tensors, values); }
};

/// Each number as its upper half, rounded towards zero.
std::string as_bf16(const std::string& file) {
  const std::size_t header = 8 + (std::size_t(static_cast<unsigned char>(file[0])) |
                                  std::size_t(static_cast<unsigned char>(file[1])) << 8U);
  std::string text = file.substr(8, header - 8);
  for (std::size_t at = 0; (at = text.find("\"F32\"", at)) != std::string::npos;)
    text.replace(at, 5, "\"BF16\"");
  std::string halved;
  for (std::size_t at = 0; at < text.size();) {  // offsets become half of what they were
    const std::string key = "\"data_offsets\":[";
    const std::size_t next = text.find(key, at);
    if (next == std::string::npos) {
      halved += text.substr(at);
      break;
    }
    const std::size_t comma = text.find(',', next);
    const std::size_t end = text.find(']', next);
    const auto half = [&](std::size_t from, std::size_t to) {
      return std::to_string(std::stoull(text.substr(from, to - from)) / 2);
    };
    halved += text.substr(at, next - at) + key + half(next + key.size(), comma) + "," + half(comma + 1, end);
    at = end;
  }
  std::string bytes;
  for (std::size_t i = 0; i < 8; ++i) bytes += static_cast<char>(halved.size() >> (8 * i) & 0xFFU);
  bytes += halved;
  for (std::size_t at = header; at < file.size(); at += 4) bytes += file.substr(at + 2, 2);
  return bytes;
}
}  // namespace

TEST_CASE("a converted detector has the bits of its weights", "[io][detector_file]") {
  const Model model;
  model.convert();
  const io::DetectorFile file(model.converted);
  CHECK(file.metadata().cfg == model.text);
  CHECK(file.config().batch_norm_epsilon == 1e-5);
  CHECK(file.warnings().empty());
  CHECK(same_bits(file.parameters<float>(model.network.config(), model.network.layout()),
                  model.network.parameters()));

  const auto loaded = io::read_darknet_model<float>("", model.converted);
  CHECK(loaded.warnings.empty());
  CHECK(same_bits(loaded.model.parameters(), model.network.parameters()));
  io::write_weight_file(model.folder.path("again.weights"), loaded.model);
  CHECK(model.folder.read("again.weights") == model.folder.read("some.weights"));
  const auto darknet = model.folder.read("some.weights");
  const auto converted = model.folder.read("some.safetensors");
  CHECK(converted.substr(converted.size() - (darknet.size() - 20)) == darknet.substr(20));
}

TEST_CASE("tensors are named and shaped as other tools expect", "[io][detector_file]") {
  const Model model;
  const auto tensors = io::detector_tensors(model.network.config(), model.network.layout());
  const auto shape_of = [&](const std::string& name) {
    for (const auto& tensor : tensors)
      if (tensor.name == name) return tensor.shape;
    return std::vector<std::size_t>();
  };
  using Shape = std::vector<std::size_t>;
  CHECK(shape_of("layers.0.weight") == Shape{16, 3, 3, 3});
  CHECK(shape_of("layers.1.weight") == Shape{16, 1, 5, 5});  // depthwise
  CHECK(shape_of("layers.2.weight") == Shape{24, 4, 3, 3});  // four groups
  for (const char* name : {"bn.weight", "bn.bias", "bn.running_mean", "bn.running_var"})
    CHECK(shape_of("layers.2." + std::string(name)) == Shape{24});
  CHECK(shape_of("layers.2.bias").empty());
  CHECK(shape_of("layers.4.bias") == Shape{24});
  CHECK(tensors.size() == 3 * 5 + 2 * 2);
}

TEST_CASE("a folded detector answers as the one it was made from", "[io][detector_file]") {
  const Model model;
  model.convert(true);
  const auto loaded = io::read_darknet_model<float>("", model.converted);
  CHECK(Parts(model.converted).tensors.size() == 5 * 2);
  for (const auto& layer : loaded.model.config().layers) CHECK_FALSE(layer.batch_normalize);
  // Inference folds as fold_batch_norm() does, in double and rounded once, so float keeps every bit.
  CHECK(logits_of(loaded.model, 5) == logits_of(model.network, 5));
  // In double the folded weights carry that one rounding, 2⁻²⁴ of each, through five convolutions in turn.
  const auto kept = logits_of(model.network.cast<double>(), 5);
  const auto folded = logits_of(loaded.model.cast<double>(), 5);
  REQUIRE(folded.size() == kept.size());
  double largest = 0;
  double difference = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    largest = std::max(largest, std::abs(kept[i]));
    difference = std::max(difference, std::abs(kept[i] - folded[i]));
  }
  CHECK(difference <= 5 * 0x1p-20 * largest);  // 16 for sums of unlike signs
  CHECK(difference > 0);
}

TEST_CASE("the epsilon is the converted file's, kept or folded", "[io][detector_file]") {
  const Model model;
  io::write_detector_file(model.converted, {model.text, 0, false, 1e-3}, model.network.parameters(),
                          model.cfg);
  const auto kept = io::read_darknet_model<float>(model.cfg, model.converted);
  CHECK(kept.model.config().batch_norm_epsilon == 1e-3);
  CHECK(kept.warnings.empty());
  io::write_detector_file(model.converted, {model.text, 0, true, 1e-3}, model.network.parameters(),
                          model.cfg);
  const auto folded = io::read_darknet_model<float>("", model.converted);
  CHECK(logits_of(folded.model, 1) == logits_of(kept.model, 1));
  CHECK(logits_of(folded.model, 1) != logits_of(model.network, 1));
}

TEST_CASE("the decode family is the converted file's, kept or folded", "[io][detector_file]") {
  const Model model;
  for (const auto decode : {detect::DecodeFamily::darknet, detect::DecodeFamily::ultralytics})
    for (const bool is_folded : {false, true}) {
      io::write_detector_file(model.converted, {model.text, 0, is_folded, 1e-5, decode},
                              model.network.parameters(), model.cfg);
      CHECK(io::DetectorFile(model.converted).metadata().decode == decode);
      CHECK(Parts(model.converted).metadata.at("decode") == detect::name_of(decode));
      for (const auto& cfg : {std::string(), model.cfg}) {
        const auto loaded = io::read_darknet_model<float>(cfg, model.converted, 0, 0, decode);
        CHECK(loaded.warnings.empty());
        const auto resized = loaded.model.resized(96, 96);
        const auto cast = loaded.model.cast<double>();
        for (const auto& heads : {loaded.model.heads(), resized.heads(), cast.heads()})
          for (const auto& head : heads) CHECK(head.decode == decode);
        CHECK(io::read_darknet_model<float>(cfg, model.converted).model.heads()[0].decode == decode);
      }
    }
  check_refused(
      ErrorKind::mismatch,
      "some.safetensors: is of the decode family ultralytics, which contradicts the requested darknet",
      [&] { (void)io::read_darknet_model<float>("", model.converted, 0, 0, detect::DecodeFamily::darknet); });
}

TEST_CASE("Darknet weights have the decode family that is asked for, or that their cfg means",
          "[io][network_file]") {
  using detect::DecodeFamily;
  const Model model;
  const auto family = [&](const std::string& cfg, const std::string& weights,
                          std::optional<DecodeFamily> asked) {
    return io::read_darknet_model<float>(cfg, weights, 0, 0, asked).model.heads()[0].decode;
  };
  CHECK(family(model.cfg, model.weights, {}) == DecodeFamily::darknet);
  CHECK(family(model.cfg, model.weights, DecodeFamily::ultralytics) == DecodeFamily::ultralytics);

  Model scaled;
  scaled.text.replace(scaled.text.rfind("activation=linear"), 17, "activation=logistic");
  const auto doubled = scaled.folder.write("doubled.cfg", scaled.text);
  const auto loaded = io::read_darknet_model<float>(doubled, scaled.weights);
  REQUIRE(loaded.warnings.size() == 1);
  CHECK_THAT(loaded.warnings[0],
             contains("doubled.cfg:50: decode family darknet takes the logistic function of "
                      "outputs of activation=logistic"));
  CHECK(io::read_darknet_model<float>(doubled, scaled.weights, 0, 0, DecodeFamily::scaled).warnings.empty());

  const auto said = scaled.folder.write("said.cfg", scaled.text + "new_coords=1\n");
  CHECK(family(said, scaled.weights, {}) == DecodeFamily::scaled);
  CHECK(family(said, scaled.weights, DecodeFamily::scaled) == DecodeFamily::scaled);
  const std::string contradiction =
      "said.cfg:50: layer 8 (yolo): new_coords=1 contradicts the requested decode family; expected scaled, "
      "found ";
  check_refused(ErrorKind::mismatch, contradiction + "darknet",
                [&] { (void)family(said, scaled.weights, DecodeFamily::darknet); });

  io::write_detector_file(scaled.converted, {scaled.text, 0, true, 1e-5, DecodeFamily::scaled},
                          scaled.network.parameters(), doubled);
  CHECK(family("", scaled.converted, {}) == DecodeFamily::scaled);
  CHECK(family(said, scaled.converted, {}) == DecodeFamily::scaled);
  CHECK(io::read_darknet_model<float>("", scaled.converted).warnings.empty());
  io::write_detector_file(scaled.converted, {scaled.text, 0, true, 1e-5, DecodeFamily::ultralytics},
                          scaled.network.parameters(), doubled);
  check_refused(ErrorKind::mismatch, contradiction + "ultralytics",
                [&] { (void)family(said, scaled.converted, {}); });
  check_refused(ErrorKind::mismatch, contradiction + "darknet", [&] {
    io::write_detector_file(scaled.converted, {scaled.text + "new_coords=1\n"}, scaled.network.parameters(),
                            said);
  });
}

TEST_CASE("folding a filter by hand", "[detect][fold]") {
  const std::string text =
      "[net]\nwidth=32\nheight=32\nchannels=3\n[convolutional]\nfilters=18\nsize=1\nbatch_normalize=1\n"
      "activation=linear\n[yolo]\nmask=0,1,2\nanchors=1,1, 2,2, 3,3\nclasses=1\nnum=3\n";
  auto config = io::parse_network_config(text, "some.cfg");
  config.batch_norm_epsilon = 1;
  const auto layout = detect::parameter_layout(config, detect::infer_shapes(config, 32, 32));
  auto parameters = tapestry::zeros<float, 1>({layout.count});
  const auto& own = layout.layers[0];
  parameters[own.bias + 2] = 7;
  parameters[own.scale + 2] = 6;
  parameters[own.mean + 2] = 5;
  parameters[own.variance + 2] = 8;  // f = 6 / √(8 + 1) = 2
  parameters[own.weight + 2 * 3 + 1] = -4;
  const auto folded = detect::fold_batch_norm(config, layout, parameters);
  REQUIRE(folded.size() == 18 + 18 * 3);
  CHECK(folded[2] == 7 - 2 * 5);
  CHECK(folded[18 + 2 * 3 + 1] == -8);
  parameters[own.scale + 2] = 3e38F;
  check_refused(ErrorKind::numeric, "layer 0",
                [&] { (void)detect::fold_batch_norm(config, layout, parameters); });
}

TEST_CASE("W19: half precision is widened, double narrowed with a remark, any order of tensors is put right",
          "[io][detector_file]") {
  const Model model;
  model.convert();
  const auto good = model.folder.read("some.safetensors");
  model.folder.write("some.safetensors", as_bf16(good));
  const auto loaded = io::read_darknet_model<float>("", model.converted);
  CHECK(loaded.warnings.empty());
  for (std::size_t i = 0; i < loaded.model.parameters().size(); ++i) {
    const float exact = model.network.parameters()[i];
    const float difference = std::abs(loaded.model.parameters()[i] - exact);
    if (!(difference <= std::abs(exact) / 128)) FAIL_CHECK("parameter " << i);
  }

  model.folder.write("some.safetensors", good);
  Parts parts(model.converted);
  const auto first = 16;  // of the first two tensors, layers.0.bn.bias and .bn.weight
  std::swap(parts.tensors[0], parts.tensors[1]);
  std::rotate(parts.values.begin(), parts.values.begin() + first, parts.values.begin() + 2 * first);
  parts.write(model.converted);
  CHECK(same_bits(io::read_darknet_model<float>("", model.converted).model.parameters(),
                  model.network.parameters()));
}

TEST_CASE("W19: double is narrowed with a remark", "[io][detector_file]") {
  const Model model;
  model.convert();
  const Parts parts(model.converted);
  nlohmann::json header{{"__metadata__", parts.metadata}};
  std::size_t at = 0;
  for (const auto& tensor : parts.tensors) {
    std::size_t end = 8;
    for (const auto extent : tensor.shape) end *= extent;
    end += at;
    header[tensor.name] = {{"dtype", "F64"}, {"shape", tensor.shape}, {"data_offsets", {at, end}}};
    at = end;
  }
  const std::vector<double> wide(parts.values.begin(), parts.values.end());
  model.folder.write("some.safetensors",
                     tapestry::test::safetensors_bytes(
                         header.dump(), {reinterpret_cast<const char*>(wide.data()), 8 * wide.size()}));
  const auto loaded = io::read_darknet_model<float>("", model.converted);
  REQUIRE(loaded.warnings.size() == 1);
  CHECK_THAT(loaded.warnings[0], contains("19 tensors of F64 were rounded to F32"));
  CHECK(same_bits(loaded.model.parameters(), model.network.parameters()));
}

TEST_CASE("W19, W20: converted detectors that do not fit are refused", "[io][detector_file][bad_input]") {
  const Model model;
  model.convert();
  const Parts good(model.converted);
  const auto refused = [&](ErrorKind kind, const std::string& message,
                           const std::function<void(Parts&)>& change) {
    INFO(message);
    Parts parts = good;
    change(parts);
    parts.write(model.converted);
    check_refused(kind, message, [&] { (void)io::read_darknet_model<float>("", model.converted); });
  };
  const auto mismatch = ErrorKind::mismatch;
  const auto with = [](const std::string& key, const std::string& value) {
    return [=](Parts& parts) { parts.metadata[key] = value; };
  };
  refused(mismatch, "metadata field 'decode' is missing; expected darknet, ultralytics or scaled",
          [](Parts& parts) { parts.metadata.erase("decode"); });
  for (const char* decode : {"yolov5", "", "Darknet", "darknet ", "yolox"})
    refused(mismatch,
            "metadata field 'decode' is not supported; expected darknet, ultralytics or scaled, found '" +
                std::string(decode) + "'",
            with("decode", decode));
  refused(mismatch,
          "some.safetensors:cfg:50: layer 8 (yolo): decode family scaled (new_coords=1) needs activations, "
          "not logits",
          with("decode", "scaled"));
  refused(mismatch, "metadata field 'format' is missing", [](Parts& parts) { parts.metadata.clear(); });
  refused(mismatch, "metadata field 'format' is not supported", with("format", "pt"));
  for (const char* field : {"cfg", "cfg_sha256", "batch_norm", "images_seen", "batch_norm_epsilon"})
    refused(mismatch, "metadata field '" + std::string(field) + "' is missing",
            [&](Parts& parts) { parts.metadata.erase(field); });
  refused(ErrorKind::malformed, "'cfg' does not have its hash", with("cfg", model.text + "\n"));
  refused(ErrorKind::malformed, "expected kept or folded, found 'maybe'", with("batch_norm", "maybe"));
  refused(ErrorKind::malformed, "metadata field 'images_seen' makes no sense", with("images_seen", "-1"));
  for (const char* epsilon : {"", "0", "-1e-5", "nan", "inf", "1e-5 ", "1e999"})
    refused(ErrorKind::malformed, "metadata field 'batch_norm_epsilon' makes no sense",
            with("batch_norm_epsilon", epsilon));
  refused(ErrorKind::malformed, "some.safetensors:cfg:1:", [](Parts& parts) {
    parts.metadata["cfg"] = "nonsense";
    parts.metadata["cfg_sha256"] = io::sha256("nonsense");
  });
  refused(mismatch, "tensor 'layers.0.bias' is missing", with("batch_norm", "folded"));
  refused(mismatch, "tensor 'layers.0.bn.bias' is missing, which",
          [](Parts& parts) { parts.tensors[0].name = "layers.0.bn.beta"; });
  refused(mismatch, "tensor 'extra': not a part of the network", [](Parts& parts) {
    parts.tensors.push_back({"extra", {2}});
    parts.values.insert(parts.values.end(), 2, 0);
  });
  refused(mismatch,
          "tensor 'layers.1.weight': axes in another order; weights are [filters, channels, row, "
          "column]; expected (16, 1, 5, 5), found (5, 5, 1, 16)",
          [](Parts& parts) {
            parts.tensors[9].shape = {5, 5, 1, 16};
          });
  refused(mismatch,
          "some.safetensors:cfg needs; expected (16, 1, 5, 5), found "
          "(16, 25)",
          [](Parts& parts) {
            parts.tensors[9].shape = {16, 25};
          });
  refused(ErrorKind::malformed, "element 3 of tensor 'layers.0.bn.bias'; expected a finite float",
          [](Parts& parts) { parts.values[3] = std::numeric_limits<float>::infinity(); });
  refused(ErrorKind::malformed,
          "element 1 of tensor 'layers.0.bn.running_var'; expected a variance of at least 0",
          [](Parts& parts) { parts.values[3 * 16 + 1] = -1; });

  good.write(model.converted);
  auto bytes = model.folder.read("some.safetensors");
  bytes.replace(bytes.find("\"F32\""), 5, "\"I32\"");
  model.folder.write("some.safetensors", bytes);
  check_refused(mismatch,
                "tensor 'layers.0.bn.bias': not floating point; expected F32, F64, F16 or BF16, found I32",
                [&] { (void)io::read_darknet_model<float>("", model.converted); });
}

TEST_CASE("read_darknet_model tells the two kinds of file apart", "[io][network_file]") {
  const Model model;
  model.convert();
  const auto parameters = model.network.parameters();
  CHECK(same_bits(io::read_darknet_model<float>(model.cfg, model.weights).model.parameters(), parameters));
  CHECK(same_bits(io::read_darknet_model<float>(model.cfg, model.converted).model.parameters(), parameters));
  const auto renamed = model.folder.write("renamed.weights", model.folder.read("some.safetensors"));
  const auto loaded = io::read_darknet_model<float>("", renamed, 96, 128);
  CHECK(same_bits(loaded.model.parameters(), parameters));
  CHECK(loaded.model.images_seen() == model.network.images_seen());
  CHECK(loaded.model.input_height() == 96);
  CHECK(loaded.model.input_width() == 128);
  check_refused(ErrorKind::usage, "need their cfg",
                [&] { (void)io::read_darknet_model<float>("", model.weights); });
  const auto misnamed = model.folder.write("misnamed.safetensors", model.folder.read("some.weights"));
  check_refused(ErrorKind::malformed, "misnamed.safetensors",
                [&] { (void)io::read_darknet_model<float>(model.cfg, misnamed); });
  check_refused(ErrorKind::malformed, "cannot open",
                [&] { (void)io::read_darknet_model<float>("", model.folder.path("absent.safetensors")); });
}

TEST_CASE("another cfg beside a converted detector is used with a remark, or refused", "[io][network_file]") {
  const Model model;
  model.convert();
  const auto wider = model.folder.write("wider.cfg", "# wider\n" + model.text);
  const auto loaded = io::read_darknet_model<float>(wider, model.converted);
  REQUIRE(loaded.warnings.size() == 1);
  CHECK_THAT(loaded.warnings[0], contains("wider.cfg: differs from the cfg inside"));
  const auto other = model.folder.write("other.cfg", tapestry::test::common_layers);
  check_refused(ErrorKind::mismatch, "other.cfg",
                [&] { (void)io::read_darknet_model<float>(other, model.converted); });
}

TEST_CASE("write_detector_file refuses what it could not read again", "[io][detector_file]") {
  const Model model;
  const auto write = [&](const std::string& cfg, std::size_t count) {
    io::write_detector_file(model.converted, {cfg}, tapestry::zeros<float, 1>({count}), "some.cfg");
  };
  check_refused(ErrorKind::malformed, "some.cfg:@2: not UTF-8", [&] { write("# \xE9\n" + model.text, 1); });
  check_refused(ErrorKind::malformed, "some.cfg:1", [&] { write("nonsense", 1); });
  check_refused(ErrorKind::mismatch, "parameters is [1]", [&] { write(model.text, 1); });
  CHECK_FALSE(std::filesystem::exists(model.converted));
}

TEST_CASE("a model takes its parameters at once", "[detect][darknet_model]") {
  const Model model;
  auto parameters = model.network.parameters();
  const detect::DarknetModel<float> network(model.network.config(), parameters, 96, 128);
  CHECK(network.input_width() == 128);
  CHECK(same_bits(network.parameters(), model.network.parameters()));
  parameters.resize({parameters.size() - 1});
  check_refused(ErrorKind::mismatch, "DarknetModel: parameters is [",
                [&] { (void)detect::DarknetModel<float>(model.network.config(), parameters); });
}

TEST_CASE("a bad value is found wherever it stands in a large tensor", "[io][detector_file][bad_input]") {
  const TemporaryFolder folder;
  const std::string text =
      "[net]\nwidth=32\nheight=32\nchannels=3\n[convolutional]\nfilters=4000\nsize=1\nactivation=linear\n"
      "[convolutional]\nfilters=18\nsize=1\nactivation=linear\n"
      "[yolo]\nmask=0,1,2\nanchors=1,1, 2,2, 3,3\nclasses=1\nnum=3\n";
  detect::DarknetModel<float> network(io::parse_network_config(text, "some.cfg"));
  const auto path = folder.path("some.safetensors");
  const std::size_t begin = network.layout().layers[1].weight;
  for (const std::size_t at : {0U, 1U, 32767U, 32768U, 65535U, 71999U}) {
    network.parameters()[begin + at] = std::numeric_limits<float>::quiet_NaN();
    io::write_detector_file(path, {text}, network.parameters(), "some.cfg");
    network.parameters()[begin + at] = 0;
    const auto size = std::filesystem::file_size(path);
    const auto place = "@" + std::to_string(size - 4 * (72000 - at)) + ": element " + std::to_string(at) +
                       " of tensor 'layers.1.weight'; expected a finite float, found ";
    check_refused(ErrorKind::malformed, place, [&] { (void)io::read_darknet_model<float>("", path); });
  }
}

TEST_CASE("W16: a converted detector that is cut once its header is read is refused",
          "[io][detector_file][bad_input]") {
  const Model model;
  model.convert();
  const io::DetectorFile file(model.converted);
  const auto refused = [&](std::uintmax_t size, const std::string& message) {
    std::filesystem::resize_file(model.converted, size);
    check_refused(ErrorKind::malformed, "some.safetensors:" + message,
                  [&] { (void)file.parameters<float>(model.network.config(), model.network.layout()); });
  };
  const auto whole = std::filesystem::file_size(model.converted);
  const std::string cut =
      " file changed while it was read; expected " + std::to_string(whole) + " bytes, found ";
  refused(whole - 1, cut + std::to_string(whole - 1));
  refused(whole / 2, cut + std::to_string(whole / 2));
  refused(0, "@" + std::to_string(whole - 4 * model.network.layout().count) +
                 ": file ends early; expected 64 more bytes, found none");
}
