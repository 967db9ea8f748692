// Heads of decoded outputs in all forms that a description allows, of graphs made by hand, against a loop.
#include <tapestry/detect/detector.hpp>

#include "../support/catch.hpp"

using namespace tapestry;
using detect::Background, detect::ScoreForm;

namespace {
constexpr std::size_t side = 8;  ///< of the picture, 192 numbers

/// A picture [1, 3, 8, 8] as one row of numbers, "row".
nn::NetworkDescription flat_picture(std::int64_t opset) {
  nn::NetworkDescription network;
  network.path = "forms.onnx";
  network.opset = opset;
  network.inputs = {{"x", {1, 3, side, side}}};
  network.constants["one row"] = {{1}, nn::ElementType::integer, std::vector<double>{-1}};
  network.nodes = {{"", "Reshape", {"x", "one row"}, {"row"}, {}}};
  return network;
}

/// Adds the numbers from `first` on, in these extents.
void add_part(nn::NetworkDescription& network, const std::string& name, std::size_t first,
              const nn::Shape& shape) {
  std::vector<double> places(nn::size_of(shape));
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = double(first + i);
  network.constants[name + " places"] = {{places.size()}, nn::ElementType::integer, places};
  network.constants[name + " shape"] = {
      {shape.size()}, nn::ElementType::integer, std::vector<double>(shape.begin(), shape.end())};
  network.nodes.push_back(
      {"", "Gather", {"row", name + " places"}, {name + " row"}, {{"axis", std::int64_t(0)}}});
  network.nodes.push_back({"", "Reshape", {name + " row", name + " shape"}, {name}, {}});
}

/// A picture whose planes, one behind the other, hold these numbers first.
Array<double, 4> picture_of(const std::vector<double>& numbers) {
  auto picture = zeros<double, 4>({1, side, side, 3});
  for (std::size_t i = 0; i < numbers.size(); ++i)
    picture.data()[3 * (i % (side * side)) + i / (side * side)] = numbers[i];
  return picture;
}

std::vector<double> numbers(std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = 0.5 + 0.45 * std::sin(1 + 1.7 * double(i));
  return values;
}

double logit(double p) { return std::log(p) - std::log1p(-p); }
}  // namespace

TEST_CASE("boxes of classes: the surest class's counts, in every opset, with any background",
          "[detect][decoded]") {
  constexpr std::size_t candidates = 5, entries = 4;
  const std::int64_t opset = GENERATE(9, 12, 13, 18);
  const auto background = GENERATE(Background::none, Background::first, Background::last);
  const auto form = GENERATE(ScoreForm::logits, ScoreForm::softmax, ScoreForm::probabilities);
  const bool has_axis = GENERATE(false, true);
  CAPTURE(opset, background, form, has_axis);
  auto network = flat_picture(opset);
  nn::Shape boxes{candidates, entries, 4}, scores{candidates, entries};
  if (has_axis) {
    boxes.insert(boxes.begin(), 1);
    scores.insert(scores.begin(), 1);
  }
  add_part(network, "boxes", 0, boxes);
  add_part(network, "scores", candidates * entries * 4, scores);
  network.outputs = {"boxes", "scores"};
  detect::DetectorDescription kind;
  kind.head = detect::HeadKind::boxes_and_scores;
  kind.decoded = {"boxes", "scores"};
  kind.decoded.form = detect::BoxForm::corners;
  kind.decoded.score_form = form;
  kind.decoded.background = background;
  kind.decoded.has_box_for_each_class = true;
  kind.decoded.extent = {2, 4};  // so that lengths along x are times 4, along y times 2
  const detect::Detector<double> detector(network, kind);
  const auto values = numbers(candidates * entries * 5);
  const auto logits = detect::forward(detector, picture_of(values)).front();
  const std::size_t first = background == Background::first ? 1 : 0;
  const std::size_t classes = entries - (background == Background::none ? 0 : 1);
  REQUIRE(logits.shape() == Extents<4>{1, 4 + classes, 1, candidates});
  for (std::size_t n = 0; n < candidates; ++n) {
    const double* const score = values.data() + candidates * entries * 4 + n * entries;
    double sum = 0;
    for (std::size_t c = 0; c < entries; ++c) sum += std::exp(score[c]);
    for (std::size_t c = 0; c < classes; ++c) {
      const double own = score[first + c];
      const double expected = form == ScoreForm::logits          ? own
                              : form == ScoreForm::probabilities ? logit(own)
                                                                 : logit(std::exp(own) / sum);
      CHECK(logits(0, 4 + c, 0, n) == Approx(expected).epsilon(1e-6));
    }
    const auto best =
        static_cast<std::size_t>(std::max_element(score + first, score + first + classes) - score);
    const double* const box = values.data() + (n * entries + best) * 4;
    CHECK(logits(0, 0, 0, n) == Approx(4 * (box[0] + box[2]) / 2).epsilon(1e-6));
    CHECK(logits(0, 1, 0, n) == Approx(2 * (box[1] + box[3]) / 2).epsilon(1e-6));
    CHECK(logits(0, 2, 0, n) == Approx(4 * (box[2] - box[0])).epsilon(1e-6));
    CHECK(logits(0, 3, 0, n) == Approx(2 * (box[3] - box[1])).epsilon(1e-6));
  }
}

TEST_CASE("queries of transformers are read by one word, with the picture encoded as that family's",
          "[detect][decoded][named_export]") {
  constexpr std::size_t queries = 5, entries = 3;
  const bool has_background = GENERATE(false, true);
  const std::string name = GENERATE("logits", "pred_logits");
  CAPTURE(has_background, name);
  auto network = flat_picture(17);
  add_part(network, "pred_boxes", 0, {1, queries, 4});
  add_part(network, name, queries * 4, {1, queries, entries});
  network.outputs = {name, "pred_boxes"};
  const auto kind = detect::named_export(network, has_background ? "detr" : "rt_detr", 0, 0);
  const detect::Detector<double> detector(network, kind);
  const auto shown = numbers(queries * (4 + entries));
  const auto logits = detect::forward(detector, picture_of(shown)).front();
  const std::size_t classes = has_background ? entries - 1 : entries;
  REQUIRE(logits.shape() == Extents<4>{1, 4 + classes, 1, queries});
  const auto value = [&](std::size_t i) {  // ImageNet's red
    return has_background ? (shown[i] - 0.485) / 0.229 : shown[i];
  };
  for (std::size_t n = 0; n < queries; ++n) {
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(logits(0, i, 0, n) == Approx(double(side) * value(4 * n + i)).epsilon(1e-6));
    const std::size_t first = queries * 4 + n * entries;
    for (std::size_t c = 0; c < classes; ++c) {
      double others = 0;
      for (std::size_t k = 0; k < entries; ++k)
        if (k != c) others += std::exp(value(first + k));
      CHECK(logits(0, 4 + c, 0, n) ==
            Approx(has_background ? value(first + c) - std::log(others) : value(first + c)).epsilon(1e-5));
    }
  }
  network.outputs = {name};
  CHECK_THROWS_WITH(detect::named_export(network, "detr", 0, 0), test::contains("and pred_boxes"));
}

TEST_CASE("three outputs are the columns of an end-to-end one", "[detect][decoded]") {
  const std::int64_t opset = GENERATE(9, 12, 13, 18);
  const bool has_axis = GENERATE(false, true);
  CAPTURE(opset, has_axis);
  constexpr std::size_t candidates = 4;
  auto network = flat_picture(opset);
  add_part(network, "boxes", 0, has_axis ? nn::Shape{1, candidates, 4} : nn::Shape{candidates, 4});
  add_part(network, "scores", 16, has_axis ? nn::Shape{1, candidates} : nn::Shape{candidates});
  network.constants["labels"] = {{candidates}, nn::ElementType::integer, std::vector<double>{2, 0, 1, 2}};
  network.nodes.push_back({"", "Identity", {"labels"}, {"numbers of classes"}, {}});
  network.outputs = {"boxes", "scores", "numbers of classes"};
  detect::DetectorDescription kind;
  kind.head = detect::HeadKind::end_to_end;
  kind.decoded = {"boxes", "scores"};
  kind.decoded.labels = "numbers of classes";
  kind.decoded.classes = 3;
  const detect::Detector<double> detector(network, kind);
  const auto values = numbers(20);
  const auto logits = detect::forward(detector, picture_of(values)).front();
  for (std::size_t n = 0; n < candidates; ++n)
    for (std::size_t c = 0; c < 3; ++c) {
      const bool is_it = c == std::size_t(std::vector<int>{2, 0, 1, 2}[n]);
      CHECK(logits(0, 4 + c, 0, n) ==
            Approx(is_it ? logit(values[16 + n]) : logit(double(detect::least_probability))).epsilon(1e-5));
    }
}

TEST_CASE("a picture without candidates has room alone, and no slope; one with some has both",
          "[detect][decoded]") {
  // Candidates are those whose score is above a half.
  auto network = flat_picture(13);
  add_part(network, "all boxes", 0, {6, 4});
  add_part(network, "all scores", 24, {6, 1});
  add_part(network, "row of scores", 24, {6});
  network.constants["half"] = {{}, nn::ElementType::floating, std::vector<double>{0.5}};
  network.constants["places shape"] = {{1}, nn::ElementType::integer, std::vector<double>{-1}};
  network.nodes.push_back({"", "Greater", {"row of scores", "half"}, {"is sure"}, {}});
  network.nodes.push_back({"", "NonZero", {"is sure"}, {"sure"}, {}});
  network.nodes.push_back({"", "Reshape", {"sure", "places shape"}, {"places"}, {}});
  network.nodes.push_back({"", "Gather", {"all boxes", "places"}, {"boxes"}, {{"axis", std::int64_t(0)}}});
  network.nodes.push_back({"", "Gather", {"all scores", "places"}, {"scores"}, {{"axis", std::int64_t(0)}}});
  network.outputs = {"boxes", "scores"};
  detect::DetectorDescription kind;
  kind.head = detect::HeadKind::boxes_and_scores;
  kind.decoded = {"boxes", "scores"};
  kind.decoded.most_candidates = 4;
  const detect::Detector<double> detector(network, kind);
  const double least = logit(double(detect::least_probability));

  detect::Pass<double> pass;
  auto picture = picture_of(std::vector<double>(30, 0.25));
  detector.forward(picture, pass, detect::Mode::input_gradient);
  REQUIRE(pass.logits.front().shape() == Extents<4>{1, 5, 1, 4});
  for (std::size_t n = 0; n < 4; ++n) {
    CHECK(pass.logits.front()(0, 3, 0, n) == 0);
    CHECK(pass.logits.front()(0, 4, 0, n) == Approx(least).epsilon(1e-6));
  }
  CHECK(detector.detections(pass.logits, 0, 0.01).empty());
  auto gradient = zeros<double, 4>(picture.shape());
  const auto weights = filled<double, 4>({1, 5, 1, 4}, 1.0);
  detector.input_adjoint(pass, {weights}, gradient);
  CHECK(std::ranges::all_of(gradient.storage(), [](double slope) { return slope == 0; }));

  std::vector<double> some(30, 0.25);
  some[25] = 0.75;
  some[28] = 0.875;
  picture = picture_of(some);
  detector.forward(picture, pass, detect::Mode::input_gradient);
  const Array<double, 4>& logits = pass.logits.front();
  CHECK(logits(0, 4, 0, 0) == Approx(logit(0.75)));
  CHECK(logits(0, 4, 0, 1) == Approx(logit(0.875)));
  CHECK(logits(0, 4, 0, 2) == Approx(least).epsilon(1e-6));
  detector.input_adjoint(pass, {weights}, gradient);
  CHECK(gradient.data()[3 * 25] == Approx(1 / (0.75 * 0.25)));
  CHECK(gradient.data()[3 * 4] == 1);  // a number of the box of candidate 1

  for (std::size_t i = 24; i < 29; ++i) some[i] = 0.75;
  CHECK_THROWS_WITH(detector.forward(picture_of(some), pass),
                    contains("5 candidates in a picture, at most 4; state more as 'candidates'"));
}

TEST_CASE("scores of FCOS, roots of products, open axes and outputs of keypoints are known by one word",
          "[detect][named_export]") {
  auto network = flat_picture(13);
  network.inputs = {{"x", {std::nullopt, std::nullopt, std::nullopt}}};
  add_part(network, "all boxes", 0, {6, 4});
  add_part(network, "first", 24, {6});
  add_part(network, "second", 30, {6});
  network.nodes.push_back({"", "Sigmoid", {"first"}, {"class"}, {}});
  network.nodes.push_back({"", "Sigmoid", {"second"}, {"centre"}, {}});
  network.nodes.push_back({"", "Mul", {"class", "centre"}, {"product"}, {}});
  network.nodes.push_back({"", "Sqrt", {"product"}, {"all scores"}, {}});
  network.constants["kept"] = {{2}, nn::ElementType::integer, std::vector<double>{1, 4}};
  network.constants["all labels"] = {{6}, nn::ElementType::integer, std::vector<double>{0, 1, 0, 1, 0, 1}};
  network.nodes.push_back({"", "Gather", {"all boxes", "kept"}, {"boxes of these"}, {}});
  network.constants["columns"] = {{4}, nn::ElementType::integer, std::vector<double>{1, 1, 1, 1}};
  network.nodes.push_back({"",
                           "Split",
                           {"boxes of these", "columns"},
                           {"left", "top", "right", "bottom"},
                           {{"axis", std::int64_t(1)}}});
  const std::map<std::string, nn::Attribute> side_by_side{{"axis", std::int64_t(1)}};
  network.nodes.push_back({"", "Concat", {"left", "top", "right", "bottom"}, {"boxes"}, side_by_side});
  network.nodes.push_back({"", "Gather", {"all scores", "kept"}, {"scores"}, {}});
  network.nodes.push_back({"", "Gather", {"all labels", "kept"}, {"labels"}, {}});
  // Keypoints, x, y and whether they are seen, are picked like boxes.
  network.nodes.push_back({"", "Concat", {"left", "top", "right"}, {"keypoints"}, side_by_side});
  network.outputs = {"boxes", "scores", "labels"};
  if (GENERATE(false, true)) network.outputs.insert(network.outputs.end(), {"keypoints", "scores"});
  CHECK(detect::recognised_export(network) == "torchvision");
  const auto found = detect::named_export(network, "torchvision", 2, side);
  CHECK(found.decoded.boxes == "all boxes");
  CHECK(found.decoded.scores == "all scores");
  CHECK(found.decoded.labels == "all labels");
  CHECK(found.decoded.most_candidates == 5000);
}
