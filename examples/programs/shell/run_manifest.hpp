#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/name_numbers.hpp>
#include <tapestry/version.hpp>
#include <utility>
#include <vector>

#include "run_folder.hpp"

namespace tapestry::shell {

// The file manifest.json of a run says what was asked for, and of which inputs.

inline std::string manifest_path(const std::string& folder) { return folder + "/manifest.json"; }

/// \param program      whose run it is
/// \param input_paths  every file that the run reads
inline Json make_manifest(const std::string& program, const Json& settings, std::uint64_t seed, bool held_out,
                          const std::vector<std::string>& input_paths) {
  return {{"program", program},
          {"version", TAPESTRY_VERSION_TEXT},
          {"compiler", __VERSION__},
          {"seed", seed},
          {"options", settings},
          {"held_out", held_out},
          {"inputs", input_hashes(input_paths)}};
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

/// The paths of the inputs in `some` that `others` lack, the first ten of them.
inline std::string names_of_missing(const Json& some, const Json& others) {
  std::string names;
  std::size_t count = 0;
  const auto written = [](const Json& input) {
    return input.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  std::vector<std::string> texts;
  io::NameNumbers known;
  const auto text_of = [&](std::size_t i) -> std::string_view { return texts[i]; };
  for (const auto& input : others) {
    std::string text = written(input);
    if (known.add(text, text_of) == texts.size()) texts.push_back(std::move(text));
  }
  for (const auto& input : some) {
    if (known.find(written(input), text_of) != io::NameNumbers::none) continue;
    if (++count <= 10) names += (names.empty() ? "" : ", ") + input.value("path", std::string("?"));
  }
  return count <= 10 ? names : names + ", ... (" + std::to_string(count) + " in all)";
}

/// \throws Error (in_use) unless the run in a folder has the inputs of this manifest
inline void require_same_inputs(const Json& manifest, const std::string& folder) {
  const Json saved = read_manifest(folder, manifest.value("program", std::string()));
  std::string changed = names_of_missing(manifest["inputs"], saved["inputs"]);
  if (changed.empty()) changed = names_of_missing(saved["inputs"], manifest["inputs"]);
  if (!changed.empty())
    throw Error(ErrorKind::in_use, folder + ": cannot resume, inputs have changed: " + changed);
}

}  // namespace tapestry::shell
