#include "run_origin.hpp"

#include <tapestry/core/instruction_set.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::shell {
namespace {
namespace fs = std::filesystem;

constexpr const char* set_variable = "TAPESTRY_INSTRUCTION_SET";

/// Options that name files or folders, or may.
constexpr std::string_view path_options[] = {"mesh",     "faces",   "frames",   "segmenter",    "cfg",
                                             "weights",  "names",   "detector", "palette",      "start",
                                             "ensemble", "dataset", "images",   "dataset-names"};

std::string text_in(const Json& json, const char* name) {
  const Json found = json.is_object() ? json.value(name, Json()) : Json();
  return found.is_string() ? found.get<std::string>() : std::string();
}

bool has_hash(const std::string& path, const std::string& sha256) {
  try {
    return io::RegularFile(path).sha256() == sha256;
  } catch (const FileError&) {
    return false;
  }
}

/// The manifest of a run, members in their order, to be written again.
Json ordered_manifest(const std::string& run) {
  const std::string path = manifest_path(run), text = io::read_text_file(path);
  (void)io::read_json(text, path);  // checks it
  return Json::parse(text);
}

/// Number of a run's inputs with relative paths that a folder holds; one file of each folder is looked at.
std::size_t inputs_below(const fs::path& folder, const Json& inputs) {
  std::size_t count = 0;
  fs::path last("/");
  for (const Json& input : inputs) {
    const fs::path path = io::path_of(input["path"].get<std::string>());
    if (path.is_absolute() || path.parent_path() == last) continue;
    last = path.parent_path();
    if (has_hash((folder / path).string(), text_in(input, "sha256"))) ++count;
  }
  return count;
}
}  // namespace

Json begun_in(const std::string& run) {
  Json places = Json::object();
  const fs::path here = fs::current_path();
  std::error_code failure;
  const auto add = [&](const char* name, const std::string& path) {
    if (io::utf8_prefix(path) == path.size() && !path.empty()) places[name] = path;
  };
  add("folder", here.string());
  add("from_run", fs::relative(here, io::path_of(run), failure).string());
  return places;
}

std::string path_of_work(const std::string& folder, const Json& kept, const std::string& path) {
  const Json places = kept.value("begun_in", Json());
  std::error_code failure;
  for (const fs::path& start :
       {place_of(folder) / io::path_of(text_in(places, "from_run")), io::path_of(text_in(places, "folder"))})
    if (const fs::path found = start / io::path_of(path); places.is_object() && fs::exists(found, failure))
      return fs::equivalent(found, io::path_of(path), failure) ? path : found.lexically_normal().string();
  return path;
}

std::string go_where_it_began(const std::string& run, const std::string& program,
                              const std::vector<std::string*>& paths) {
  if (run.empty() || !is_there(manifest_path(run), ErrorKind::malformed)) return {};
  const Json manifest = read_manifest(run, program);
  const Json places = manifest.value("begun_in", Json());
  const fs::path here = fs::current_path();
  fs::path best = here;
  std::size_t most = inputs_below(here, manifest["inputs"]);
  for (const fs::path& folder :
       {place_of(run) / io::path_of(text_in(places, "from_run")), io::path_of(text_in(places, "folder"))}) {
    const std::size_t count = folder.empty() ? 0 : inputs_below(folder, manifest["inputs"]);
    if (count > most) best = folder, most = count;
  }
  std::error_code failure;
  if (best == here || fs::equivalent(best, here, failure)) return {};
  for (std::string* const path : paths)
    if (!path->empty()) *path = fs::absolute(io::path_of(*path)).lexically_normal().string();
  fs::current_path(best);
  return fs::current_path().string();
}

void adopt_instruction_set(const std::string& path) {
  const char* const chosen = std::getenv(set_variable);
  if ((chosen != nullptr && *chosen != '\0') || !is_there(path, ErrorKind::malformed)) return;
  const std::string name = text_in(read_json_file(path), "instruction_set");
  for (const auto set : instruction_sets())
    if (name_of(set) == name) platform::set_variable(set_variable, name);
}

std::string other_facts(const Json& manifest, const std::vector<std::string>& facts) {
  const Json own = computed_by_json();
  std::string text;
  for (const std::string& fact : facts) {
    const std::string was = text_in(manifest, fact.c_str()), now = text_in(own, fact.c_str());
    if (!was.empty() && was != now)
      text += (text.empty() ? "" : ", ") + fact + " (was " + was + ", now " + now + ")";
  }
  return text;
}

std::string differences(const Json& was, const Json& now, const std::vector<std::string>& members,
                        const Json& lacking) {
  std::string text;
  const auto compare = [&](const std::string& name, const Json& before, const Json& after) {
    if (before != after)
      text += (text.empty() ? "" : ", ") + name + " (was " + before.dump() + ", now " + after.dump() + ")";
  };
  for (const auto& fact : facts_of_bits) compare(fact, was.value(fact, now[fact]), now[fact]);
  for (const auto& member : members) compare(member, was.value(member, Json()), now.value(member, Json()));
  const Json before = was.value("options", Json::object()), after = now["options"];
  const auto option = [&](const Json& of, const std::string& name) {
    return of.value(name, lacking.value(name, Json()));
  };
  for (const auto& [name, value] : after.items()) compare("--" + name, option(before, name), value);
  for (const auto& [name, value] : before.items())
    if (!after.contains(name)) compare("--" + name, value, option(after, name));
  const auto changed = changed_inputs(was.value("inputs", Json::array()), now["inputs"]);
  return text.empty() && !changed.empty() ? "inputs: " + text_of(changed) : text;
}

std::string record_resumption(const std::string& run) {
  Json manifest = ordered_manifest(run);
  auto facts = facts_of_bits;
  facts.emplace_back("commit");
  const std::string other = other_facts(manifest, facts);
  if (other.empty()) return {};
  Json& resumed_by = manifest["resumed_by"];
  if (resumed_by.empty() || resumed_by.back() != computed_by_json()) resumed_by.push_back(computed_by_json());
  write_text(manifest_path(run), exact_text(manifest) + "\n");
  return run + " goes on by another build, whose bits may be others: " + other;
}

void require_inputs_of_run(const Json& options, const std::string& run, const Json& manifest,
                           const std::string& remedy) {
  const auto is_read = [&](const std::string& path) {
    const std::string below = path.ends_with('/') ? path : path + "/";
    return std::ranges::any_of(manifest["inputs"], [&](const Json& input) {
      const auto name = input["path"].get<std::string>();
      return name == path || name.starts_with(below);
    });
  };
  for (const auto& [name, value] : options.items()) {
    if (std::ranges::count(path_options, name) == 0) continue;
    for (const Json& path : value.is_array() ? value : Json::array({value}))
      if (path.is_string() && path != "" && is_read(path) && !is_there(path, ErrorKind::malformed)) {
        const std::string folder = text_in(manifest.value("begun_in", Json()), "folder");
        throw malformed_file({path, "",
                              "not there; it is --" + name + " of " + run +
                                  (folder.empty() ? "" : ", which began in " + folder) + "; " + remedy});
      }
  }
}

void record_outputs(const std::string& run, const std::function<bool(const std::string&)>& is_output) {
  Json manifest = ordered_manifest(run), hashes = Json::object();
  for (const std::string& path :
       io::listed_paths(run, [&](const fs::path& file) { return is_output(file.filename().string()); }))
    hashes[io::path_of(path).filename().string()] = io::RegularFile(path).sha256();
  manifest["outputs"] = std::move(hashes);
  write_text(manifest_path(run), exact_text(manifest) + "\n");
}

std::vector<std::string> warnings_about_outputs(const std::string& run, const std::string& compared) {
  const Json outputs = read_json_file(manifest_path(run)).value("outputs", Json());
  if (!outputs.is_object())
    return {manifest_path(run) + " states no hashes of what the run wrote, so its paint was not compared"};
  std::vector<std::string> warnings;
  for (const auto& [name, hash] : outputs.items()) {
    const std::string path = run + "/" + name;
    if (name != compared && hash.is_string() && is_there(path) && !has_hash(path, hash))
      warnings.push_back(path + " is not the file that the run wrote, of SHA-256 " +
                         hash.get<std::string>().substr(0, 16));
  }
  return warnings;
}
}  // namespace tapestry::shell
