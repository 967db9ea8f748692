#include <tapestry/io/detail/exported_names.hpp>

#include <tapestry/io/read_detector.hpp>

#include "../support/paths.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
using Names = std::vector<std::string>;
}

TEST_CASE("names of classes are read from Python's literals", "[io][names]") {
  CHECK(io::parse_exported_names("{0: 'person', 1: 'bicycle'}", 2) == Names{"person", "bicycle"});
  CHECK(io::parse_exported_names("['person', \"bicycle\"]", 2) == Names{"person", "bicycle"});
  CHECK(io::parse_exported_names(" {\n 2 :\t'a b' ,0:\"lady's bag\",\r\n} ", 3) ==
        Names{"lady's bag", "", "a b"});
  CHECK(io::parse_exported_names("['only']", 3) == Names{"only", "", ""});
  CHECK(io::parse_exported_names(R"({0: 'lady\'s', 1: "a \"b\"", 2: 'c\\d', 3: '{,}:'})", 4) ==
        Names{"lady's", "a \"b\"", "c\\d", "{,}:"});
  CHECK(io::parse_exported_names(R"(['caf\xe9', 'x\u0142', '\u4eba', '\U0001f697', '\x41'])", 5) ==
        Names{"caf\u00e9", "x\u0142", "\u4eba", "\U0001f697", "A"});
  CHECK(io::parse_exported_names("['caf\u00e9', '\u4eba']", 2) == Names{"caf\u00e9", "\u4eba"});
}

TEST_CASE("texts that are no names of a detector's classes are refused", "[io][names][bad_input]") {  // X27
  const auto refuse = [](const std::string& text, const std::string& why) {
    INFO(text);
    check_refused(ErrorKind::usage, why, [&] { (void)io::parse_exported_names(text, 3); });
  };
  for (const char* text : {"", " ", "person,car", "None", "names", "\xEF\xBB\xBF{0: 'a'}"})
    refuse(text, "expected { or [ at byte");
  for (const char* text : {"{}", "[]"}) refuse(text, "no names");
  for (const char* text : {"{0: 'a' 1: 'b'}", "{0: 'a'", "{0: 'a';}", "['a' 'b']", "['a'}"})
    refuse(text, "expected , or ");
  for (const char* text :
       {"{'0': 'a'}", "{-1: 'a'}", "{: 'a'}", "{0: 'a',, 1: 'b'}", "{99999999999999999999999: 'a'}"})
    refuse(text, "expected the number of a class");
  for (const char* text : {"{0 'a'}", "{0.5: 'a'}", "{1_0: 'a'}"}) refuse(text, "expected :");
  for (const char* text : {"{0: a}", "{0: None}", "{0: {0: 'a'}}", "[0, 1]", "[u'a']", "{0:"})
    refuse(text, "expected a text in quotes");
  for (const char* text : {"['a", "['a\\'", "['a\"]"}) refuse(text, "a text without end");
  refuse("{0: 'a'} 1", "expected nothing more at byte 9");
  refuse("{3: 'a'}", "a name for class 3, but there are 3 classes");
  refuse("['a', 'b', 'c', 'd']", "a name for class 3, but there are 3 classes");
  refuse("{0: 'a', 0: 'b'}", "class 0 is named twice");
  refuse("{0: 'a', 1: 'a'}", "name 'a' is repeated");
  for (const char* text : {R"(['a\n'])", R"(['\N{DASH}'])", R"(['\7'])", "['a\\"})
    refuse(text, "an escape that no name needs");
  for (const char* text : {R"(['\x4'])", R"(['\u12'])", R"(['\U00110000'])", R"(['\xg1'])", R"(['\x)"})
    refuse(text, "an escape that is no character");
  for (const std::string text :
       {"['']", "['a\nb']", R"(['\x1b[2J'])", R"(['\ud800'])", "['\xff']", R"(['\u202e'])"})
    refuse(text, "class 0 is named");
  refuse("['" + std::string(1001, 'x') + "']", "class 0 is named");
}

TEST_CASE("an export of YOLOv5 names its classes", "[io][names][read_detector]") {
  const std::string path = test::in_shared("data/detectors/yolov5n_fp16.onnx");
  if (is_absent(path)) return;
  const test::TemporaryFolder folder;
  std::vector<std::string> warnings;
  const auto detector = io::read_detector<float>(
      {.weights = path, .description = folder.write("y.json", R"({"head": "yolov5"})")}, &warnings);
  REQUIRE(detector.names().size() == 80);
  CHECK(detector.class_index("car") == 2);
  CHECK(detector.class_index("traffic light") == 9);
  CHECK(warnings == Names{path + ": class names are from the model's metadata"});
}
