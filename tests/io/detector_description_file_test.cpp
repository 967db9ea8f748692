#include <tapestry/io/detector_file.hpp>

#include "../support/bad_file.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;

namespace {
detect::DetectorDescription parsed(const std::string& text) {
  return io::parse_detector_description(text, "some.json");
}

const std::string nanodet =
    R"({"input": {"order": "bgr", "scale": 1, "mean": [103.53, 116.28, 123.675], )"
    R"("std": [57.375, 57.12, 58.395], "fit": "stretch"}, "head": "nanodet", "strides": [8, 16, 32]})";
}  // namespace

TEST_CASE("a detector's description is read from JSON", "[io][detector_description_file]") {
  CHECK(parsed(nanodet) == detect::known_description("nanodet"));
  CHECK(parsed(R"({"head": "yolox", "strides": [8, 16, 32], "input":
                   {"order": "bgr", "scale": 1, "fit": "letterbox_top_left", "fill": 114}})") ==
        detect::known_description("yolox"));
  CHECK(parsed(R"({"head": "yolox", "strides": [8, 16, 32], "input":
                   {"order": "bgr", "scale": 1, "fit": "letterbox_top_left"}})") ==
        detect::known_description("yolox"));
  const test::TemporaryFolder folder;
  CHECK(io::read_detector_description(folder.write("nanodet.json", nanodet)) == parsed(nanodet));
}

TEST_CASE("what a description leaves out has its default", "[io][detector_description_file]") {
  CHECK(parsed(R"({"head": "yolov5", "input": {}})") == detect::known_description("yolov5"));
  CHECK(parsed(R"({"head": "darknet", "strides": [32], "anchors": [[10, 13.5, 30, 20]]})") ==
        detect::DetectorDescription{{}, {}, detect::HeadKind::darknet, {32}, {{{10, 13.5}, {30, 20}}}});
  const auto grey = parsed(R"({"head": "yolov8", "strides": [8], "input": {"fill": 114}})");
  CHECK(grey.fit == image::Fit{image::FitKind::letterbox, 114.0 / 255});
  CHECK(grey.encoding == detect::InputEncoding{});
  CHECK(grey.strides == std::vector<std::size_t>{8});
}

TEST_CASE("a description without an input tells what is assumed of it", "[io][detector_description_file]") {
  std::vector<std::string> warnings;
  (void)io::parse_detector_description(R"({"head": "yolov8", "strides": [8]})", "a.json", &warnings);
  CHECK(warnings == std::vector<std::string>{
                        "a.json: has no 'input'; assumed are RGB in the range 0 to 1 and the fit letterbox"});
  warnings.clear();
  (void)io::parse_detector_description(R"({"head": "yolov8", "strides": [8], "input": {}})", "a.json",
                                       &warnings);
  (void)io::parse_detector_description(R"({"head": "yolov5"})", "a.json", &warnings);
  CHECK(warnings.empty());
}

TEST_CASE("decoded outputs are described by name and form", "[io][detector_description_file]") {
  const auto plain =
      parsed(R"({"head": "boxes_and_scores", "outputs": {"boxes": "b", "scores": "s"}})").decoded;
  CHECK(plain == detect::DecodedOutputs{"b", "s"});
  const auto full = parsed(R"({"head": "boxes_and_scores", "outputs": {"boxes": "o", "scores": "o",
      "channels": "first", "form": "corners_yx", "unit": "share", "objectness": "yes", "score": "logit",
      "background": "last"}})")
                        .decoded;
  CHECK(full == detect::DecodedOutputs{"o", "o", true, detect::BoxForm::corners_yx, true, true,
                                       detect::ScoreForm::logits, detect::Background::last});
}

TEST_CASE("end-to-end outputs are described by name, form and number of classes",
          "[io][detector_description_file]") {
  detect::DecodedOutputs expected{"o", "o", false, detect::BoxForm::corners};
  expected.classes = 80;
  const auto plain = parsed(R"({"head": "end_to_end", "outputs": {"detections": "o", "classes": 80}})");
  CHECK(plain.head == detect::HeadKind::end_to_end);
  CHECK(plain.decoded == expected);
  expected = {"o", "o", true, detect::BoxForm::corners_yx, true, false, detect::ScoreForm::logits};
  expected.classes = 3;
  CHECK(parsed(R"({"head": "end_to_end", "outputs": {"detections": "o", "classes": 3, "channels": "first",
      "form": "corners_yx", "unit": "share", "score": "logit"}})")
            .decoded == expected);
}

TEST_CASE("outputs of whole detectors are described", "[io][detector_description_file]") {
  detect::DecodedOutputs expected{"b", "s", false, detect::BoxForm::corners};
  expected.labels = "l";
  expected.classes = 91;
  CHECK(parsed(R"({"head": "end_to_end", "outputs": {"boxes": "b", "scores": "s", "labels": "l",
      "classes": 91}})")
            .decoded == expected);
  expected = {"b", "s"};
  expected.has_box_for_each_class = true;
  expected.extent = {1066, 800};
  expected.most_candidates = 300;
  CHECK(parsed(R"({"head": "boxes_and_scores", "outputs": {"boxes": "b", "scores": "s", "boxes_of": "class",
      "unit": [1066, 800], "candidates": 300}})")
            .decoded == expected);
}

TEST_CASE("N23: descriptions that make no sense are refused with the key",
          "[io][detector_description_file]") {
  const auto with_input = [](const std::string& input) {
    return R"({"input": )" + input + R"(, "head": "yolov5"})";
  };
  const auto with_strides = [](const std::string& strides) {
    return R"({"head": "yolox", "strides": )" + strides + "}";
  };
  const auto with_anchors = [](const std::string& anchors) {
    return R"({"head": "yolov5", "strides": [8], "anchors": )" + anchors + "}";
  };
  const auto with_outputs = [](const std::string& outputs) {
    return R"({"head": "boxes_and_scores", "outputs": )" + outputs + "}";
  };
  const auto bad = ErrorKind::malformed;
  const std::string anchors = "'anchors' makes no sense; expected for each of 1 strides a list of up to 16";
  const std::string heads =
      "expected darknet, ultralytics, yolox, nanodet, yolov8, yolov5, boxes_and_scores or end_to_end";
  const std::string counts =
      "'strides' makes no sense; expected up to 16 whole numbers from 1 to 4096, each once";
  const std::string fits = "'fit' makes no sense; expected letterbox, letterbox_top_left or stretch";
  test::check_bad_files(
      {{"no object", "[]", bad, "", "not a detector's description; expected a JSON object, found array"},
       {"no JSON", R"({"head": })", bad, "1:10", "not valid JSON"},
       {"no head", "{}", bad, "", "no 'head'; " + heads},
       {"head", R"({"head": "detr"})", bad, "1:10", "'head' makes no sense; " + heads + ", found 'detr'"},
       {"head as a number", R"({"head": 3})", bad, "1:10", "'head' makes no sense; " + heads + ", found '3'"},
       {"key", R"({"head": "darknet", "anchor": []})", bad, "1:31",
        "unknown key; expected input, head, strides, anchors, outputs, found 'anchor'"},
       {"input as a word", with_input("\"rgb\""), bad, "1:11", "'input' makes no sense; expected an object"},
       {"key of input", with_input(R"({"colour": "bgr"})"), bad, "1:11",
        "unknown key of 'input'; expected order, scale, mean, std, fit, fill, found 'colour'"},
       {"order", with_input(R"({"order": "grb"})"), bad, "1:11",
        "'order' makes no sense; expected rgb or bgr, found 'grb'"},
       {"scale 0", with_input(R"({"scale": 0})"), bad, "1:11",
        "'scale' makes no sense; expected a number from 1e-9 to 1e9, found '0'"},
       {"scale below 0", with_input(R"({"scale": -1})"), bad, "1:11", "'scale' makes no sense"},
       {"scale as a word", with_input(R"({"scale": "1"})"), bad, "1:11", "'scale' makes no sense"},
       {"two means", with_input(R"({"mean": [1, 2]})"), bad, "1:11",
        "'mean' makes no sense; expected three numbers from -1e9 to 1e9, found '[1,2]'"},
       {"a mean as a word", with_input(R"({"mean": [1, 2, "3"]})"), bad, "1:11", "'mean' makes no sense"},
       {"one mean", with_input(R"({"mean": 3})"), bad, "1:11", "'mean' makes no sense"},
       {"std 0", with_input(R"({"std": [1, 0, 1]})"), bad, "1:11",
        "'std' makes no sense; expected three numbers from 1e-9 to 1e9, found '0'"},
       {"infinite std", with_input(R"({"std": [1, 1e999, 1]})"), bad, "1:23", "not valid JSON"},
       {"fit", with_input(R"({"fit": "crop"})"), bad, "1:11", fits + ", found 'crop'"},
       {"fill", with_input(R"({"fit": "letterbox", "fill": 256})"), bad, "1:11",
        "'fill' makes no sense; expected a number from 0 to 255, found '256'"},
       {"fill of stretch", with_input(R"({"fit": "stretch", "fill": 0})"), bad, "1:11",
        "'fill' beside the fit stretch, which leaves nothing to fill"},
       {"no strides", R"({"head": "nanodet"})", bad, "",
        "no 'strides'; " + counts.substr(counts.find("expected"))},
       {"strides of darknet", R"({"head": "darknet", "anchors": [[1, 2]]})", bad, "", "no 'strides'"},
       {"no anchors", R"({"head": "ultralytics", "strides": [8]})", bad, "",
        "no 'anchors', which such heads need; expected for each of 1 strides a list"},
       {"anchors of yolox", R"({"head": "yolox", "strides": [8], "anchors": [[1, 2]]})", bad, "1:46",
        "'anchors' of heads that have none"},
       {"anchors for other strides", with_anchors("[[1, 2], [3, 4]]"), bad, "1:47", anchors},
       {"a width alone", with_anchors("[[1, 2, 3]]"), bad, "1:47", anchors},
       {"anchors in pairs", with_anchors("[[[1, 2]]]"), bad, "1:49", "JSON nested too deep"},
       {"anchors as one list", with_anchors("[1]"), bad, "1:47", anchors},
       {"strides of boxes", R"({"head": "boxes_and_scores", "strides": [8]})", bad, "1:41",
        "'strides' of heads that have none"},
       {"outputs of yolox", R"({"head": "yolox", "outputs": {}})", bad, "1:30",
        "'outputs' of heads that have none"},
       {"no outputs", R"({"head": "boxes_and_scores"})", bad, "", "no 'outputs'; expected an object"},
       {"outputs as a word", with_outputs("\"b\""), bad, "1:41",
        "'outputs' makes no sense; expected an object"},
       {"no scores", with_outputs(R"({"boxes": "b"})"), bad, "1:41",
        "no 'scores' in 'outputs'; expected an output's name"},
       {"boxes as a number", with_outputs(R"({"boxes": 1, "scores": "s"})"), bad, "1:41",
        "'boxes' makes no sense; expected an output's name, found '1'"},
       {"form", with_outputs(R"({"boxes": "b", "scores": "s", "form": "polygon"})"), bad, "1:41",
        "'form' makes no sense; expected centre, corners or corners_yx, found 'polygon'"},
       {"objectness of two", with_outputs(R"({"boxes": "b", "scores": "s", "objectness": "yes"})"), bad,
        "1:41", "'objectness' of two outputs, which have none"},
       {"no classes", R"({"head": "end_to_end", "outputs": {"detections": "o"}})", bad, "1:35",
        "no 'classes' in 'outputs'; expected a whole number from 1 to 4096"},
       {"classes of 0", R"({"head": "end_to_end", "outputs": {"detections": "o", "classes": 0}})", bad,
        "1:35", "'classes' makes no sense; expected a whole number from 1 to 4096, found '0'"},
       {"no detections", R"({"head": "end_to_end", "outputs": {"classes": 2}})", bad, "1:35",
        "no 'detections' in 'outputs'; expected an output's name"},
       {"boxes of end_to_end", R"({"head": "end_to_end", "outputs": {"boxes": "o", "classes": 2}})", bad,
        "1:35", "'boxes' without 'labels'"},
       {"detections beside labels",
        R"({"head": "end_to_end", "outputs": {"detections": "o", "labels": "l", "classes": 2}})", bad, "1:35",
        "'detections' beside 'labels'"},
       {"labels without boxes", R"({"head": "end_to_end", "outputs": {"labels": "l", "classes": 2}})", bad,
        "1:35", "no 'boxes' in 'outputs'; expected an output's name"},
       {"boxes of what", with_outputs(R"({"boxes": "b", "scores": "s", "boxes_of": "picture"})"), bad, "1:41",
        "'boxes_of' makes no sense; expected candidate or class, found 'picture'"},
       {"boxes of classes within the scores",
        with_outputs(R"({"boxes": "b", "scores": "b", "boxes_of": "class"})"), bad, "1:41",
        "boxes of classes are an output of their own, with channels last"},
       {"a unit of one number", with_outputs(R"({"boxes": "b", "scores": "s", "unit": [800]})"), bad, "1:41",
        "'unit' makes no sense; expected pixels, share or the width and height of another picture"},
       {"no room", with_outputs(R"({"boxes": "b", "scores": "s", "candidates": 0})"), bad, "1:41",
        "'candidates' makes no sense; expected a whole number from 1 to 100000, found '0'"},
       {"softmax of one score",
        R"({"head": "end_to_end", "outputs": {"detections": "o", "classes": 2, "score": "softmax"}})", bad,
        "1:35", "'score' makes no sense; expected probability or logit, found 'softmax'"},
       {"no anchor", with_anchors("[[]]"), bad, "1:47", anchors},
       {"anchor of 0", with_anchors("[[0, 2]]"), bad, "1:47", anchors},
       {"anchor as a word", with_anchors("[[\"1\", 2]]"), bad, "1:47", anchors},
       {"strides as a number", with_strides("8"), bad, "1:30", counts + ", found '8'"},
       {"no stride", with_strides("[]"), bad, "1:30", counts},
       {"stride 0", with_strides("[8, 0]"), bad, "1:30", counts + ", found '[8,0]'"},
       {"stride below 0", with_strides("[-8]"), bad, "1:30", counts},
       {"half a stride", with_strides("[8.5]"), bad, "1:30", counts},
       {"large stride", with_strides("[4097]"), bad, "1:30", counts},
       {"stride twice", with_strides("[8, 16, 8]"), bad, "1:30", counts},
       {"17 strides", with_strides("[1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17]"), bad, "1:30", counts},
       {"deep", with_input(R"({"mean": [[1], 2, 3]})"), bad, "1:21", "JSON nested too deep"},
       {"key twice", R"({"head": "darknet", "head": "yolox"})", bad, "1:21", "key given twice"}},
      "some.json", parsed);
}
