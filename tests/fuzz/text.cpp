// JSON and files in JSON, labels of pictures, a run's manifest, and options in a file.
#include <tapestry/evaluate/dataset/readers.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/text_lists.hpp>

#include "../../examples/programs/shell/config_file.hpp"
#include "../../examples/programs/shell/run_manifest.hpp"
#include "target.hpp"

namespace {
using namespace tapestry;
using Texts = std::vector<std::string>;

/// The folder with the picture that data sets name.
std::string pictures() {
  static const std::string picture = fuzz::folder().write("a.png", "");
  return fuzz::folder().path();
}

void read_json(const std::string& bytes) { (void)io::read_json(bytes, "a.json"); }
void read_description(const std::string& bytes) { (void)io::parse_detector_description(bytes, "a.json"); }
void read_coco(const std::string& bytes) { (void)evaluate::parse_coco(bytes, "a.json", pictures()); }
void read_voc(const std::string& bytes) { (void)evaluate::parse_voc(bytes, "a.xml"); }
void read_palette(const std::string& bytes) {
  (void)io::read_palette(fuzz::folder().write("palette.txt", bytes));
}
void read_labels(const std::string& bytes) { (void)evaluate::parse_yolo_labels(bytes, "a.txt", 3); }
void read_manifest(const std::string& bytes) {
  (void)fuzz::folder().write("manifest.json", bytes);
  (void)shell::read_manifest(fuzz::folder().path());
}

/// Options of several kinds, from a file alone.
void read_options(const std::string& bytes) {
  CLI::App app;
  double number = 0;
  bool flag = false;
  std::vector<std::string> words;
  app.add_option("--number", number);
  app.add_option("--words", words);
  app.add_flag("--flag", flag);
  app.set_config("--config");
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.config_formatter(std::make_shared<shell::ConfigFile>());
  const std::string path = fuzz::folder().write("options.toml", bytes);
  try {
    app.parse(std::vector<std::string>{path, "--config"});  // CLI11 takes the last word first
  } catch (const CLI::ParseError& refusal) {
    throw Error(ErrorKind::usage, refusal.what());
  }
}

const Texts json{R"({"a": [1, -2.5e3, true, null, "\u00e9\n"], "b": {"c": [[], {}]}})", "[0.1]", "\"x\""};
const Texts descriptions{
    R"({"head": "nanodet", "strides": [8, 16], "input": {"order": "bgr", "scale": 1, "mean": [1, 2, 3.5],)"
    R"( "std": [57, 57, 58], "fit": "letterbox", "fill": 114}})"};
const Texts instances{
    R"({"images": [{"id": 7, "file_name": "a.png", "width": 40, "height": 30}], "annotations": [{"id": 1,)"
    R"( "image_id": 7, "category_id": 3, "bbox": [1, 2, 3.5, 4], "area": 9, "iscrowd": 0}],)"
    R"( "categories": [{"id": 3, "name": "car"}]})"};
const Texts annotations{
    "<?xml version=\"1.0\"?>\n<!-- one -->\n<annotation>\n<filename>a.png</filename>\n<size><width>40</width>"
    "<height>30</height></size>\n<object><name>car &amp; van</name><difficult>0</difficult>\n<bndbox><xmin>11"
    "</xmin><ymin>6</ymin><xmax>20</xmax><ymax>10</ymax></bndbox></object>\n</annotation>\n"};
const Texts labels{"1 0.5 0.25 0.5 0.5\r\n\n 0 0 1 1e-3 1 \n"};
const Texts colours{"# inks\n0 0.5 1\r\n\n1,1, 1e-3\n"};
const Texts options{"# one\nnumber = 3.5\nwords = [\"a\",\n 'b c']\nflag = true\n",
                    "words = x\n; two\nflag\n"};

Texts manifests() {
  return {shell::report_text(shell::make_manifest("camouflage", {{"seed", 1}, {"frames", "a b"}}, 1, true))};
}

const fuzz::Registered targets[]{
    fuzz::Registered({"json", read_json, [] { return json; }}),
    fuzz::Registered({"description", read_description, [] { return descriptions; }}),
    fuzz::Registered({"coco", read_coco, [] { return instances; }}),
    fuzz::Registered({"voc", read_voc, [] { return annotations; }}),
    fuzz::Registered({"yolo_labels", read_labels, [] { return labels; }}),
    fuzz::Registered({"palette", read_palette, [] { return colours; }}),
    fuzz::Registered({"manifest", read_manifest, manifests}),
    fuzz::Registered({"options", read_options, [] { return options; }})};
}  // namespace
