#include <tapestry/evaluate/dataset/dataset.hpp>

#include <tapestry/evaluate/dataset/readers.hpp>

#include "../../support/bad_file.hpp"
#include "../../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;
using detect::Box;

namespace {
constexpr auto malformed = ErrorKind::malformed;
constexpr auto mismatch = ErrorKind::mismatch;

void check_box(const Box& box, double left, double top, double right, double bottom) {
  CHECK(box.left() == Approx(left));
  CHECK(box.top() == Approx(top));
  CHECK(box.right() == Approx(right));
  CHECK(box.bottom() == Approx(bottom));
}

/// COCO instances with these lists.
std::string coco(const std::string& images, const std::string& annotations, const std::string& categories) {
  return R"({"info": {}, "images": [)" + images + R"(], "annotations": [)" + annotations +
         R"(], "categories": [)" + categories + "]}";
}
const std::string a_picture = R"({"id": 7, "file_name": "a.png", "width": 40, "height": 30})";
const std::string cats = R"({"id": 3, "name": "car"}, {"id": 1, "name": "person"})";
std::string annotation(const std::string& id, const std::string& box, const std::string& more = "") {
  return R"({"id": )" + id + R"(, "image_id": 7, "category_id": 3, "bbox": )" + box + more + "}";
}

std::string voc(const std::string& objects,
                const std::string& size = "<width>40</width><height>30</height>") {
  return "<?xml version=\"1.0\"?>\n<annotation>\n<filename>a.png</filename>\n<size>" + size + "</size>\n" +
         objects + "\n</annotation>\n";
}
std::string voc_object(const std::string& bounds, const std::string& name = "<name>car</name>") {
  return "<object>" + name + "\n<bndbox>" + bounds + "</bndbox></object>";
}
const std::string sound_bounds = "<xmin>11</xmin><ymin>6</ymin><xmax>20</xmax><ymax>10</ymax>";
}  // namespace

TEST_CASE("labels of YOLO are shares that become pixels", "[io][dataset]") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("images"));
  std::filesystem::create_directories(folder.path("labels"));
  folder.write("images/b.png", "");
  folder.write("images/a.JPG", "");
  folder.write("images/notes.md", "");
  folder.write("labels/a.txt", "1 0.5 0.25 0.5 0.5\r\n\n 0 0 1 1e-3 1 \n");
  const auto dataset = evaluate::read_yolo_folder(folder.path(), 2);
  REQUIRE(dataset.pictures.size() == 2);
  CHECK(dataset.pictures[0].path == folder.path("images/a.JPG"));
  CHECK(dataset.pictures[1].objects.empty());
  REQUIRE(dataset.warnings.size() == 1);
  CHECK_THAT(dataset.warnings[0], contains("1 of 2 pictures have no file of labels"));
  const auto objects = evaluate::objects_in_pixels(dataset.pictures[0], 20, 40);
  REQUIRE(objects.size() == 2);
  CHECK(objects[0].class_index == 1);
  check_box(objects[0].box, 10, 0, 30, 10);
  CHECK(objects[0].area == Approx(200));
}

TEST_CASE("a list of Darknet names pictures beside it", "[io][dataset]") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("some"));
  folder.write("some/a.png", "");
  folder.write("some/a.txt", "0 0.5 0.5 1 1\n");
  const auto list = folder.write("train.txt", "some/a.png\r\n" + folder.write("b.png", "") + "\n\n");
  const auto dataset = evaluate::read_darknet_list(list, 1);
  REQUIRE(dataset.pictures.size() == 2);
  CHECK(dataset.pictures[0].objects.size() == 1);
  CHECK(dataset.pictures[1].path == folder.path("b.png"));
  CHECK(dataset.warnings.size() == 1);
}

TEST_CASE("N24: labels of YOLO that make no sense are refused with the line", "[io][dataset]") {
  const std::string centre = "centre of a box; expected a share of the picture, 0 to 1, found";
  const std::string extent = "extent of a box; expected a share of the picture, above 0 and at most 1, found";
  check_bad_files(
      {{"no number", "0 0.5 0.5 1 1\ncar 0 0 1 1", malformed, "2", "expected 0 to 1, found 'car'"},
       {"class out of range", "2 0.5 0.5 1 1", mismatch, "1", "class out of range; expected 0 to 1, found 2"},
       {"negative class", "-1 0.5 0.5 1 1", malformed, "1", "class is no whole number"},
       {"NaN", "0 nan 0.5 1 1", malformed, "1", centre + " 'nan'"},
       {"centre outside", "0 0.5 1.5 1 1", malformed, "1", centre + " '1.5'"},
       {"pixels", "0 0.5 0.5 120 80", malformed, "1", extent + " '120'"},
       {"negative extent", "0 0.5 0.5 1 -0.5", malformed, "1", extent + " '-0.5'"},
       {"no extent", "0 0.5 0.5 0 1", malformed, "1", extent + " '0'"},
       {"cut", "0 0.5 0.5", malformed, "1", "label ends early; expected class cx cy w h, found 3 words"},
       {"an outline", "0 0.1 0.1 0.2 0.2 0.3 0.3", malformed, "1", "expected class cx cy w h, found '0.3'"},
       {"zero byte", std::string("0 0\0.5", 6), malformed, "1", "zero byte"}},
      "a.txt", [](const std::string& text) { (void)evaluate::parse_yolo_labels(text, "a.txt", 2); });
}

TEST_CASE("N25: lists and folders without pictures or labels are refused", "[io][dataset]") {
  const TemporaryFolder folder;
  const auto list = folder.path("train.txt");
  folder.write("a.png", "");
  check_bad_files({{"missing picture", "a.png\nb.png\n", mismatch, "2", "a picture is missing; expected "},
                   {"listed twice", "a.png\n\na.png\n", mismatch, "3", "listed twice; found line 1"},
                   {"nothing", "\n", mismatch, "", "no pictures"},
                   {"no labels", "a.png", mismatch, "", "no picture has labels"}},
                  list, [&](const std::string& text) {
                    folder.write("train.txt", text);
                    (void)evaluate::read_darknet_list(list, 1);
                  });
  CHECK_THROWS_WITH(evaluate::read_yolo_folder(folder.path(), 1), contains("no picture has labels"));
  CHECK_THROWS_WITH(evaluate::read_voc(folder.path()),
                    contains("no labels; expected .xml files, found none"));
  CHECK_THROWS_WITH(evaluate::read_voc(folder.path("absent")), contains("cannot list the folder"));
  CHECK_THROWS_WITH(evaluate::read_yolo_folder(folder.path("absent"), 1), contains("cannot list the folder"));
  std::filesystem::create_directories(folder.path("empty"));
  CHECK_THROWS_WITH(evaluate::read_yolo_folder(folder.path("empty"), 1), contains("no pictures"));
  std::filesystem::create_directories(folder.path("twins"));
  folder.write("twins/a.jpg", "");
  folder.write("twins/a.png", "");
  CHECK_THROWS_WITH(evaluate::read_yolo_folder(folder.path("twins"), 1),
                    contains("a.jpg: two pictures would have the same labels") && contains("'a.png'"));
}

TEST_CASE("COCO's instances are read in order of their ids", "[io][dataset]") {
  const TemporaryFolder folder;
  folder.write("a.png", "");
  folder.write("b.png", "");
  const auto text = coco(a_picture + R"(, {"id": 5, "file_name": "b.png", "width": 9, "height": 8})",
                         annotation("1", "[10, 5, 10, 4.5]") + ", " +
                             annotation("0", "[0, 0, 4, 4]", R"(, "area": 3.5, "iscrowd": 1)"),
                         cats);
  const auto dataset = evaluate::read_coco(folder.write("a.json", text), folder.path());
  CHECK(dataset.class_names == std::vector<std::string>{"person", "car"});
  CHECK(dataset.class_ids == std::vector<std::uint64_t>{1, 3});
  REQUIRE(dataset.pictures.size() == 2);
  CHECK(dataset.pictures[0].id == 5);
  CHECK(dataset.pictures[1].path == folder.path("a.png"));
  const auto objects = evaluate::objects_in_pixels(dataset.pictures[1], 30, 40);
  REQUIRE(objects.size() == 2);
  check_box(objects[0].box, 10, 5, 20, 9.5);
  CHECK(objects[0].class_index == 1);
  CHECK(objects[0].area == 45);
  CHECK_FALSE(objects[0].is_crowd);
  CHECK(objects[1].area == 3.5);
  CHECK(objects[1].is_crowd);
  CHECK_THROWS_WITH(evaluate::objects_in_pixels(dataset.pictures[1], 40, 30),
                    contains("another size than its labels state; expected 40x30, found 30x40"));
  CHECK_THROWS_AS(evaluate::objects_in_pixels(dataset.pictures[1], 31, 40), FileError);
  CHECK_THROWS_AS(evaluate::objects_in_pixels(dataset.pictures[1], 30, 41), FileError);
}

TEST_CASE("N26: COCO files that make no sense are refused with the entry and the place", "[io][dataset]") {
  const TemporaryFolder folder;
  folder.write("a.png", "");
  const auto with = [](const std::string& annotations) { return coco(a_picture, annotations, cats); };
  const std::string images = "1:24", labels = "1:101";
  const std::string box = "[1, 2, 3, 4]",
                    extent = "annotations[0].bbox makes no sense; expected a number from 0";
  check_bad_files(
      {{"cut", with("").substr(0, 120), malformed, "1:121", "not valid JSON"},
       {"deep", std::string(70, '[') + std::string(70, ']'), malformed, "1:65", "nested too deep"},
       {"no object", "[]", malformed, "", "expected a JSON object, found array"},
       {"results", R"({"images": []})", malformed, "", "annotations and categories, found no categories"},
       {"no list", R"({"categories": 3})", malformed, "1:16", "categories makes no sense; expected a list"},
       {"no entry", R"({"categories": [3]})", malformed, "1:16", "categories[0] makes no sense"},
       {"no pictures", coco("", "", cats), mismatch, "", "no pictures"},
       {"missing picture", coco(R"({"id": 1, "file_name": "no.png", "width": 4, "height": 3})", "", cats),
        mismatch, images, "images[0].file_name is missing; expected " + folder.path("no.png")},
       {"a long name", coco(R"({"id": 1, "file_name": ")" + std::string(5000, '/') + "\"}", "", cats),
        malformed, images, "images[0].file_name is too long; expected at most 4096 bytes, found 5000"},
       {"above", coco(R"({"id": 1, "file_name": "../a.png", "width": 4, "height": 3})", "", cats), malformed,
        images,
        "images[0].file_name lies outside the folder of the pictures; expected a name in it, found "
        "'../a.png'"},
       {"above by a detour",
        coco(R"({"id": 1, "file_name": "b/../../a.png", "width": 4, "height": 3})", "", cats), malformed,
        images, "images[0].file_name lies outside"},
       {"absolute",
        coco(R"({"id": 1, "file_name": ")" + folder.path("a.png") + R"(", "width": 4, "height": 3})", "",
             cats),
        malformed, images, "images[0].file_name lies outside"},
       {"id given twice", coco(a_picture + "," + a_picture, "", cats), malformed, images,
        "images[1].id is given twice; expected an id of its own, found 7, that of images[0]"},
       {"no width", coco(R"({"id": 1, "file_name": "a.png"})", "", cats), malformed, images,
        "images[0].height is missing"},
       {"labels twice", with(annotation("1", box) + "," + annotation("1", box)), malformed, labels,
        "annotations[1].id is given twice"},
       {"no box", with(R"({"id": 1, "image_id": 7, "category_id": 3})"), malformed, labels,
        "annotations[0].bbox is missing"},
       {"short box", with(annotation("1", "[1, 2, 3]")), malformed, labels,
        "annotations[0].bbox makes no sense; expected [x, y, width, height], found 'array'"},
       {"negative extent", with(annotation("1", "[1, 2, -3, 4]")), malformed, labels, extent},
       {"text", with(annotation("1", R"([1, 2, "3", 4])")), malformed, labels, extent},
       {"NaN", with(annotation("1", "[1, 2, NaN, 4]")), malformed, "1:160", "not valid JSON"},
       {"too large", with(annotation("1", "[1, 2, 1e999, 4]")), malformed, "1:160", "not valid JSON"},
       {"crowd", with(annotation("1", box, R"(, "iscrowd": 2)")), malformed, labels,
        "annotations[0].iscrowd"},
       {"unknown picture", with(R"({"id": 1, "image_id": 8, "category_id": 3, "bbox": [1, 2, 3, 4]})"),
        mismatch, labels, "annotations[0].image_id is unknown; expected an id of images, found 8"},
       {"unknown class", with(R"({"id": 1, "image_id": 7, "category_id": 2, "bbox": [1, 2, 3, 4]})"),
        mismatch, labels, "annotations[0].category_id is unknown"},
       {"one name", R"({"categories": [{"id": 1, "name": "a"}, {"id": 2, "name": "a"}]})", malformed, "1:16",
        "categories[1].name is given twice; expected a name of its own, found 'a', that of id 1"},
       {"negative id", R"({"categories": [{"id": -1, "name": "a"}]})", malformed, "1:16",
        "categories[0].id makes no sense"}},
      "a.json", [&](const std::string& text) { (void)evaluate::parse_coco(text, "a.json", folder.path()); });
}

TEST_CASE("labels of Pascal VOC count columns from 1", "[io][dataset]") {
  const TemporaryFolder folder;
  for (const auto* name : {"Annotations", "JPEGImages"})
    std::filesystem::create_directories(folder.path(name));
  folder.write("JPEGImages/a.png", "");
  const std::string part = "<part><name>wheel</name><bndbox><xmin>x</xmin></bndbox></part>";
  folder.write("Annotations/a.xml", "\xEF\xBB\xBF" + voc("<!-- <object> -->" + voc_object(sound_bounds) +
                                                         "<object a='1>' b = \"2\"><name> R&amp;B </name>" +
                                                         part + "<difficult>1</difficult><pose/><bndbox>" +
                                                         sound_bounds + "</bndbox></object>"));
  const auto dataset = evaluate::read_voc(folder.path());
  CHECK(dataset.class_names == std::vector<std::string>{"R&B", "car"});
  REQUIRE(dataset.pictures.size() == 1);
  const auto objects = evaluate::objects_in_pixels(dataset.pictures[0], 30, 40);
  REQUIRE(objects.size() == 2);
  check_box(objects[0].box, 10, 5, 20, 10);
  CHECK(objects[0].class_index == 1);
  CHECK(objects[0].area == 50);
  CHECK_FALSE(objects[0].is_difficult);
  CHECK(objects[1].is_difficult);
  folder.write("Annotations/b.xml", voc(""));
  CHECK_THROWS_WITH(evaluate::read_voc(folder.path()),
                    contains("b.xml: labels of a picture that has others"));
  CHECK_THROWS_WITH(evaluate::read_voc(folder.path(), folder.path("x")), contains("a picture is missing"));
}

TEST_CASE("N27: XML that makes no sense, or is not needed for labels, is refused with the line",
          "[io][dataset]") {
  const std::string open = "<annotation>\n<filename>a.png</filename>\n";
  std::string deep;
  for (int i = 0; i < 20; ++i) deep += "<a>";
  const auto bounds = [](const std::string& xmin, const std::string& xmax) {
    return voc(voc_object("<xmin>" + xmin + "</xmin><ymin>6</ymin><xmax>" + xmax + "</xmax><ymax>10</ymax>"));
  };
  check_bad_files(
      {{"nothing", "", malformed, "1", "expected '<', found the end"},
       {"text", "xmin", malformed, "1", "not the XML of labels; expected '<', found 'xmin'"},
       {"cut in an element", open + "<size>", malformed, "3",
        "XML ends early; expected </size>, found the end"},
       {"cut in a name", open + "<si", malformed, "3", "expected '>', found the end"},
       {"cut in a comment", open + "<!-- ", malformed, "3", "expected --> of a comment, found the end"},
       {"cut in an attribute", "<annotation a='", malformed, "1", "expected ' of an attribute"},
       {"crossed", open + "</size>", malformed, "3", "element is closed by another; expected </annotation>"},
       {"behind", voc("") + "<a/>", malformed, "7", "text behind the outermost element"},
       {"document type", "<!DOCTYPE a [<!ENTITY b 'c'>]><annotation/>", malformed, "1", "expected a name"},
       {"CDATA", "<annotation><![CDATA[a]]></annotation>", malformed, "1", "expected a name, found '![CDATA"},
       {"entity", "<annotation>&b;</annotation>", malformed, "1", "unknown entity"},
       {"deep", deep, malformed, "1", "nested too deep; expected at most 16 levels"},
       {"zero byte", std::string("<annotation>\0", 13), malformed, "1", "zero byte"},
       {"a page", "<html></html>", malformed, "1", "not labels of Pascal VOC; expected <annotation>"},
       {"no size", open + "</annotation>", malformed, "1", "expected one <size> in it, found 0"},
       {"two names", open + "<filename>b</filename></annotation>", malformed, "1",
        "expected one <filename> in it, found 2"},
       {"a long name", "<annotation><filename>" + std::string(5000, '/') + "</filename></annotation>",
        malformed, "1", "<filename> is too long; expected at most 4096 bytes, found 5000"},
       {"above", "<annotation><filename>../b</filename></annotation>", malformed, "1",
        "<filename> lies outside the folder of the pictures; expected a name in it, found '../b'"},
       {"absolute", "<annotation><filename>/b</filename></annotation>", malformed, "1",
        "<filename> lies outside"},
       {"empty name", "<annotation><filename> </filename></annotation>", malformed, "1",
        "<filename> makes no sense; expected a text, found none"},
       {"no width", voc("", "<width>0</width><height>30</height>"), malformed, "4",
        "<width> makes no sense; expected a number from 1 to 1048576, found '0'"},
       {"no box", voc("<object><name>car</name></object>"), malformed, "5", "expected one <bndbox> in it"},
       {"no class", voc(voc_object(sound_bounds, "")), malformed, "5", "expected one <name> in it"},
       {"NaN", bounds("nan", "20"), malformed, "6", "<xmin> makes no sense"},
       {"negative extent", bounds("21", "20"), malformed, "6", "<bndbox> of negative extent"},
       {"a word", bounds("11", "far"), malformed, "6", "<xmax> makes no sense"}},
      "a.xml", [](const std::string& text) { (void)evaluate::parse_voc(text, "a.xml"); });
}

TEST_CASE("N26, N27: every cut is refused, and every changed byte is read or refused", "[io][dataset]") {
  const TemporaryFolder folder;
  folder.write("a.png", "");
  const std::string json = coco(a_picture, annotation("1", "[1, 2, 3, 4]", R"(, "iscrowd": 0)"), cats);
  const std::string xml = voc(voc_object(sound_bounds));
  const auto read = [&](const std::string& text, bool is_json) {
    if (is_json)
      (void)evaluate::parse_coco(text, "a", folder.path());
    else
      (void)evaluate::parse_voc(text, "a");
  };
  for (const bool is_json : {true, false}) {
    const std::string& whole = is_json ? json : xml;
    for (std::size_t size = 0; size + 1 < whole.size(); ++size)
      CHECK_THROWS_AS(read(whole.substr(0, size), is_json), FileError);
    for (std::size_t i = 0; i < whole.size(); ++i)
      for (const char byte : {'\0', ' ', '<', '/', '"', '9', '-', '\xff'}) {
        std::string changed = whole;
        changed[i] = byte;
        try {
          read(changed, is_json);
        } catch (const FileError& error) {
          REQUIRE(error.details().path == "a");
        }
      }
  }
}
