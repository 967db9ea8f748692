#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/random_array.hpp"
#include "../support/random_model.hpp"
#include "../support/refusal.hpp"
#include "../support/relative_distance.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// A detector as Darknet files and, once convert() has been called, as a converted file.
struct Model {
  std::string text = test::relatives_layers;
  TemporaryFolder folder{};
  std::string cfg = folder.write("some.cfg", text);
  std::string weights = folder.path("some.weights"), converted = folder.path("some.onnx");
  detect::DarknetModel<float> network =
      test::random_model<float>(io::parse_network_config(text, "some.cfg"), 3);

  Model() {
    network.set_images_seen((std::uint64_t(1) << 40U) + 5);
    io::write_weight_file(weights, network);
  }
  /// \returns the number of nodes
  std::size_t convert(bool is_folded = false, double epsilon = 1e-5,
                      detect::DecodeFamily decode = detect::DecodeFamily::darknet) const {
    const auto parameters = network.parameters();
    auto config = detect::with_decode(io::parse_network_config(text, cfg), decode);
    config.batch_norm_epsilon = epsilon;
    detect::DarknetModel<float> model =
        is_folded ? detect::DarknetModel<float>(detect::without_batch_norm(config),
                                                detect::fold_batch_norm(config, network.layout(), parameters))
                  : detect::DarknetModel<float>(config, parameters);
    model.set_images_seen(network.images_seen());
    return io::write_detector_file(converted, model, text);
  }
};

bool same_bits(const Array<float, 1>& a, const Array<float, 1>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 4 * a.size()) == 0;
}

/// The logits of all heads for one picture of noise, in one list.
template <class T>
std::vector<T> logits_of(const detect::DarknetModel<T>& network, std::uint64_t seed) {
  const Array<T, 4> images =
      test::random_array<T>({1, network.input_height(), network.input_width(), 3}, seed);
  std::vector<T> logits;
  for (const auto& head : detect::forward(network.detector(), images))
    logits.insert(logits.end(), head.data(), head.data() + head.size());
  return logits;
}
}  // namespace

TEST_CASE("a converted detector has the bits of its weights", "[io][detector_file]") {
  const Model model;
  const std::size_t nodes = model.convert();
  const auto network = io::read_onnx(model.converted);
  CHECK(network.nodes.size() == nodes);
  CHECK(network.outputs.size() == model.network.heads().size());
  CHECK(io::is_of_darknet(network));
  const auto metadata = io::parse_detector_metadata(network.metadata, model.converted);
  CHECK(metadata.cfg == model.text);
  CHECK(metadata.batch_norm_epsilon == 1e-5);
  CHECK_FALSE(metadata.is_folded);

  const auto loaded = io::read_darknet_model<float>("", model.converted);
  CHECK(loaded.warnings.empty());
  CHECK(same_bits(loaded.model.parameters(), model.network.parameters()));
  io::write_weight_file(model.folder.path("again.weights"), loaded.model);
  CHECK(model.folder.read("again.weights") == model.folder.read("some.weights"));
}

TEST_CASE("a folded detector answers as the one it was made from", "[io][detector_file]") {
  const Model model;
  model.convert(true);
  const auto loaded = io::read_darknet_model<float>("", model.converted);
  CHECK(loaded.model.layout().blocks.size() == 5 * 2);
  for (const auto& layer : loaded.model.config().layers) CHECK_FALSE(layer.batch_normalize);
  // Inference folds as fold_batch_norm() does, in double and rounded once, so float keeps every bit.
  CHECK(logits_of(loaded.model, 5) == logits_of(model.network, 5));
  // In double, only the folded weights' rounding, 2⁻²⁴ of each, goes through five convolutions.
  const auto kept = logits_of(model.network.cast<double>(), 5);
  const auto folded = logits_of(loaded.model.cast<double>(), 5);
  const double largest = test::largest_difference(kept, std::vector<double>(kept.size()));
  const double difference = test::largest_difference(kept, folded);
  CHECK(difference <= 5 * 0x1p-20 * largest);  // 16 for sums of unlike signs
  CHECK(difference > 0);
}

TEST_CASE("the epsilon is the converted file's, kept or folded", "[io][detector_file]") {
  const Model model;
  model.convert(false, 1e-3);
  const auto kept = io::read_darknet_model<float>(model.cfg, model.converted);
  CHECK(kept.model.config().batch_norm_epsilon == 1e-3);
  CHECK(kept.warnings.empty());
  model.convert(true, 1e-3);
  const auto folded = io::read_darknet_model<float>("", model.converted);
  CHECK(logits_of(folded.model, 1) == logits_of(kept.model, 1));
  CHECK(logits_of(folded.model, 1) != logits_of(model.network, 1));
}

TEST_CASE("the decode family is the converted file's, kept or folded", "[io][detector_file]") {
  const Model model;
  for (const auto decode : {detect::DecodeFamily::darknet, detect::DecodeFamily::ultralytics})
    for (const bool is_folded : {false, true}) {
      model.convert(is_folded, 1e-5, decode);
      CHECK(io::read_onnx(model.converted).metadata.at("decode") == detect::name_of(decode));
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
      "some.onnx: is of the decode family ultralytics, which contradicts the requested darknet",
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

  scaled.convert(true, 1e-5, DecodeFamily::scaled);
  CHECK(family("", scaled.converted, {}) == DecodeFamily::scaled);
  CHECK(family(said, scaled.converted, {}) == DecodeFamily::scaled);
  CHECK(io::read_darknet_model<float>("", scaled.converted).warnings.empty());
  scaled.convert(true, 1e-5, DecodeFamily::ultralytics);
  check_refused(ErrorKind::mismatch, contradiction + "ultralytics",
                [&] { (void)family(said, scaled.converted, {}); });
}

TEST_CASE("W19, W20: converted detectors that do not fit are refused", "[io][detector_file][bad_input]") {
  const Model model;
  model.convert();
  const auto good = io::read_onnx(model.converted);
  using Network = nn::NetworkDescription;
  const auto refused = [&](ErrorKind kind, const std::string& message,
                           const std::function<void(Network&)>& change) {
    INFO(message);
    Network network = good;
    change(network);
    io::write_onnx(model.converted, network);
    check_refused(kind, message, [&] { (void)io::read_darknet_model<float>("", model.converted); });
  };
  const auto mismatch = ErrorKind::mismatch, malformed = ErrorKind::malformed;
  const auto with = [](const std::string& key, const std::string& value) {
    return [=](Network& network) { network.metadata[key] = value; };
  };
  refused(mismatch, "metadata field 'decode' is missing; expected darknet, ultralytics or scaled",
          [](Network& network) { network.metadata.erase("decode"); });
  for (const char* decode : {"yolov5", "", "Darknet", "darknet ", "yolox"})
    refused(mismatch,
            "metadata field 'decode' is not supported; expected darknet, ultralytics or scaled, found '" +
                std::string(decode) + "'",
            with("decode", decode));
  refused(mismatch,
          "some.onnx:cfg:50: layer 8 (yolo): decode family scaled (new_coords=1) needs activations, "
          "not logits",
          with("decode", "scaled"));
  refused(mismatch, "metadata field 'format' is missing", [](Network& network) { network.metadata.clear(); });
  refused(mismatch, "metadata field 'format' is not supported", with("format", "pt"));
  for (const char* field : {"cfg", "cfg_sha256", "batch_norm", "images_seen", "batch_norm_epsilon"})
    refused(mismatch, "metadata field '" + std::string(field) + "' is missing",
            [&](Network& network) { network.metadata.erase(field); });
  refused(malformed, "'cfg' does not have its hash", with("cfg", model.text + "\n"));
  refused(malformed, "expected kept or folded, found 'maybe'", with("batch_norm", "maybe"));
  refused(malformed, "metadata field 'images_seen' makes no sense", with("images_seen", "-1"));
  for (const char* epsilon : {"", "0", "-1e-5", "nan", "inf", "1e-5 ", "1e999"})
    refused(malformed, "metadata field 'batch_norm_epsilon' makes no sense",
            with("batch_norm_epsilon", epsilon));
  refused(malformed, "some.onnx:cfg:1:", [](Network& network) {
    network.metadata["cfg"] = "nonsense";
    network.metadata["cfg_sha256"] = io::sha256("nonsense");
  });

  const auto values = [](Network& network, const std::string& name) -> std::vector<float>& {
    return std::get<std::vector<float>>(network.constants.at(name).values);
  };
  refused(mismatch, "constant 'layer_1.weights' is not that of", [](Network& network) {
    network.constants.at("layer_1.weights").shape = {16, 25};
  });
  refused(mismatch, "some.onnx:cfg; expected (24,), found none", [](Network& network) {
    network.constants.erase("layer_4.biases");
    for (auto& node : network.nodes) std::erase(node.inputs, "layer_4.biases");
  });
  refused(malformed, "element 3 of the biases of layer 0 (convolutional, ",
          [&](Network& network) { values(network, "layer_0.biases")[3] = HUGE_VALF; });
  refused(malformed, "; expected a variance of at least 0, found -1",
          [&](Network& network) { values(network, "layer_0.variances")[1] = -1; });
}

TEST_CASE("read_darknet_model tells the two kinds of file apart", "[io][network_file]") {
  const Model model;
  model.convert();
  const auto parameters = model.network.parameters();
  CHECK(same_bits(io::read_darknet_model<float>(model.cfg, model.weights).model.parameters(), parameters));
  CHECK(same_bits(io::read_darknet_model<float>(model.cfg, model.converted).model.parameters(), parameters));
  const auto loaded = io::read_darknet_model<float>("", model.converted, 96, 128);
  CHECK(same_bits(loaded.model.parameters(), parameters));
  CHECK(loaded.model.images_seen() == model.network.images_seen());
  CHECK(loaded.model.input_height() == 96);
  CHECK(loaded.model.input_width() == 128);
  check_refused(ErrorKind::usage, "need their cfg",
                [&] { (void)io::read_darknet_model<float>("", model.weights); });
  const auto misnamed = model.folder.write("misnamed.onnx", model.folder.read("some.weights"));
  check_refused(ErrorKind::malformed, "misnamed.onnx",
                [&] { (void)io::read_darknet_model<float>(model.cfg, misnamed); });
  check_refused(ErrorKind::malformed, "cannot open",
                [&] { (void)io::read_darknet_model<float>("", model.folder.path("absent.onnx")); });
}

TEST_CASE("another cfg beside a converted detector is used with a remark, or refused", "[io][network_file]") {
  const Model model;
  model.convert();
  const auto wider = model.folder.write("wider.cfg", "# wider\n" + model.text);
  const auto loaded = io::read_darknet_model<float>(wider, model.converted);
  REQUIRE(loaded.warnings.size() == 1);
  CHECK_THAT(loaded.warnings[0], contains("wider.cfg: differs from the cfg inside"));
  const auto other = model.folder.write("other.cfg", test::common_layers);
  check_refused(ErrorKind::mismatch, "other.cfg",
                [&] { (void)io::read_darknet_model<float>(other, model.converted); });
}

TEST_CASE("write_detector_file refuses what it could not read again", "[io][detector_file]") {
  const Model model;
  const auto write = [&](const std::string& cfg) {
    (void)io::write_detector_file(model.converted, model.network, cfg);
  };
  check_refused(ErrorKind::malformed, "some.cfg:@2: not UTF-8", [&] { write("# \xE9\n" + model.text); });
  check_refused(ErrorKind::malformed, "some.cfg:1", [&] { write("nonsense"); });
  check_refused(ErrorKind::mismatch, "parameters of the model are [", [&] { write(test::common_layers); });
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
