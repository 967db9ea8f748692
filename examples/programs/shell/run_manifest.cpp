#include "run_manifest.hpp"

#include <tapestry/core/in_quotes.hpp>

namespace tapestry::shell {
std::string manifest_path(const std::string& folder) { return folder + "/manifest.json"; }

Json make_manifest(const std::string& program, const Json& settings, std::uint64_t seed, bool held_out) {
  Json manifest{{"program", program}};
  manifest.update(computed_by_json());
  manifest.update(
      Json{{"seed", seed}, {"options", settings}, {"held_out", held_out}, {"inputs", recorded_inputs()}});
  return manifest;
}

std::string identity_text(const Json& manifest) {
  return exact_text({{"options", manifest["options"]}, {"inputs", manifest["inputs"]}}, -1);
}

void require_same_program(const std::string& program, const Json& manifest, const std::string& folder) {
  const auto text = [&](const char* name) {
    const auto found = manifest.find(name);
    return found != manifest.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  if (text("program") != program)
    throw file_mismatch(
        {manifest_path(folder), "", "the run of another program", program, in_quotes(text("program"))});
  const std::string own = TAPESTRY_VERSION_TEXT;
  const std::string found = text("version");
  if (found.substr(0, found.rfind('.')) != own.substr(0, own.rfind('.')))
    throw file_mismatch({manifest_path(folder), "", "the run of another version", own, in_quotes(found)});
}

Json read_manifest(const std::string& folder, const std::string& program) {
  require_file_of(folder, "manifest.json", program);
  const Json manifest = read_json_file(manifest_path(folder));
  const auto is_input = [](const Json& input) {
    return input.is_object() && input.contains("path") && input["path"].is_string();
  };
  const Json inputs = manifest.is_object() ? manifest.value("inputs", Json()) : Json();
  if (!inputs.is_array() || !std::all_of(inputs.begin(), inputs.end(), is_input) ||
      !manifest.contains("options"))
    throw malformed_file({manifest_path(folder), "", "not the manifest of a run"});
  require_same_program(program, manifest, folder);
  return manifest;
}

std::vector<ChangedInput> changed_inputs(const Json& recorded, const Json& now) {
  const auto hashes_of = [](const Json& inputs) {
    const auto text = [](const Json& input, const char* name) {
      const auto found = input.find(name);
      return found != input.end() && found->is_string() ? found->get<std::string>() : std::string("?");
    };
    std::map<std::string, std::string> hashes;
    for (const auto& input : inputs) hashes.emplace(text(input, "path"), text(input, "sha256"));
    return hashes;
  };
  const auto before = hashes_of(recorded), after = hashes_of(now);
  std::vector<ChangedInput> changed;
  for (const auto& [path, hash] : after) {
    const auto old = before.find(path);
    if (old == before.end() || old->second != hash)
      changed.push_back({path, old == before.end() ? "" : old->second, hash});
  }
  for (const auto& [path, hash] : before)
    if (!after.contains(path)) changed.push_back({path, hash, ""});
  return changed;
}

std::string text_of(const std::vector<ChangedInput>& changed) {
  const auto hash = [](const std::string& sha256) {
    return sha256.empty() ? "none" : "SHA-256 " + sha256.substr(0, 16);
  };
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(changed.size(), 10); ++i)
    text += (text.empty() ? "" : ", ") + changed[i].path + " (expected " + hash(changed[i].expected) +
            ", found " + hash(changed[i].found) + ")";
  return changed.size() <= 10 ? text : text + ", ... (" + std::to_string(changed.size()) + " in all)";
}

void require_same_inputs(const Json& manifest, const std::string& folder) {
  const Json saved = read_manifest(folder, manifest.value("program", std::string()));
  const auto changed = changed_inputs(saved["inputs"], manifest["inputs"]);
  if (!changed.empty())
    throw Error(ErrorKind::in_use, folder + ": cannot resume, inputs have changed: " + text_of(changed));
}
}  // namespace tapestry::shell
