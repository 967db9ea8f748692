#include <tapestry/detect/detector_variable.hpp>

#include <tapestry/loss/adversarial.hpp>

#include "../support/active_tape.hpp"
#include "../support/finite_difference.hpp"
#include "../support/kept_pass.hpp"
#include "../support/pointers_to.hpp"
#include "../support/small_exports.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
constexpr std::size_t classes = test::exported_classes;

/// Boxes, scores and objectness in one output.
detect::DetectorDescription one_output(const std::string& output, const image::Fit& fit = {}) {
  detect::DetectorDescription kind{{}, fit, detect::HeadKind::boxes_and_scores};
  kind.decoded.boxes = kind.decoded.scores = output;
  kind.decoded.has_objectness = true;
  return kind;
}

/// A pass of the whole network, with the outputs of the file.
nn::NetworkPass<double> exported_pass(const nn::NetworkDescription& description, const double* input) {
  nn::NetworkPass<double> pass;
  nn::Network<double>(description, {}, true).forward({input}, pass);
  return pass;
}

/// Compares detections one by one; extents are less exact where anchors are rounded to float.
void check_detections(const std::vector<detect::Detection>& found,
                      const std::vector<detect::Detection>& expected, double epsilon) {
  REQUIRE(expected.size() > 100);
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].confidence == Approx(expected[i].confidence).epsilon(epsilon));
    CHECK(found[i].class_index == expected[i].class_index);
    CHECK(found[i].box.cx == Approx(expected[i].box.cx).epsilon(epsilon));
    CHECK(found[i].box.cy == Approx(expected[i].box.cy).epsilon(epsilon));
    CHECK(found[i].box.w == Approx(expected[i].box.w).epsilon(1e-6));
    CHECK(found[i].box.h == Approx(expected[i].box.h).epsilon(1e-6));
  }
}

/// The export as a converter to half precision leaves it: weights of convolutions are cast to single
/// precision, and whatever a node makes is cast to half precision and back.
nn::NetworkDescription with_casts(nn::NetworkDescription description) {
  constexpr std::int64_t single = 1, half = 10;
  const auto cast = [](const std::string& from, const std::string& to, std::int64_t type) {
    return nn::Node{"", "Cast", {from}, {to}, {{"to", type}}};
  };
  std::vector<nn::Node> nodes;
  for (nn::Node& node : description.nodes) {
    if (node.operation == "Conv") {
      nodes.push_back(cast(node.inputs[1], node.inputs[1] + ".single", single));
      node.inputs[1] += ".single";
    }
    const std::string output = node.outputs.front();
    node.outputs.front() += ".made";
    nodes.push_back(std::move(node));
    nodes.push_back(cast(output + ".made", output + ".half", half));
    nodes.push_back(cast(output + ".half", output, single));
  }
  description.nodes = std::move(nodes);
  return description;
}
}  // namespace

TEST_CASE("a detector of YOLOX's kind has the logits behind its export's scores",
          "[detect][graph_detector]") {
  const auto description = yolox_like(64);
  const detect::Detector<double> detector(description, detect::known_description("yolox"));
  REQUIRE(detector.heads().size() == 3);
  CHECK(detector.heads()[0].classes == classes);
  CHECK(detector.heads()[2].grid_width == 2);

  const auto images = pictures<double>(2, 64);
  const auto all = detect::forward(detector, images);

  // The export itself, fed with the second picture in its encoding: BGR, 0 to 255.
  nn::Buffer<double> input(64 * 64 * 3);
  for (std::size_t i = 0; i < input.size(); ++i)
    input.data()[i] = 255 * images.data()[input.size() + i / 3 * 3 + 2 - i % 3];
  const auto exported = exported_pass(description, input.data());
  std::size_t candidate = 0;
  for (const auto& logits : all) {
    const std::size_t cells = logits.shape(2) * logits.shape(3);
    for (std::size_t cell = 0; cell < cells; ++cell, ++candidate)
      for (std::size_t c = 0; c < 5 + classes; ++c) {
        const double logit = logits.data()[(logits.shape(1) + c) * cells + cell];
        const double shown = exported.output(0)[candidate * (5 + classes) + c];
        CHECK(shown == Approx(c < 4 ? logit : nn::logistic(logit)).epsilon(1e-12));
      }
  }
}

TEST_CASE("several threads run one detector at once, with the bits of one thread", "[detect][threads]") {
  const bool is_decoded = GENERATE(false, true);
  const auto kind = is_decoded ? one_output(yolox_like(64).outputs.front())  // the first call checks values
                               : detect::known_description("yolox");
  const auto images = pictures<float>(2, 64);
  struct Result {
    std::vector<Array<float, 4>> logits{};
    Array<float, 4> gradient{};
    std::size_t found = 0;
  };
  const auto run = [&](const detect::Detector<float>& detector) {
    detect::Pass<float> pass;
    Result result;
    detector.forward(images, pass, detect::Mode::input_gradient);
    result.logits = pass.logits;
    result.gradient = xt::zeros_like(images);
    detector.input_adjoint(pass, pass.logits, result.gradient);
    result.found = detector.detections(pass.logits, 1, 0.1).size();
    return result;
  };
  const Result expected = run(detect::Detector<float>(yolox_like(64), kind));
  const detect::Detector<float> shared(yolox_like(64), kind);
  std::vector<Result> results(4);
  std::vector<std::thread> threads;
  for (Result& result : results)
    threads.emplace_back([&] {
      for (int round = 0; round < 3; ++round) result = run(shared);
    });
  for (std::thread& thread : threads) thread.join();
  for (const Result& result : results) {
    CHECK(result.logits == expected.logits);
    CHECK(result.gradient == expected.gradient);
    CHECK(result.found == expected.found);
  }
}

TEST_CASE("a picture that changes within a window has the bits of a whole pass through an export",
          "[detect][graph_detector][kept]") {
  using image::PixelWindow;
  const auto [name, window] = GENERATE(table<const char*, PixelWindow>({{"yolox", {20, 24, 12, 16}},
                                                                        {"yolox", {0, 0, 5, 3}},
                                                                        {"yolox", {63, 63, 1, 1}},
                                                                        {"yolox", {7, 9, 0, 0}},
                                                                        {"yolox", {0, 0, 64, 64}},
                                                                        {"nanodet", {30, 40, 21, 17}},
                                                                        {"nanodet", {90, 0, 6, 96}}}));
  CAPTURE(name, window.top, window.left, window.height, window.width);
  const bool is_yolox = std::string(name) == "yolox";
  const detect::Detector<float> detector(is_yolox ? yolox_like(64) : nanodet_like(96),
                                         detect::known_description(name));
  auto images = pictures<float>(2, detector.input_height());
  Random random(4);
  const PixelWindow everything{0, 0, detector.input_height(), detector.input_width()};
  detect::KeptPicture<float> picture(window);
  detect::Pass<float> kept, whole;
  for (int step = 0; step < 4; ++step) {
    CAPTURE(step);
    test::repaint(images, 0, window, random);
    test::repaint(images, 1, everything, random);
    if (step == 2) images(0, detector.input_height() / 2, 0, 1) += 0.5F;  // kept values are invalid
    detector.forward_within(images, {&picture, nullptr}, kept, detect::Mode::input_gradient);
    detector.forward(images, whole, detect::Mode::input_gradient);
    CHECK(test::differences(kept.logits, whole.logits) == 0);
    CHECK(test::adjoint_differences(detector, kept, whole, {window, everything}, random) == 0);
  }
  CHECK((picture.bytes() > 0) == (window.height < everything.height));  // all of it changes: nothing is kept
  CHECK(detector.share_kept(everything) == 0);
  if (window.height < 20) CHECK(detector.share_kept(window) > 0.1);
}

TEST_CASE("kept pictures of an export hold until weights or mode change, and need windows inside",
          "[detect][graph_detector][kept][bad_input]") {
  detect::Detector<double> detector(yolox_like(64), detect::known_description("yolox"));
  const auto images = pictures<double>(1, 64);
  detect::KeptPicture<double> picture({20, 24, 12, 16}), outside({60, 0, 5, 5});
  detect::Pass<double> kept, whole;
  const auto check = [&](detect::Mode mode) {
    detector.forward_within(images, {&picture}, kept, mode);
    detector.forward(images, whole, mode);
    CHECK(test::differences(kept.logits, whole.logits) == 0);
  };
  check(detect::Mode::inference);
  check(detect::Mode::input_gradient);
  detector.set_weights(Array<double, 1>(1.25 * detector.weights()));
  check(detect::Mode::input_gradient);
  detector.set_engine(nn::Engine::direct);
  check(detect::Mode::input_gradient);
  check(detect::Mode::training);

  detector.forward_within(images, {&picture}, kept, detect::Mode::input_gradient);
  const std::vector<const Array<double, 4>*> nothing(kept.logits.size(), nullptr);
  CHECK_THROWS_WITH(detector.layer_adjoint(kept, nothing, 0, 0), contains("or only windows"));
  CHECK_THROWS_WITH(detector.forward_within(images, {}, kept), contains("0 kept pictures for 1 images"));
  CHECK_THROWS_AS(detector.forward_within(images, {&outside}, kept), ShapeError);
  CHECK_THROWS_AS(detector.share_kept({60, 0, 5, 5}), ShapeError);
}

TEST_CASE("a detector of NanoDet's kind finds its heads, classes first", "[detect][graph_detector]") {
  const detect::Detector<float> detector(nanodet_like(96), detect::known_description("nanodet"));
  REQUIRE(detector.heads().size() == 3);
  CHECK(detector.heads()[0].channel_count() == classes + 32);
  const auto logits = detect::forward(detector, pictures<float>(1, 96));
  for (const auto& head : logits) CHECK(head.shape(1) == classes + 32);
  CHECK_FALSE(detect::decode(detector.heads(), logits, 0, 0.01, 96, 96).empty());
}

TEST_CASE("heads are found behind the Casts of an export in half precision, with the same logits",
          "[detect][graph_detector]") {
  const std::string name = GENERATE("yolox", "nanodet", "yolov5");
  CAPTURE(name);
  const auto kind = detect::known_description(name);
  const auto plain = name == "yolox"     ? yolox_like(64)
                     : name == "nanodet" ? nanodet_like(64)
                                         : test::yolov5_like(64, kind.anchors);
  const auto cast = with_casts(plain);
  REQUIRE(cast.outputs == plain.outputs);
  CHECK(detect::recognised_detector(cast) == detect::recognised_detector(plain));
  const bool simplifies = GENERATE(true, false);
  const detect::Detector<float> expected(plain, kind, 0, {}, simplifies),
      found(cast, kind, 0, {}, simplifies);
  const auto images = pictures<float>(1, 64);
  CHECK(detect::forward(found, images) == detect::forward(expected, images));
}

TEST_CASE("a detector of YOLOv5's kind decodes as its export does", "[detect][graph_detector]") {
  const auto kind = detect::known_description("yolov5");
  const auto description = test::yolov5_like(64, kind.anchors);
  const detect::Detector<double> detector(description, kind);
  REQUIRE(detector.heads().size() == 3);
  CHECK(detector.heads()[0].classes == classes);
  CHECK(detector.heads()[2].anchors == kind.anchors[2]);
  const auto images = pictures<double>(1, 64);
  const double least = 0.05;
  const auto found = detect::decode(detector.heads(), detect::forward(detector, images), 0, least, 64, 64);

  // The export's own candidates, in the same order; it takes pictures unchanged.
  const auto exported = exported_pass(description, images.data());
  constexpr std::size_t channels = 5 + classes;
  const double* const rows = exported.output(0);
  std::vector<detect::Detection> expected;
  for (std::size_t candidate = 0; candidate < 3 * (64 + 16 + 4); ++candidate) {
    const double* const row = rows + candidate * channels;
    for (std::size_t c = 0; c < classes; ++c)
      if (const double confidence = row[4] * row[5 + c]; confidence > least)
        expected.push_back({c, confidence, row[4], {row[0], row[1], row[2], row[3]}});
  }
  check_detections(found, expected, 1e-12);
}

TEST_CASE("boxes and scores of an export are those of its logits", "[detect][graph_detector][decoded]") {
  const auto kind = detect::known_description("yolov5");
  const auto description = test::yolov5_like(64, kind.anchors);
  const detect::Detector<double> raw(description, kind);
  const detect::Detector<double> decoded(description, one_output(description.outputs.front(), kind.fit));
  REQUIRE(decoded.heads().size() == 1);
  CHECK(decoded.heads()[0].classes == classes);
  CHECK(decoded.heads()[0].candidate_count() == 252);
  const auto images = pictures<double>(2, 64);
  const auto detections = [&](const detect::Detector<double>& detector) {
    return detect::decode(detector.heads(), detect::forward(detector, images), 1, 0.05, 64, 64);
  };
  check_detections(detections(decoded), detections(raw), 1e-9);
}

TEST_CASE("decoded outputs may be described in every form", "[detect][graph_detector][decoded]") {
  // The first of two candidates: left 8, top 4, right 24, bottom 12 of 64 pixels, by the form; then
  // objectness and two classes, or a background and two classes.
  struct Form {
    std::string name;
    detect::DecodedOutputs outputs;
    std::vector<float> rows;  // [2, channels]
    std::vector<double> probabilities;
  };
  const auto none = detect::Background::none;
  using detect::BoxForm, detect::ScoreForm;
  const auto form = GENERATE_COPY(values<Form>(
      {{"centre",
        {"o", "o", false, BoxForm::centre, false, false, ScoreForm::probabilities, none},
        {16, 8, 16, 8, 0.25F, 0.75F, 1, 1, 1, 1, 0.5F, 0.5F},
        {0.25, 0.75}},
       {"corners, channels first",
        {"o", "o", true, BoxForm::corners, false, false, ScoreForm::logits, none},
        {8, 4, 24, 12, 0, 1, 1, 1, 1, 1, 2, 2},
        {0.5, nn::logistic(1.0)}},
       {"shares of the picture",
        {"o", "o", false, BoxForm::corners_yx, true, true, ScoreForm::probabilities, none},
        {4 / 64.0F, 8 / 64.0F, 12 / 64.0F, 24 / 64.0F, 0.5F, 0.25F, 1, 0, 0, 1, 1, 1, 1, 1},
        {0.125, 0.5}},
       {"logits of both",
        {"o", "o", false, BoxForm::centre, false, true, ScoreForm::logits, none},
        {16, 8, 16, 8, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0},
        {0.25, 0.5 * nn::logistic(1.0)}},
       {"probabilities and a background",
        {"o", "o", false, BoxForm::centre, false, false, ScoreForm::probabilities, detect::Background::first},
        {16, 8, 16, 8, 0.5F, 0.125F, 0.375F, 1, 1, 1, 1, 1, 0, 0},
        {0.125, 0.375}}}));
  INFO(form.name);
  const std::size_t channels = form.rows.size() / 2;
  nn::NetworkDescription description;
  description.opset = GENERATE(11, 21);
  description.inputs = {{"images", {1, 3, 64, 64}}};
  nn::Constant rows{{1, 2, channels}, nn::ElementType::floating, form.rows};
  if (form.outputs.channels_first) {
    std::vector<float> columns(form.rows.size());
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i % channels * 2 + i / channels] = form.rows[i];
    rows = {{1, channels, 2}, nn::ElementType::floating, columns};
  }
  description.constants["rows"] = rows;
  description.constants["nothing"] = {{1}, nn::ElementType::floating, std::vector<float>{0}};
  description.constants["axes"] = {{2}, nn::ElementType::integer, std::vector<double>{2, 3}};
  // A mean of the picture times 0, so that the output depends on it.
  description.nodes = {{"", "GlobalAveragePool", {"images"}, {"mean"}},
                       {"", "ReduceMax", {"mean"}, {"most"}, {{"keepdims", std::int64_t(0)}}},
                       {"", "Mul", {"most", "nothing"}, {"none"}},
                       {"", "Add", {"rows", "none"}, {"o"}}};
  description.outputs = {"o"};
  const detect::Detector<double> detector(description,
                                          {{}, {}, detect::HeadKind::boxes_and_scores, {}, {}, form.outputs});
  const auto logits = detect::forward(detector, pictures<double>(1, 64));
  REQUIRE(detector.heads()[0].classes == 2);
  REQUIRE(detector.heads()[0].candidate_count() == 2);
  const auto logit = [&](std::size_t channel) { return logits[0].data()[2 * channel]; };
  CHECK(logit(0) == Approx(16));
  CHECK(logit(1) == Approx(8));
  CHECK(logit(2) == Approx(16));
  CHECK(logit(3) == Approx(8));
  for (std::size_t k = 0; k < 2; ++k)
    CHECK(nn::logistic(logit(4 + k)) == Approx(form.probabilities[k]).epsilon(1e-6));
}

namespace {
/// A network whose output "o" is [1, N, 6] of these numbers, or [1, 6, N], the scores times the mean of the
/// brightest colour of the picture.
nn::NetworkDescription end_to_end(const std::vector<float>& rows, std::int64_t opset, bool channels_first) {
  nn::NetworkDescription description;
  description.path = "net.onnx";
  description.opset = opset;
  description.inputs = {{"images", {1, 3, 64, 64}}};
  std::vector<float> fixed(rows), lit(rows.size(), 0);
  for (std::size_t i = 4; i < rows.size(); i += 6) std::swap(fixed[i], lit[i]);
  const nn::Shape shape{1, rows.size() / 6, 6};
  description.constants["fixed"] = {shape, nn::ElementType::floating, fixed};
  description.constants["lit"] = {shape, nn::ElementType::floating, lit};
  description.nodes = {{"", "GlobalAveragePool", {"images"}, {"mean"}},
                       {"", "ReduceMax", {"mean"}, {"most"}, {{"keepdims", std::int64_t(0)}}},
                       {"", "Mul", {"lit", "most"}, {"scores"}},
                       {"", "Add", {"fixed", "scores"}, {channels_first ? "rows" : "o"}}};
  if (channels_first)
    description.nodes.push_back(
        {"", "Transpose", {"rows"}, {"o"}, {{"perm", std::vector<std::int64_t>{0, 2, 1}}}});
  description.outputs = {"o"};
  return description;
}

detect::DetectorDescription end_to_end_kind(std::size_t count, bool channels_first = false) {
  detect::DetectorDescription kind{{}, {}, detect::HeadKind::end_to_end};
  kind.decoded = {"o", "o", channels_first, detect::BoxForm::corners};
  kind.decoded.classes = count;
  return kind;
}

Array<double, 4> white() { return tapestry::filled<double, 4>({1, 64, 64, 3}, 1); }
}  // namespace

TEST_CASE("an end-to-end output has one score and one class for each box",
          "[detect][graph_detector][decoded]") {
  // Left, top, right, bottom, score, class; as YOLOv10 exports it. The last row is one of its padding.
  const std::vector<float> rows{8,  4,  24, 12, 0.75F, 2, 30, 20, 40, 60, 0.5F, 0,
                                10, 10, 30, 30, 0.3F,  1, 0,  0,  0,  0,  0,    -1};
  const std::int64_t opset = GENERATE(7, 9, 11, 13, 21);
  const bool channels_first = GENERATE(false, true);
  const detect::Detector<double> detector(end_to_end(rows, opset, channels_first),
                                          end_to_end_kind(3, channels_first));
  REQUIRE(detector.heads().size() == 1);
  CHECK(detector.heads()[0].classes == 3);
  CHECK(detector.heads()[0].candidate_count() == 4);
  detect::Pass<double> pass;
  detector.forward(white(), pass, nn::Mode::input_gradient);
  const auto found = detector.detections(pass.logits, 0, 0.25);
  REQUIRE(found.size() == 3);
  const std::size_t numbers[] = {2, 0, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = [&](std::size_t k) { return static_cast<double>(rows[6 * i + k]); };
    CHECK(found[i].class_index == numbers[i]);
    CHECK(found[i].confidence == Approx(at(4)).epsilon(1e-6));
    CHECK(found[i].box.cx == (at(0) + at(2)) / 2);
    CHECK(found[i].box.cy == (at(1) + at(3)) / 2);
    CHECK(found[i].box.w == at(2) - at(0));
    CHECK(found[i].box.h == at(3) - at(1));
  }
  // d logit/dp = 1/(p (1 − p)), and p = 0.75 times the mean of a colour of 64 x 64 pixels.
  auto adjoint = tapestry::zeros<double, 4>({1, 7, 1, 4}),
       gradient = tapestry::zeros<double, 4>({1, 64, 64, 3});
  adjoint(0, 4 + 2, 0, 0) = 1;
  detector.input_adjoint(pass, {adjoint}, gradient);
  CHECK(test::dot(gradient, white()) == Approx(0.75 / (0.75 * 0.25)).epsilon(1e-5));
}

TEST_CASE("outputs whose values are not what their description states are refused at the first pass",
          "[detect][graph_detector][decoded][error]") {
  const std::vector<float> rows{8, 4, 24, 12, 0.75F, 2, 30, 20, 40, 60, 0.5F, 0};
  const auto complaint = [](const std::vector<float>& values, const detect::DetectorDescription& kind) {
    const detect::Detector<double> detector(end_to_end(values, 13, false), kind);
    detect::Pass<double> pass;
    std::string first;
    for (int i = 0; i < 2; ++i) {  // a refusal is no pass
      std::string message = "none";
      try {
        detector.forward(white(), pass);
      } catch (const FileError& error) {
        CHECK(static_cast<int>(error.kind()) == static_cast<int>(ErrorKind::mismatch));
        message = error.what();
      }
      if (i == 0) first = message;
      CHECK(message == first);
    }
    return first;
  };
  const std::string beginning = "net.onnx: output 'o' is not as described: ";
  CHECK(complaint(rows, end_to_end_kind(3)) == "none");
  // An end-to-end output that is described as boxes and the scores of two classes.
  auto boxes = end_to_end_kind(0);
  boxes.head = detect::HeadKind::boxes_and_scores;
  CHECK(complaint(rows, boxes) ==
        beginning + "the probability of candidate 0 in channel 5; expected 0 to 1, found 2.000000");
  boxes.decoded.score_form = detect::ScoreForm::logits;  // which may be any numbers
  CHECK(complaint(rows, boxes) == "none");
  CHECK(complaint(rows, end_to_end_kind(2)) == beginning +
                                                   "the number of the class of candidate 0 in channel "
                                                   "5; expected a whole number from 0 to 1, found 2.000000");
  auto changed = rows;
  changed[11] = 0.5F;
  CHECK(complaint(changed, end_to_end_kind(3)).find("candidate 1 in channel 5; expected a whole number") !=
        std::string::npos);
  changed = rows;
  changed[10] = -0.25F;
  CHECK(complaint(changed, end_to_end_kind(3)) ==
        beginning + "the probability of candidate 1 in channel 4; expected 0 to 1, found -0.250000");
  changed[10] = 1.0005F;  // rounding
  CHECK(complaint(changed, end_to_end_kind(3)) == "none");
  CHECK_THROWS_WITH(detect::Detector<double>(end_to_end(rows, 13, false), end_to_end_kind(0)),
                    "Detector: decoded.classes of heads end_to_end is 0, expected at least 1");
  CHECK_THROWS_WITH(
      detect::Detector<double>(end_to_end(rows, 13, true), end_to_end_kind(3)),
      "net.onnx: not a detector of the kind end_to_end: output 'o'; expected [1, candidates, 6], "
      "found [1, 6, 2]");
}

TEST_CASE("the loss as coded asks for cells, which decoded outputs lack",
          "[detect][graph_detector][decoded]") {
  const auto description = test::yolov5_like(64, detect::known_description("yolov5").anchors);
  const detect::Detector<double> detector(description, one_output(description.outputs.front()));
  const ArrayVariable<double, 4> images = pictures<double>(1, 64);
  const std::vector<tapestry::loss::Target> targets{{1, {30, 32, 28, 20}}};
  CHECK_THROWS_WITH(
      (loss::adversarial<detect::Detector<double>, double>(detector, detect::forward(detector, images),
                                                           targets, loss::AdversarialLoss::as_coded)),
      contains("expected another loss than as_coded"));
}

TEST_CASE("boxes as shares of corners, and a softmax with a background, are read in every opset",
          "[detect][graph_detector][decoded]") {
  const std::int64_t opset = GENERATE(7, 9, 11, 13, 21);
  const auto description = test::boxes_and_scores(64, opset);
  detect::DetectorDescription kind{{}, {}, detect::HeadKind::boxes_and_scores};
  kind.decoded.boxes = description.outputs[0];
  kind.decoded.scores = description.outputs[1];
  kind.decoded.form = detect::BoxForm::corners_yx;
  kind.decoded.relative = true;
  kind.decoded.score_form = detect::ScoreForm::softmax;
  kind.decoded.background = GENERATE(detect::Background::first, detect::Background::last);
  const detect::Detector<double> detector(description, kind);
  const auto images = pictures<double>(1, 64);
  const auto logits = detect::forward(detector, images);
  const auto exported = exported_pass(description, images.data());
  REQUIRE(detector.heads()[0].candidate_count() == 64);
  REQUIRE(detector.heads()[0].classes == classes);
  const bool is_first = kind.decoded.background == detect::Background::first;
  for (std::size_t candidate = 0; candidate < 64; ++candidate) {
    const double* const box = exported.output(0) + 4 * candidate;
    const double* const scores = exported.output(1) + (1 + classes) * candidate;
    const auto logit = [&](std::size_t channel) { return logits[0].data()[64 * channel + candidate]; };
    CHECK(logit(0) == Approx(64 * (box[1] + box[3]) / 2).epsilon(1e-12));
    CHECK(logit(1) == Approx(64 * (box[0] + box[2]) / 2).epsilon(1e-12));
    CHECK(logit(2) == Approx(64 * (box[3] - box[1])).epsilon(1e-10).margin(1e-10));
    CHECK(logit(3) == Approx(64 * (box[2] - box[0])).epsilon(1e-10).margin(1e-10));
    double sum = 0;
    for (std::size_t k = 0; k <= classes; ++k) sum += std::exp(scores[k]);
    for (std::size_t k = 0; k < classes; ++k)
      CHECK(nn::logistic(logit(4 + k)) == Approx(std::exp(scores[k + (is_first ? 1 : 0)]) / sum));
  }
}

TEST_CASE("decoded outputs that are not there, or no boxes, are refused",
          "[detect][graph_detector][decoded][error]") {
  const auto description = test::boxes_and_scores(64, 11);
  detect::DetectorDescription kind{{}, {}, detect::HeadKind::boxes_and_scores};
  kind.decoded.boxes = "nowhere";
  kind.decoded.scores = description.outputs[1];
  CHECK_THROWS_WITH(detect::Detector<float>(description, kind),
                    contains("net.onnx: no node makes the output 'nowhere'"));
  kind.decoded.boxes = description.outputs[1];  // six numbers, not four
  kind.decoded.scores = description.outputs[0];
  CHECK_THROWS_AS(detect::Detector<float>(description, kind), FileError);
  kind.decoded.boxes = kind.decoded.scores = description.outputs[0];  // a box and no class
  CHECK_THROWS_AS(detect::Detector<float>(description, kind), FileError);
}

TEST_CASE("the loss of a graph detector is differentiable to its pictures",
          "[detect][graph_detector][gradient]") {
  for (const char* name : {"yolox", "nanodet", "yolov5", "boxes_and_scores"}) {
    INFO(name);
    const bool is_decoded = std::string(name) == "boxes_and_scores";
    const auto known = detect::known_description(is_decoded ? "yolov5" : name);
    const auto network = known.head == detect::HeadKind::yolox     ? yolox_like(64)
                         : known.head == detect::HeadKind::nanodet ? nanodet_like(64)
                                                                   : test::yolov5_like(64, known.anchors);
    const detect::Detector<double> detector(
        network, is_decoded ? one_output(network.outputs.front(), known.fit) : known);
    const auto images = pictures<double>(2, 64);
    const std::vector<tapestry::loss::Target> targets{{1, {30, 32, 28, 20}}, {3, {40, 20, 30, 30}}};
    const auto loss_of = [&](const ArrayVariable<double, 4>& at) {
      return loss::adversarial<detect::Detector<double>, double>(detector, detect::forward(detector, at),
                                                                 targets, loss::AdversarialLoss::max_score)
          .total;
    };
    const auto value = [&](const Array<double, 4>& at) { return loss_of(at).value(); };
    ActiveTape<double> tape;
    const auto input = tape.input(images);
    tape.reverse(loss_of(input));
    const auto direction = test::random_direction<double, 4>({2, 64, 64, 3}, 5);
    const double slope = test::dot(input.adjoint(), direction);
    CHECK(std::abs(slope) > 1e-8);
    CHECK(slope == Approx(test::central_difference(value, images, direction)).epsilon(1e-6));
  }
}

TEST_CASE("weights of a graph detector get their gradient", "[detect][graph_detector][gradient]") {
  detect::Detector<double> detector(yolox_like(64), detect::known_description("yolox"));
  const auto images = pictures<double>(1, 64);
  detect::Pass<double> pass;
  detector.forward(images, pass, detect::Mode::training);
  std::vector<Array<double, 4>> seeds;
  for (std::size_t h = 0; h < 3; ++h)
    seeds.push_back(test::random_array<double, 4>(
        {1, 5 + classes, pass.logits[h].shape(2), pass.logits[h].shape(3)}, 20 + h));
  auto gradient = tapestry::zeros<double, 1>({detector.weights().size()});
  detector.pull_back(pass, test::pointers_to(seeds), nullptr, &gradient);

  auto weights = detector.weights();
  const auto value = [&] {
    detector.set_weights(weights);
    return test::dot(detect::forward(detector, images), seeds);
  };
  REQUIRE(weights.size() > 0);
  for (const nn::WeightBlock& block : detector.network().weight_blocks()) {
    INFO(block.name);
    CHECK(gradient(block.offset) ==
          Approx(test::slope_by(weights[block.offset], 1e-6, value)).epsilon(1e-6).margin(1e-7));
  }
}

TEST_CASE("detectors that are known are recognised by what is behind their outputs",
          "[detect][graph_detector]") {
  CHECK(detect::recognised_detector(yolox_like(64)) == detect::known_description("yolox"));
  CHECK(detect::recognised_detector(nanodet_like(64)) == detect::known_description("nanodet"));
  test::Exporter exporter(64);
  CHECK_FALSE(detect::recognised_detector(exporter.finish(exporter.backbone())).has_value());
}

TEST_CASE("decoded outputs of other extents are refused by their names in the file",
          "[detect][graph_detector][decoded][error]") {
  const auto description = test::boxes_and_scores(64, 11);
  detect::DetectorDescription kind{{}, {}, detect::HeadKind::boxes_and_scores};
  const auto complaint = [&] {
    try {
      const detect::Detector<float> detector(description, kind);
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  const std::string beginning = "net.onnx: not a detector of the kind boxes_and_scores: output ";
  const std::string &boxes = description.outputs[0], &scores = description.outputs[1];
  kind.decoded.boxes = boxes;
  kind.decoded.scores = scores;
  CHECK(complaint() == "none");
  kind.decoded.channels_first = true;
  CHECK(complaint() == beginning + "'" + boxes + "'; expected [1, 4, candidates], found [1, 64, 4]");
  kind.decoded.channels_first = false;
  kind.decoded.scores = description.nodes[6].outputs.front();  // a map
  REQUIRE(description.nodes[6].operation == "Conv");
  CHECK(complaint() ==
        beginning + "'" + kind.decoded.scores + "'; expected [1, 64, classes], found [1, 8, 4, 4]");
  kind.decoded.boxes = kind.decoded.scores;
  CHECK(complaint() == beginning + "'" + kind.decoded.boxes +
                           "'; expected [1, candidates, 4 + classes], found [1, 8, 4, 4]");
  kind.decoded.boxes = kind.decoded.scores = boxes;
  kind.decoded.has_objectness = true;
  CHECK(complaint() == "net.onnx: not a detector of the kind boxes_and_scores: classes of output '" + boxes +
                           "'; expected at least 1, found 0");
}

TEST_CASE("what is no detector of the kind is refused", "[detect][graph_detector]") {
  const auto yolox = detect::known_description("yolox");
  CHECK_THROWS_WITH(
      detect::Detector<float>(yolox_like(64), detect::known_description("nanodet")),
      contains("net.onnx: not a detector of the kind nanodet: filters of its last convolutions; "
               "expected 32 and K, or 32 + K that are parted, for each of 3 grids, found 4, 1, 5, "));
  auto two = yolox;
  two.strides = {8, 16};
  CHECK_THROWS_WITH(detect::Detector<float>(yolox_like(64), two),
                    contains("expected 4, 1 and K for each of 2 grids"));
  auto yolov5 = detect::known_description("yolov5");
  const auto whole = test::yolov5_like(64, yolov5.anchors);
  const auto export5 = nn::pruned(whole, detect::raw_outputs(whole));  // it shows no anchors
  yolov5.anchors[1].pop_back();
  CHECK_THROWS_WITH(detect::Detector<float>(export5, yolov5),
                    contains("channels at stride 16") && contains("expected 20, found 30"));
  yolov5.anchors[0].assign(4, {8, 8});
  CHECK_THROWS_WITH(
      detect::Detector<float>(export5, yolov5),
      contains(
          "net.onnx: not a detector of the kind yolov5: channels of Conv \"v10\"; expected more than 20 and "
          "a multiple of 4, found 30"));
  yolov5 = detect::known_description("yolov5");
  yolov5.anchors.assign(3, {{8, 8}});
  CHECK_THROWS_WITH(detect::Detector<float>(yolox_like(64), yolov5),
                    contains("expected 1 times 5 + K for each of 3 grids, found 4, 1, 5, "));
  auto description = yolox_like(64);
  description.inputs.push_back({"more", {1}});
  CHECK_THROWS_WITH(detect::Detector<float>(description, yolox), contains("found 2 inputs"));
  description = yolox_like(64);
  description.inputs[0].shape = {1, 3, std::nullopt, std::nullopt};
  CHECK_THROWS_WITH(detect::Detector<float>(description, yolox), contains("--size"));
  CHECK(detect::Detector<float>(description, yolox, 96).input_width() == 96);
}
