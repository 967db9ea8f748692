// JSON and what is written in it, and labels of pictures.
#include <tapestry/evaluate/dataset/readers.hpp>
#include <tapestry/io/text_lists.hpp>

#include "../../examples/programs/shell/config_file.hpp"
#include "../../examples/programs/shell/run_manifest.hpp"
#include "kind.hpp"

namespace tapestry::benchmarks {
namespace {
/// `entry` again and again between brackets.
std::function<std::string(std::size_t)> list_of(const std::string& entry) {
  return filled("[", entry + ",", "]", 1);
}
void read_json(const std::string& path) { (void)io::read_json(io::read_text_file(path), path); }

std::string nested(const std::string& open, const std::string& close, int levels) {
  return repeated(open, levels) + "0" + repeated(close, levels);
}

const std::string annotations_beginning =
    R"({"images":[{"id":1,"file_name":"/proc/self/exe","width":9,"height":9}],"categories":[{"id":1,"name":"a"}],)"
    R"("annotations":[)";
void read_coco(const std::string& path) { (void)evaluate::read_coco(path, "/"); }

const std::string voc_beginning =
    "<annotation><filename>a</filename><size><width>9</width><height>9</height></size>";
void read_voc(const std::string& path) { (void)evaluate::parse_voc(io::read_text_file(path), path); }
const std::string voc_object =
    "<object><name>a</name><bndbox><xmin>1</xmin><ymin>1</ymin><xmax>2</xmax><ymax>2</ymax></bndbox></"
    "object>";

void read_labels(const std::string& path) {
  (void)evaluate::parse_yolo_labels(io::read_text_file(path), path, 1);
}

std::string manifest(std::size_t bytes) {
  shell::Json json = shell::make_manifest("camouflage", {{"seed", 1}}, 1, true);
  json.erase("inputs");
  std::string beginning = json.dump();
  beginning.back() = ',';
  return filled(beginning + "\"inputs\":[", numbered("{\"path\":\"", "\"},"), "]}", 1)(bytes);
}
/// With inputs of its own that the manifest lacks.
void read_manifest(const std::string& path) {
  const std::string folder = path + ".run";
  std::filesystem::create_directories(folder);
  std::error_code exists;
  std::filesystem::create_hard_link(path, shell::manifest_path(folder), exists);
  const shell::Json saved = shell::read_manifest(folder);
  shell::Json own = shell::Json::array();
  for (int i = 0; i < 2000; ++i) own.push_back({{"path", std::string("own ") + std::to_string(i)}});
  if (shell::changed_inputs(saved["inputs"], own).size() <= own.size())  // all of both have changed
    throw Error(ErrorKind::mismatch, "the manifest has the inputs");
}

/// More than 4,096 colours are refused.
std::string colour(std::size_t i) { return i < 4096 ? "0 0 0\n" : "#" + std::string(1000, ' ') + "\n"; }
void read_colours(const std::string& path) { (void)io::read_palette(path); }

/// The file of --config of a program with one option.
void read_options(const std::string& path) {
  CLI::App app;
  std::vector<std::string> words;
  app.add_option("--words", words);
  app.set_config("--config");
  app.config_formatter(std::make_shared<shell::ConfigFile>());
  app.parse(std::vector<std::string>{path, "--config"});
}
}  // namespace

std::vector<Kind> text_kinds() {
  return {{"json: empty lists", list_of("[]"), read_json, times_file(48)},
          {"json: numbers", list_of("0"), read_json, times_file(48)},
          {"json: objects", list_of("{\"\":0}"), read_json, times_file(48)},
          {"json: words", list_of("\"\""), read_json, times_file(48)},
          {"json: deep", list_of(nested("[", "]", 62)), read_json, times_file(48)},
          {"json: deep objects", list_of(nested("{\"\":", "}", 62)), read_json, times_file(48)},
          // An object of many members: the limit is 131,072 of them.
          {"json: members", filled("{", numbered("\"", std::string(60, 'k') + "\":0,"), "}", 1), read_json,
           times_file(48)},
          {"coco: annotations",
           filled(annotations_beginning,
                  numbered("{\"id\":", R"(,"image_id":1,"category_id":1,"bbox":[0,0,1,1]},)"), "]}", 1),
           read_coco, times_file(48)},
          {"coco: pictures",
           filled(R"({"categories":[],"annotations":[],"images":[)",
                  numbered("{\"id\":", R"(,"file_name":"/proc/self/exe","width":9,"height":9},)"), "]}", 1),
           read_coco, times_file(48)},
          {"voc: objects", filled(voc_beginning, voc_object, "</annotation>"), read_voc, times_file(64), 4},
          {"voc: elements", filled(voc_beginning, "<a/>", "</annotation>"), read_voc, times_file(64), 4},
          {"voc: entities", filled(voc_beginning, "&lt;", "</annotation>"), read_voc, times_file(64), 4},
          {"yolo labels", filled("", "0 0 0 1 1\n"), read_labels, times_file(16), 4},
          {"manifest: inputs", manifest, read_manifest, times_file(64)},
          {"palette", filled("", colour), read_colours, times_file(3), 1},
          {"options: words", filled("words = [", "1,", "]\n", 1), read_options, times_file(100), 1}};
}
}  // namespace tapestry::benchmarks
