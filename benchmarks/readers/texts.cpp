// JSON and what is written in it, and labels of pictures.
#include <memory>
#include <tapestry/evaluate/dataset/readers.hpp>
#include <tapestry/io/text_lists.hpp>

#include "../../examples/programs/shell/config_file.hpp"
#include "../../examples/programs/shell/run_manifest.hpp"
#include "kind.hpp"

namespace tapestry::benchmarks {
namespace {
/// `entry` again and again between brackets.
std::function<std::string(std::size_t)> list_of(const std::string& entry) {
  return [=](std::size_t bytes) {
    return filled(
        bytes, "[", [&](std::size_t) { return entry + ","; }, "]", 1);
  };
}
void read_json(const std::string& path) { (void)io::read_json(io::read_text_file(path), path); }

std::string nested(const std::string& open, const std::string& close, std::size_t levels) {
  std::string text;
  for (std::size_t i = 0; i < levels; ++i) text += open;
  text += "0";
  for (std::size_t i = 0; i < levels; ++i) text += close;
  return text;
}

/// An object of many members: the limit is 131,072 of them.
std::string members(std::size_t bytes) {
  return filled(
      bytes, "{",
      [](std::size_t i) { return std::string("\"") + std::to_string(i) + std::string(60, 'k') + "\":0,"; },
      "}", 1);
}

std::string annotations(std::size_t bytes) {
  return filled(
      bytes,
      R"({"images":[{"id":1,"file_name":"/proc/self/exe","width":9,"height":9}],"categories":[{"id":1,"name":"a"}],)"
      R"("annotations":[)",
      [](std::size_t i) {
        return std::string("{\"id\":") + std::to_string(i) +
               R"(,"image_id":1,"category_id":1,"bbox":[0,0,1,1]},)";
      },
      "]}", 1);
}
std::string pictures(std::size_t bytes) {
  return filled(
      bytes, R"({"categories":[],"annotations":[],"images":[)",
      [](std::size_t i) {
        return std::string("{\"id\":") + std::to_string(i) +
               R"(,"file_name":"/proc/self/exe","width":9,"height":9},)";
      },
      "]}", 1);
}
void read_coco(const std::string& path) { (void)evaluate::read_coco(path, "/"); }

const std::string voc_beginning =
    "<annotation><filename>a</filename><size><width>9</width><height>9</height></size>";
void read_voc(const std::string& path) { (void)evaluate::parse_voc(io::read_text_file(path), path); }
std::string objects(std::size_t bytes) {
  const std::string object =
      "<object><name>a</name><bndbox><xmin>1</xmin><ymin>1</ymin><xmax>2</xmax><ymax>2</ymax></bndbox></"
      "object>";
  return filled(
      bytes, voc_beginning, [&](std::size_t) { return object; }, "</annotation>");
}
std::string elements(std::size_t bytes) {
  return filled(
      bytes, voc_beginning, [](std::size_t) { return std::string("<a/>"); }, "</annotation>");
}
std::string entities(std::size_t bytes) {
  return filled(
      bytes, voc_beginning, [](std::size_t) { return std::string("&lt;"); }, "</annotation>");
}

std::string labels(std::size_t bytes) {
  return filled(bytes, "", [](std::size_t) { return std::string("0 0 0 1 1\n"); });
}
void read_labels(const std::string& path) {
  (void)evaluate::parse_yolo_labels(io::read_text_file(path), path, 1);
}

std::string manifest(std::size_t bytes) {
  shell::Json json = shell::make_manifest("camouflage", {{"seed", 1}}, 1, true);
  json.erase("inputs");
  std::string beginning = json.dump();
  beginning.back() = ',';
  return filled(
      bytes, beginning + "\"inputs\":[",
      [](std::size_t i) { return std::string("{\"path\":\"") + std::to_string(i) + "\"},"; }, "]}", 1);
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
std::string colours(std::size_t bytes) {
  return filled(bytes, "", [](std::size_t i) {
    return i < 4096 ? std::string("0 0 0\n") : "#" + std::string(1000, ' ') + "\n";
  });
}
void read_colours(const std::string& path) { (void)io::read_palette(path); }

std::string option_words(std::size_t bytes) {
  return filled(
      bytes, "words = [", [](std::size_t) { return std::string("1,"); }, "]\n", 1);
}
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
          {"json: members", members, read_json, times_file(48)},
          {"coco: annotations", annotations, read_coco, times_file(48)},
          {"coco: pictures", pictures, read_coco, times_file(48)},
          {"voc: objects", objects, read_voc, times_file(64), 4},
          {"voc: elements", elements, read_voc, times_file(64), 4},
          {"voc: entities", entities, read_voc, times_file(64), 4},
          {"yolo labels", labels, read_labels, times_file(16), 4},
          {"manifest: inputs", manifest, read_manifest, times_file(64)},
          {"palette", colours, read_colours, times_file(3), 1},
          {"options: words", option_words, read_options, times_file(100), 1}};
}

}  // namespace tapestry::benchmarks
