#pragma once
#include "../protocol/inputs.hpp"
#include "../protocol/result.hpp"
#include "../run_origin.hpp"
#include "same_content.hpp"

namespace tapestry::shell {
struct MeasuredFolder {
  std::string path;
  Protocol protocol;
  evaluate::ProtocolOutcomes outcomes;
  std::vector<std::string> textures;        ///< names, as in ProtocolResult
  std::string run;                          ///< folder of the camouflage's run; empty without one
  std::string detector{};                   ///< name of the first
  std::vector<MeasuredContent> contents{};  ///< by detector
  std::set<std::pair<std::string, std::string>> made_by{};  ///< facts of the builds that measured and made it

  [[nodiscard]] bool has_camouflage() const {
    return std::ranges::find(textures, "adversarial") != textures.end();
  }
};

namespace detail {
/// The member of a JSON object with this type.
/// \throws FileError (malformed) if there is none
template <class Value>
Value member_of(const Json& json, const char* name, const std::string& path) {
  try {
    return json.at(name).get<Value>();
  } catch (const nlohmann::json::exception&) {
    throw malformed_file({path, "", std::string("no ") + name + " of a measurement"});
  }
}

/// Appends one vector to another.
template <class Value>
void append(std::vector<Value>& all, const std::vector<Value>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// Settings of a measurement, as evaluate writes them.
struct SavedMeasurement {
  ProtocolSettings settings;
  std::uint64_t seed = 1;
  std::vector<std::string> weights{};  ///< of every detector, the run's own first
  std::string run{};
  std::vector<MeasuredContent> contents{};  ///< by detector

  [[nodiscard]] ProtocolSubject subject() const {
    return subject_of(weights, contents.front().frames.size());
  }
  [[nodiscard]] Protocol protocol() const {
    return protocol_by_name(settings.protocol).make(settings, seed, subject());
  }
};

/// The files of a ledger that were read in a role, in the order of their paths.
inline ReadFiles files_read_as(const std::string& role, const Json& inputs, const std::string& path) {
  ReadFiles files;
  for (const Json& input : inputs) {
    ReadFile file{member_of<std::string>(input, "path", path), member_of<std::string>(input, "sha256", path)};
    const Json roles = input.value("read_as", Json::array());
    if (std::ranges::count(roles, Json(role)) > 0) files.push_back(std::move(file));
  }
  return files;
}

/// Sorted by content: the order of such files does not matter.
inline ReadFiles by_content(ReadFiles files) {
  std::ranges::sort(files, {}, &ReadFile::sha256);
  return files;
}

inline ReadFiles files_of(const Json& list, const std::string& path) {
  ReadFiles files;
  for (const Json& file : list)
    files.push_back(
        {member_of<std::string>(file, "path", path), member_of<std::string>(file, "sha256", path)});
  return files;
}

/// Values of a measurement that tables compare, by detector.
/// \throws FileError (malformed) for a measurement whose ledger has no roles, as older versions wrote it
inline std::vector<MeasuredContent> contents_of(const Json& json, const SavedMeasurement& saved,
                                                const std::string& path) {
  const auto inputs = member_of<Json>(json, "inputs", path);
  const auto read_as = [&](const char* role) { return files_read_as(role, inputs, path); };
  MeasuredContent shared{
      io::path_of(path).parent_path().string(), {{"protocol", saved.settings.protocol}}, Json::object()};
  add_options(shared, member_of<Json>(json, "options", path), is_on_photographs(saved.settings.protocol));
  shared.frames = read_as(frame_role);
  shared.masks = read_as(mask_role);
  append(shared.masks, read_as(segmenter_role));
  shared.mesh = by_content(read_as(mesh_role));
  if (json.contains("run")) {
    const auto run = member_of<Json>(json, "run", path);
    shared.attacked = by_content(files_of(member_of<Json>(run, "detectors", path), path));
    shared.picture["class of the run"] = run.value("class", Json());
    shared.camouflage = run.value("seed", Json()).dump();
  }
  const auto paint = read_as(camouflage_role);  // whatever its seed: equal paints are one
  if (!paint.empty()) shared.camouflage.clear();
  for (const auto& texture : paint) shared.camouflage += texture.sha256;
  const auto require_any = [&](const ReadFiles& files, const std::string& role) {
    if (files.empty())
      throw malformed_file(
          {path, "", "its ledger does not tell what was read as " + role + "; measure it again"});
  };
  if (json.contains("run")) require_any(shared.attacked, "detector by its run");
  std::vector<MeasuredContent> contents;
  for (std::size_t i = 0; i < saved.weights.size(); ++i) {
    contents.push_back(shared);
    const std::string role = role_of_detector(i == 0 ? "" : saved.weights[i]);
    contents.back().detector = by_content(files_read_as(role, inputs, path));
    require_any(contents.back().detector, role);
  }
  return contents;
}

/// \param json  its settings
/// \param path  of their file
inline SavedMeasurement saved_measurement(const Json& json, const std::string& path) {
  const auto options = member_of<Json>(json, "options", path);
  SavedMeasurement saved;
  saved.settings.protocol = member_of<std::string>(json, "protocol", path);
  saved.settings.quick = member_of<bool>(options, "quick", path);
  saved.seed = member_of<std::uint64_t>(options, "seed", path);
  if (options.contains("noise-draws"))
    saved.settings.noise_draws = member_of<std::size_t>(options, "noise-draws", path);
  saved.weights = {member_of<std::string>(options, "weights", path)};
  if (options.contains("further-weights"))
    for (auto& weights : member_of<std::vector<std::string>>(options, "further-weights", path))
      saved.weights.push_back(std::move(weights));
  if (json.contains("run"))
    saved.run = path_of_work(io::path_of(path).parent_path().string(), json,
                             member_of<std::string>(member_of<Json>(json, "run", path), "folder", path));
  saved.contents = contents_of(json, saved, path);
  return saved;
}

/// The facts that a measurement's report and the manifest of its run state of the programs that made them.
inline std::set<std::pair<std::string, std::string>> facts_of(const Json& report, const Json& manifest) {
  std::set<std::pair<std::string, std::string>> facts;
  const auto add = [&](const Json& of) {
    for (const char* fact : {"commit", "version", "compiler", "instruction_set"})
      if (const Json value = of.is_object() ? of.value(fact, Json()) : Json(); value.is_string())
        facts.emplace(fact, value.get<std::string>());
  };
  add(report.value("computed_by", Json()));
  add(manifest);
  for (const Json& later : manifest.is_object() ? manifest.value("resumed_by", Json::array()) : Json::array())
    add(later);
  return facts;
}

/// \throws FileError (mismatch) if a measured paint, unless that was accepted, is not the
/// one that its run has written
inline void require_paint_of_run(const Json& settings, const std::string& run, const Json& manifest,
                                 const std::string& path) {
  const Json outputs = manifest.is_object() ? manifest.value("outputs", Json()) : Json();
  const Json written = outputs.is_object() ? outputs.value("texture.npz", Json()) : Json();
  const Json changed = settings.value("changed_inputs", Json::array());
  for (const auto& file : files_read_as(camouflage_role, settings["inputs"], path))
    if (written.is_string() && written != file.sha256 &&
        !std::ranges::any_of(changed,
                             [&](const Json& input) { return input.value("path", "") == file.path; }))
      throw file_mismatch({path, "", "measured a " + file.path + " that is not of " + run,
                           "SHA-256 " + written.get<std::string>(), "SHA-256 " + file.sha256});
}
}  // namespace detail

/// Reads the folder of a finished measurement.
/// \throws FileError: unreadable, malformed, or mismatch if its files do not belong together
inline MeasuredFolder read_measured_folder(const std::string& folder) {
  require_file_of(folder, "settings.json", "evaluate --protocol");
  const std::string path = folder + "/settings.json";
  const Json settings = read_json_file(path);
  const auto saved = detail::saved_measurement(settings, path);
  MeasuredFolder measured{folder, {}, {}, {}, saved.run};
  const std::string report = folder + "/" + saved.settings.protocol + ".json";
  const Json written = read_json_file(report);
  measured.textures = detail::member_of<std::vector<std::string>>(written, "textures", report);
  const bool has_run = !saved.run.empty() && is_there(manifest_path(saved.run), ErrorKind::malformed);
  const Json manifest = has_run ? read_json_file(manifest_path(saved.run)) : Json();
  measured.made_by = detail::facts_of(written, manifest);
  detail::require_paint_of_run(settings, saved.run, manifest, path);
  const auto noise = std::ranges::find(measured.textures, std::string(evaluate::matched_noise_name));
  const std::size_t extra_draws = noise == measured.textures.end() ? 0 : saved.settings.noise_draws - 1;
  measured.detector = saved.subject().detectors.front();
  measured.contents = saved.contents;
  measured.protocol = saved.protocol();
  measured.outcomes = read_outcomes(folder + "/outcomes.npz", measured.protocol.frames.size(),
                                    measured.textures.size() + extra_draws);
  measured.outcomes.draws.assign(measured.textures.size(), 1);
  if (noise != measured.textures.end())
    measured.outcomes.draws[static_cast<std::size_t>(noise - measured.textures.begin())] += extra_draws;
  return measured;
}
}  // namespace tapestry::shell
