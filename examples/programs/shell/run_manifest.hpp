#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/version.hpp>
#include <vector>

#include "run_folder.hpp"

namespace tapestry::shell {

// The file manifest.json of a run says what was asked for, of which inputs, and what computed it.

inline std::string manifest_path(const std::string& folder) { return folder + "/manifest.json"; }

/// \param program      whose run it is
/// \param input_paths  every file that the run reads
inline Json make_manifest(const std::string& program, const Json& settings, std::uint64_t seed, bool held_out,
                          const std::vector<std::string>& input_paths) {
  Json manifest{{"program", program}};
  manifest.update(computed_by_json());
  manifest.update(Json{
      {"seed", seed}, {"options", settings}, {"held_out", held_out}, {"inputs", input_hashes(input_paths)}});
  return manifest;
}

/// What a checkpoint must agree with: options and inputs.
inline std::string identity_text(const Json& manifest) {
  return exact_text({{"options", manifest["options"]}, {"inputs", manifest["inputs"]}}, -1);
}

/// Versions that differ in their last number only know each other's runs.
/// \throws FileError (mismatch) for the run of another program or version
inline void require_same_program(const std::string& program, const Json& manifest,
                                 const std::string& folder) {
  const auto text = [&](const char* name) {
    const auto found = manifest.find(name);
    return found != manifest.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  if (text("program") != program)
    throw FileError(ErrorKind::mismatch, {manifest_path(folder), "", "the run of another program", program,
                                          in_quotes(text("program"))});
  const std::string own = TAPESTRY_VERSION_TEXT;
  const std::string found = text("version");
  if (found.substr(0, found.rfind('.')) != own.substr(0, own.rfind('.')))
    throw FileError(ErrorKind::mismatch,
                    {manifest_path(folder), "", "the run of another version", own, in_quotes(found)});
}

/// Reads the manifest of the run in a folder.
/// Takes memory of at most 64 times the file and 1 MiB.
/// \throws FileError: malformed (not the manifest of a run), mismatch (of another program or version)
inline Json read_manifest(const std::string& folder, const std::string& program = "camouflage") {
  const Json manifest = read_json_file(manifest_path(folder));
  const auto is_input = [](const Json& input) {
    return input.is_object() && input.contains("path") && input["path"].is_string();
  };
  const Json inputs = manifest.is_object() ? manifest.value("inputs", Json()) : Json();
  if (!inputs.is_array() || !std::all_of(inputs.begin(), inputs.end(), is_input) ||
      !manifest.contains("options"))
    throw FileError(ErrorKind::malformed, {manifest_path(folder), "", "not the manifest of a run"});
  require_same_program(program, manifest, folder);
  return manifest;
}

/// An input whose bytes are not those that were recorded.
struct ChangedInput {
  std::string path{};
  std::string expected{};  ///< SHA-256 as recorded; empty if the file was no input
  std::string found{};     ///< SHA-256 as the file is now; empty if it is no input any more

  bool operator==(const ChangedInput&) const = default;
};

/// What differs between two lists as of input_hashes(): in the order of paths what is other or new, then what
/// is gone.
inline std::vector<ChangedInput> changed_inputs(const Json& recorded, const Json& now) {
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

/// The first ten of them, with the beginnings of their hashes.
inline std::string text_of(const std::vector<ChangedInput>& changed) {
  const auto hash = [](const std::string& sha256) {
    return sha256.empty() ? "none" : "SHA-256 " + sha256.substr(0, 16);
  };
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(changed.size(), 10); ++i)
    text += (text.empty() ? "" : ", ") + changed[i].path + " (expected " + hash(changed[i].expected) +
            ", found " + hash(changed[i].found) + ")";
  return changed.size() <= 10 ? text : text + ", ... (" + std::to_string(changed.size()) + " in all)";
}

/// \throws Error (in_use) unless the run in a folder has the inputs of this manifest
inline void require_same_inputs(const Json& manifest, const std::string& folder) {
  const Json saved = read_manifest(folder, manifest.value("program", std::string()));
  const auto changed = changed_inputs(saved["inputs"], manifest["inputs"]);
  if (!changed.empty())
    throw Error(ErrorKind::in_use, folder + ": cannot resume, inputs have changed: " + text_of(changed));
}

}  // namespace tapestry::shell
