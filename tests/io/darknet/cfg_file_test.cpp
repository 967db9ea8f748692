#include <tapestry/io/darknet/model_file.hpp>

#include "../../support/bad_file.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
const std::string net = "[net]\nwidth=64\nheight=64\nchannels=3\n";
const std::string conv = "[convolutional]\nfilters=8\nsize=3\nstride=2\npad=1\nactivation=leaky\n";
const std::string head = "[convolutional]\nfilters=18\nsize=1\nactivation=linear\n";
const std::string logistic_head = "[convolutional]\nfilters=18\nsize=1\nactivation=logistic\n";
const std::string yolo = "[yolo]\nmask=0,1,2\nanchors=10,13, 16,30, 33,23\nclasses=1\nnum=3\n";
const std::string good = net + conv + head + yolo;
const std::string region = "[region]\nanchors=1,1.3, 1.6,3, 3.3,2.3\nclasses=1\ncoords=4\nnum=3\nsoftmax=1\n";
const std::string good_region = net + conv + head + region;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::logic_error(from);
  return text.replace(at, from.size(), to);
}

std::vector<BadFile> syntax_rows() {
  const auto malformed = ErrorKind::malformed;
  return {
      {"G01 empty", "", malformed, "1", "no [net]"},
      {"G01 comments", "# only\n; comments\n", malformed, "1", "no [net]"},
      {"G02 no net", conv + head + yolo, malformed, "1", "no [net] section"},
      {"G02 second net", good + net, malformed, "20", "second [net]"},
      {"G03 option first", "width=64\n" + good, malformed, "1", "before any section"},
      {"G04 no equals sign", replaced(good, "pad=1", "pad"), malformed, "9", "'pad'"},
      {"G05 word", replaced(good, "filters=8", "filters=eight"), malformed, "6:9", "'eight'"},
      {"G05 suffix", replaced(good, "filters=8", "filters=3x"), malformed, "6:9", "'3x'"},
      {"G05 exponent", replaced(good, "filters=8", "filters=1e3"), malformed, "6:9", "'1e3'"},
      {"G05 nothing", replaced(good, "filters=8", "filters="), malformed, "6:9", "''"},
      {"G05 hexadecimal", replaced(good, "filters=8", "filters = 0x10"), malformed, "6:11", "'0x10'"},
      {"G05 tail without a blank", replaced(good, "filters=8", "filters= 8# c"), malformed, "6:10", "'8# c'"},
      {"G05 only a comment", replaced(good, "filters=8", "filters= # 8"), malformed, "6:10", "'# 8'"},
      {"upsample scale", good + "[upsample]\nscale=inf\n", malformed, "21:7", "'inf'"},
      {"upsample scale twice", good + "[upsample]\nscale=1\nscale=1\n", malformed, "22", "given twice"},
      {"G05 beyond 64 bits", replaced(good, "filters=8", "filters=99999999999999999999"), malformed, "6:9",
       ""},
      {"G06 twice", replaced(good, "size=3", "size=3\nsize=5"), malformed, "8", "given twice"},
      {"G08 section", good + "[lstm]\n", malformed, "20", "[lstm]"},
      {"G08 section without end", good + "[lstm\n", malformed, "20", "']'"},
      {"G09 activation", replaced(good, "leaky", "lhtan"), malformed, "10:12", "'lhtan'"},
      {"G11 page", "<!DOCTYPE html>\n<html>", malformed, "1", "HTML"},
      {"G11 zero byte", good + std::string("a\0=1\n", 5), malformed, "20", "zero byte"},
      {"G11 long line", good + std::string(5u << 20u, 'x'), malformed, "20", "longer"},
      {"G14 empty route", good + "[route]\nlayers=\n", malformed, "21:8", "''"},
      {"G14 comma at the end", good + "[route]\nlayers=-1,\n", malformed, "21:8", "''"},
      {"G14 comma alone", good + "[route]\nlayers=,\n", malformed, "21:8", "''"},
      {"G14 no list", good + "[route]\n", malformed, "20", "lacks 'layers'"},
      {"G30 [crop]", good + "[crop]\n", malformed, "20", "[crop]"},
      {"G33 masks", replaced(good_region, "coords=4", "coords=14"), malformed, "18:8", "4: a box, found 14"},
      {"G33 background", good_region + "background=1\n", malformed, "21:12", "'background'"},
      {"G33 tree", good_region + "tree=coco.tree\n", malformed, "21:6", "'tree'"},
      {"G33 map", good_region + "map=coco9k.map\n", malformed, "21:5", "'map'"},
      {"G33 softmax=2", replaced(good_region, "softmax=1", "softmax=2"), malformed, "20:9", "0 to 1"},
      {"G33 no anchors", replaced(good_region, "anchors", "#"), malformed, "15", "lacks 'anchors'"},
      {"G33 fewer anchors", replaced(good_region, ", 3.3,2.3", ""), malformed, "16:9", "found 4"},
      {"G35 two layers", net + conv + conv + "[sam]\nfrom=0,1\n", malformed, "18:6", "one, found 2"},
      {"G35 no layer", net + conv + "[scale_channels]\n", malformed, "11", "lacks 'from'"},
      {"G35 scale_wh=2", net + conv + "[scale_channels]\nfrom=0\nscale_wh=2\n", malformed, "13:10", "0 to 1"},
      {"G34 reverse", good + "[reorg]\nstride=2\nreverse=1\n", malformed, "22:9", "'reverse'"},
      {"G34 flatten", good + "[reorg]\nflatten=1\n", malformed, "21:9", "'flatten'"},
      {"G34 extra", good + "[reorg]\nextra=8\n", malformed, "21:7", "'extra'"},
      {"G34 stride 0", good + "[reorg]\nstride=0\n", malformed, "21:8", ""},
      {"G30 [implicit]", good + "[implicit]\n", malformed, "20", "[implicit]"},
      {"G30 [Gaussian_yolo]", good + "[Gaussian_yolo]\n", malformed, "20", "[Gaussian_yolo]"},
      {"option that changes the result", replaced(good, "pad=1", "pad=1\nxnor=1"), malformed, "10:6",
       "'xnor'"},
  };
}

std::vector<BadFile> value_rows() {
  const auto malformed = ErrorKind::malformed;
  const auto limit = ErrorKind::limit;
  std::string deep = net;
  for (int i = 0; i < 4000; ++i) deep += "[dropout]\n";
  std::string pools;
  for (int i = 0; i < 9; ++i) pools += "[maxpool]\nsize=255\nstride=255\n";
  std::string long_route = good + "[route]\nlayers=0";
  for (int i = 0; i < 1000; ++i) long_route += ",0";
  return {
      {"G14 long route", long_route, malformed, "21:8", "512"},
      {"G17 zero filters", replaced(good, "filters=8", "filters=0"), malformed, "6:9", ""},
      {"G17 negative filters", replaced(good, "filters=8", "filters=-8"), malformed, "6:9", "-8"},
      {"G17 filters", replaced(good, "filters=8", "filters=2147483647"), limit, "6:9", ""},
      {"G18 size 0", replaced(good, "size=3", "size=0"), malformed, "7:6", ""},
      {"G18 even size", replaced(good, "size=3", "size=4"), malformed, "7:6", "even"},
      {"G18 huge size", replaced(good, "size=3", "size=100000"), malformed, "7:6", ""},
      {"G19 stride 0", replaced(good, "stride=2", "stride=0"), malformed, "8:8", ""},
      {"G19 stride -1", replaced(good, "stride=2", "stride=-1"), malformed, "8:8", ""},
      {"G19 stride above the input", replaced(good, "stride=2", "stride=100"), malformed, "5", "stride"},
      {"G20 width 0", replaced(good, "width=64", "width=0"), malformed, "2:7", ""},
      {"G20 width -64", replaced(good, "width=64", "width=-64"), malformed, "2:7", ""},
      {"G20 width 100000", replaced(good, "width=64", "width=100000"), limit, "2:7", ""},
      {"G20 odd size", replaced(good, "height=64", "height=63"), ErrorKind::mismatch, "15", "multiples of 2"},
      {"G20 odd size, cells of half a pixel",
       replaced(replaced(good, "height=64", "height=63"), "[yolo]", "[upsample]\nstride=4\n[yolo]"),
       ErrorKind::mismatch, "17", "multiples of the strides"},
      {"G20 strides beyond 2^63", replaced(good, "[yolo]", pools + "[yolo]"), ErrorKind::mismatch, "42",
       "multiples of the strides"},
      {"G21 no channels", replaced(good, "channels=3", "channels=0"), malformed, "4:10", ""},
      {"G21 one channel", replaced(good, "channels=3", "channels=1"), ErrorKind::mismatch, "4:10", "colour"},
      {"G21 four channels", replaced(good, "channels=3", "channels=4"), ErrorKind::mismatch, "4:10",
       "colour"},
      {"G23 upsample 0", good + "[upsample]\nstride=0\n", malformed, "21:8", ""},
      {"G23 upsample -2", good + "[upsample]\nstride=-2\n", malformed, "21:8", ""},
      {"G23 maxpool size 0", good + "[maxpool]\nsize=0\n", malformed, "21:6", ""},
      {"G23 maxpool stride 0", good + "[maxpool]\nsize=2\nstride=0\n", malformed, "22:8", ""},
      {"G25 fewer anchors", replaced(good, ", 33,23", ""), malformed, "17:9", "6 numbers, found 4"},
      {"G25 more anchors", replaced(good, "33,23", "33,23,1,1"), malformed, "17:9", "found 8"},
      {"G25 zero anchor", replaced(good, "10,13", "0,13"), malformed, "17:9", "anchor"},
      {"G25 negative anchor", replaced(good, "10,13", "-10,13"), malformed, "17:9", "anchor"},
      {"G25 infinite anchor", replaced(good, "10,13", "inf,13"), malformed, "17:9", "'inf'"},
      {"G25 not a number", replaced(good, "10,13", "nan,13"), malformed, "17:9", "'nan'"},
      {"new_coords=2", good + "new_coords=2\n", malformed, "20:12", "0 to 1"},
      {"G36 beta_nms 0", good + "nms_kind=diounms\nbeta_nms=0\n", malformed, "21:10", "not above 0"},
      {"G36 beta_nms", good + "nms_kind=diounms\nbeta_nms=nan\n", malformed, "21:10", "'nan'"},
      {"G26 negative classes", replaced(good, "classes=1", "classes=-1"), malformed, "18:9", ""},
      {"G28 4,000 layers", deep, limit, "2053", "layers"},
      {"G29 product",
       replaced(replaced(replaced(replaced(good, "width=64", "width=16384"), "height=64", "height=16384"),
                         "filters=8", "filters=1000000"),
                "stride=2", "stride=1"),
       limit, "5", "2147483648"},
  };
}

std::vector<BadFile> fit_rows() {
  const auto mismatch = ErrorKind::mismatch;
  return {
      {"G12 itself", net + conv + "[route]\nlayers=1\n", mismatch, "12:8", "found 1"},
      {"G12 later", net + conv + "[route]\nlayers=2\n", mismatch, "12:8", "0 to 0"},
      {"G12 first", net + "[route]\nlayers=-1\n", mismatch, "6:8", "[route] first"},
      {"G13 far ahead", net + conv + "[route]\nlayers=99\n", mismatch, "12:8", "99"},
      {"G13 far behind", net + conv + "[route]\nlayers=-50\n", mismatch, "12:8", "-50"},
      {"G15 sizes", net + conv + conv + "[route]\nlayers=0,1\n", mismatch, "17", "[8, 16, 16] of layer 1"},
      {"G16 shortcut", net + conv + replaced(conv, "stride=2", "stride=3") + "[shortcut]\nfrom=0\n", mismatch,
       "17", "expected [8, 11, 11] as layer 1, found [8, 32, 32] of layer 0"},
      {"G16 shortcut of other proportions",
       replaced(net, "width=64", "width=128") + conv + "[avgpool]\n[shortcut]\nfrom=0\n", mismatch, "12",
       "expected [8, 1, 1] as layer 1, found [8, 32, 64] of layer 0"},
      {"G22 groups", replaced(good, "pad=1", "pad=1\ngroups=2"), mismatch, "5", "groups=2"},
      {"G24 out of range", replaced(good, "mask=0,1,2", "mask=0,1,3"), mismatch, "16:6", "3"},
      {"G24 repeated", replaced(good, "mask=0,1,2", "mask=0,1,1"), mismatch, "16:6", "1"},
      {"G24 unsorted", replaced(good, "mask=0,1,2", "mask=0,2,1"), mismatch, "16:6", "1"},
      {"G26 classes", replaced(good, "classes=1", "classes=2"), mismatch, "15",
       "expected 21 channels, found 18"},
      {"G27 no yolo", net + conv, mismatch, "1", "no [yolo] or [region]"},
      {"G26 region's classes", replaced(good_region, "classes=1", "classes=2"), mismatch, "15",
       "expected 21 channels, found 18"},
      {"G27 region on yolo's grid", good + "[route]\nlayers=1\n" + region, mismatch, "22", "same grid"},
      {"reads from region", good_region + head, mismatch, "21", "[region] layer, which has no output"},
      {"G35 channels", net + conv + "[convolutional]\nfilters=4\n[avgpool]\n[scale_channels]\nfrom=0\n",
       mismatch, "14", "one factor for each channel of layer 0; expected [8, 1, 1], found [4, 1, 1]"},
      {"G35 no pooling", net + conv + conv + "[scale_channels]\nfrom=0\n", mismatch, "17",
       "expected [8, 1, 1], found [8, 16, 16]"},
      {"G35 pixels", net + conv + "[convolutional]\nfilters=2\n[scale_channels]\nfrom=0\nscale_wh=1\n",
       mismatch, "13", "one factor for each pixel of layer 0; expected [1, 32, 32], found [2, 32, 32]"},
      {"G35 values", net + conv + "[convolutional]\nfilters=4\n[sam]\nfrom=0\n", mismatch, "13",
       "one factor for each value of layer 0; expected [8, 32, 32], found [4, 32, 32]"},
      {"G35 later", net + conv + "[sam]\nfrom=1\n", mismatch, "12:6", "found 1"},
      {"G34 channels", net + conv + "[reorg]\nstride=4\n", mismatch, "11",
       "channels that are a multiple of 16, height and width of 4, found [8, 32, 32]"},
      {"G34 odd width", replaced(net, "width=64", "width=66") + conv + "[reorg3d]\nstride=2\n", mismatch,
       "11", "a multiple of 1, height and width of 2, found [8, 32, 33]"},
      {"G34 odd height", replaced(net, "height=64", "height=66") + conv + "[reorg]\nstride=2\n", mismatch,
       "11", "found [8, 33, 32]"},
      {"G27 same grid", good + "[route]\nlayers=1\n" + yolo, mismatch, "22", "same grid"},
      {"new_coords without logistic", good + "new_coords=1\n", mismatch, "15", "activation=logistic"},
      {"two decode families",
       net + conv + logistic_head + yolo + "new_coords=1\n[route]\nlayers=0\n" + conv + logistic_head + yolo,
       mismatch, "33", "expected scaled as on line 15, found darknet"},
      {"reads from yolo", good + head + yolo, mismatch, "20", "[yolo] layer, which has no output"},
  };
}

void check_rows(const std::vector<BadFile>& rows) {
  test::check_bad_files(rows, "some.cfg",
                        [](const std::string& text) { (void)io::parse_network_config(text, "some.cfg"); });
}
}  // namespace

TEST_CASE("cfg files with broken syntax name their line", "[io][darknet][bad_input]") {
  check_rows(syntax_rows());
}

TEST_CASE("cfg files with impossible values name their line and column", "[io][darknet][bad_input]") {
  check_rows(value_rows());
}

TEST_CASE("cfg files whose parts do not fit name their line", "[io][darknet][bad_input]") {
  check_rows(fit_rows());
}

TEST_CASE("G10: byte order mark, CRLF, tabs and a missing last newline are accepted",
          "[io][darknet][bad_input]") {
  std::string text = "\xEF\xBB\xBF" + good;
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 3)) {
    text.replace(at, 1, "\t\r\n");
  }
  text.resize(text.size() - 3);
  CHECK(io::parse_network_config(text, "some.cfg").layers.size() == 3);
}

TEST_CASE("G06, G07: harmless repetitions and unknown options become warnings", "[io][darknet][bad_input]") {
  const auto config = io::parse_network_config(
      replaced(replaced(good, "filters=8", "filtres=8"), "width=64", "batch=1\nbatch=2\nwidth=64"),
      "some.cfg");
  REQUIRE(config.warnings.size() == 2);
  CHECK(config.warnings[0] == "some.cfg:3: option 'batch' given twice in one section");
  CHECK(config.warnings[1] ==
        "some.cfg:8: unknown option 'filtres' of [convolutional] ignored; did you mean 'filters'?");
}

TEST_CASE("a comment may stand behind a value, and silu is another name of swish", "[io][darknet]") {
  const auto config = io::parse_network_config(
      replaced(replaced(good, "filters=8", "filters = 8 ###P6"), "leaky", "silu\t; x*sigmoid(x)"),
      "some.cfg");
  CHECK(config.warnings.empty());
  CHECK(config.layers[0].filters == 8);
  CHECK(config.layers[0].activation == nn::Activation::swish);
}

TEST_CASE("every activation is known by its name", "[io][darknet]") {
  for (const auto activation : nn::activations) {
    const std::string name(nn::name_of(activation));
    CHECK(io::parse_network_config(replaced(good, "leaky", name), "some.cfg").layers[0].activation ==
          activation);
    CHECK(std::string(nn::activation_names).find(name) != std::string::npos);
  }
}

TEST_CASE("training options are ignored in their own sections only", "[io][darknet]") {
  CHECK(
      io::parse_network_config(replaced(good, "width=64", "scale=.1\nlearning_rate=1\nwidth=64"), "some.cfg")
          .warnings.empty());
  const auto warned = [](const std::string& text) {
    return io::parse_network_config(text, "some.cfg").warnings;
  };
  CHECK(warned(replaced(good, "stride=2", "stride=2\nstopbackward=1\nlearning_rate=2")).empty());
  CHECK(warned(replaced(good, "stride=2", "stride=2\nscale=2")) ==
        std::vector<std::string>{"some.cfg:9: unknown option 'scale' of [convolutional] ignored"});
  CHECK(warned(replaced(good, "stride=2", "stride=2\nmax=3")).size() == 1);
  const auto scaled =
      io::parse_network_config(good + "[route]\nlayers=0\n[upsample]\nscale=-.5\n", "some.cfg");
  CHECK(scaled.warnings.empty());
  CHECK(scaled.layers.back().scale == -0.5);
}

TEST_CASE("a [region] is a head of anchors in cells, its training options are passed over", "[io][darknet]") {
  const auto config = io::parse_network_config(
      good_region +
          "bias_match=1\njitter=.3\nrescore=1\nobject_scale=5\nnoobject_scale=1\nclass_scale=1\n"
          "coord_scale=1\nabsolute=1\nthresh = .6\nrandom=1\n",
      "some.cfg");
  CHECK(config.warnings.empty());
  const detect::DarknetModel<float> network(config);
  REQUIRE(network.heads().size() == 1);
  const detect::Head& head_of_region = network.heads()[0];
  CHECK(head_of_region.exclusive_classes);
  CHECK(head_of_region.decode == detect::DecodeFamily::darknet);
  CHECK(head_of_region.anchors[1] == std::array<double, 2>{3.2, 6});  // cells of 2 px
  CHECK(network.resized(96, 128).heads()[0].anchors == head_of_region.anchors);
  CHECK(!detect::DarknetModel<float>(
             io::parse_network_config(replaced(good_region, "softmax=1", "softmax=0"), "some.cfg"))
             .heads()[0]
             .exclusive_classes);
}

TEST_CASE("letter_box says how pictures go in", "[io][darknet]") {
  const auto parsed = [](const std::string& option) {
    return io::parse_network_config(replaced(good, "channels=3\n", "channels=3\n" + option), "some.cfg");
  };
  const auto fit_of = [&](const std::string& option) { return detect::fit_of(parsed(option)); };
  CHECK(fit_of("") == image::Fit{});
  CHECK(fit_of("letter_box=1\n") == image::Fit{});
  CHECK(fit_of("letter_box=0\n").kind == image::FitKind::stretch);
  CHECK(parsed("letter_box=1\n").warnings.empty());
  test::check_bad_files({{"word", "letter_box=yes\n", ErrorKind::malformed, "5:12", "'yes'"},
                         {"2", "letter_box=2\n", ErrorKind::malformed, "5:12",
                          "option 'letter_box' out of range; expected 0 to 1"},
                         {"twice", "letter_box=1\nletter_box=1\n", ErrorKind::malformed, "6", "given twice"}},
                        "some.cfg", parsed);
}

TEST_CASE("another suppression than the one implemented is remarked", "[io][darknet]") {
  CHECK(io::parse_network_config(good + "nms_kind=greedynms\nbeta_nms=0.6\n", "some.cfg").warnings.empty());
  CHECK(io::parse_network_config(good + "nms_kind=cornersnms\nbeta_nms=0.6\n", "some.cfg").warnings ==
        std::vector<std::string>{
            "some.cfg:20: nms_kind=cornersnms is not obeyed; boxes are suppressed by their IoU (greedynms)"});
}

TEST_CASE("nms_kind=diounms says by which measure boxes are suppressed", "[io][darknet]") {
  const auto measure = [](const std::string& options) {
    const auto config = io::parse_network_config(good + options, "some.cfg");
    CHECK(config.warnings.empty());
    return detect::DarknetModel<float>(config).suppression_measure();
  };
  CHECK(measure("") == detect::SuppressionMeasure{});
  CHECK(measure("nms_kind=greedynms\nbeta_nms=0.7\n") == detect::SuppressionMeasure{});
  CHECK(measure("nms_kind=diounms\n") == detect::SuppressionMeasure{0.6});
  CHECK(measure("beta_nms=0.7\nnms_kind=diounms\n") == detect::SuppressionMeasure{0.7});
}

TEST_CASE("a shortcut keeps the shape of the layer before it", "[io][darknet]") {
  const auto config = io::parse_network_config(
      net + conv + head + yolo + "[route]\nlayers=0\n[shortcut]\nfrom=1\n", "some.cfg");
  CHECK(detect::infer_shapes(config, 64, 64).back().channels == 8);
}

TEST_CASE("any number of unknown options takes a time in proportion", "[io][darknet][bad_input][repeated]") {
  std::string options;  // comparing each with each would take minutes
  for (int i = 0; i < 300'000; ++i) options += "k" + std::to_string(i) + "=1\n";
  CHECK(io::parse_network_config(replaced(good, "width=64\n", "width=64\n" + options), "some.cfg")
            .warnings.size() == 100);
}

TEST_CASE("a classifier has layers and no head", "[io][darknet][bad_input]") {
  const auto parsed = [](const std::string& text) { return io::parse_classifier_config(text, "some.cfg"); };
  CHECK(parsed(net + conv + "[avgpool]\n[softmax]\n").layers.size() == 3);
  test::check_bad_files(
      {{"G37 yolo", good, ErrorKind::mismatch, "15", "layer 2 (yolo): a head, so this is not a classifier"},
       {"G37 region", good_region, ErrorKind::mismatch, "15", "not a classifier"},
       {"G37 no layers", net, ErrorKind::mismatch, "1", "without layers"},
       {"sizes", net + conv + conv + "[route]\nlayers=0,1\n", ErrorKind::mismatch, "17", "[8, 16, 16]"}},
      "some.cfg", parsed);
}

TEST_CASE("every prefix of a cfg is parsed or refused", "[io][darknet][bad_input]") {
  for (std::size_t length = 0; length < good.size(); ++length) {
    try {
      (void)io::parse_network_config(good.substr(0, length), "cut.cfg");
    } catch (const FileError& error) {
      CHECK(error.details().path == "cut.cfg");
    }
  }
}
