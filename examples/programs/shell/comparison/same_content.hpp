#pragma once
#include "../run_folder.hpp"

namespace tapestry::shell {
struct ReadFile {
  std::string path, sha256;

  [[nodiscard]] std::string text() const { return path + " (SHA-256 " + sha256.substr(0, 16) + ")"; }
};

/// Files of one part of a measurement, such as a detector.
using ReadFiles = std::vector<ReadFile>;

/// Facts that must agree for two measurements in one column, or for seeds of one row.
struct MeasuredContent {
  std::string folder;        ///< of the measurement
  Json options;              ///< protocol, class, thresholds and others that all rows share
  Json picture;              ///< further options that the seeds of a row share
  ReadFiles detector{};      ///< weights and all that were read with them
  ReadFiles frames{};        ///< photographs, in their order
  ReadFiles masks{};         ///< their masks, and the network that finds masks
  ReadFiles mesh{};          ///< with its material files
  ReadFiles attacked{};      ///< detectors that the camouflage was optimised against
  std::string camouflage{};  ///< texture, or seed without one; equal only for the same one
};

namespace detail {
/// The first difference between the files that two folders read for the same purpose; empty if the contents
/// are the same, whatever their names.
inline std::string difference(const std::string& folder, const ReadFiles& files, const std::string& other,
                              const ReadFiles& others) {
  if (std::ranges::equal(files, others, {}, &ReadFile::sha256, &ReadFile::sha256)) return {};
  const auto lacking_in = [](const ReadFiles& from, const ReadFiles& in) {
    ReadFiles lacking;
    for (const auto& file : from)
      if (std::ranges::count(in, file.sha256, &ReadFile::sha256) !=
          std::ranges::count(from, file.sha256, &ReadFile::sha256))
        lacking.push_back(file);
    return lacking;
  };
  const auto own = lacking_in(files, others), foreign = lacking_in(others, files);
  if (own.empty() && foreign.empty())
    return folder + " and " + other + " read the same files in another order";
  if (own.empty()) return other + " read " + foreign.front().text() + ", which " + folder + " did not";
  if (foreign.empty()) return folder + " read " + own.front().text() + ", which " + other + " did not";
  const auto name = [](const ReadFile& file) { return io::path_of(file.path).filename(); };
  const auto same_name = std::ranges::find(foreign, name(own.front()), name);
  return folder + " read " + own.front().text() + ", " + other + " read " +
         (same_name == foreign.end() ? foreign.front() : *same_name).text();
}

/// The first option that differs; empty if none does.
inline std::string difference(const std::string& folder, const Json& options, const std::string& other,
                              const Json& others) {
  for (const auto& [name, value] : options.items())
    if (const Json there = others.value(name, Json()); there != value)
      return folder + " has " + name + " " + value.dump() + ", " + other + " has " + there.dump();
  for (const auto& [name, value] : others.items())
    if (!options.contains(name))
      return other + " has " + name + " " + value.dump() + ", " + folder + " has none";
  return {};
}

/// \throws Error (mismatch) with the first difference
template <class Part>
void require_same(const std::string& rows, const MeasuredContent& one, const MeasuredContent& other,
                  Part MeasuredContent::*part) {
  const std::string found = difference(one.folder, one.*part, other.folder, other.*part);
  if (!found.empty()) throw Error(ErrorKind::mismatch, rows + ": " + found);
}

/// \throws Error (mismatch) unless detector, class, thresholds, frames and protocol are the same
inline void require_comparable(const std::string& rows, const MeasuredContent& one,
                               const MeasuredContent& other) {
  require_same(rows, one, other, &MeasuredContent::options);
  for (const auto part : {&MeasuredContent::detector, &MeasuredContent::frames, &MeasuredContent::masks})
    require_same(rows, one, other, part);
}

/// \throws Error (mismatch) unless two measurements are of seeds of one camouflage, measured alike
inline void require_seeds(const std::string& row, const MeasuredContent& one, const MeasuredContent& other) {
  require_comparable(row, one, other);
  require_same(row, one, other, &MeasuredContent::picture);
  for (const auto part : {&MeasuredContent::mesh, &MeasuredContent::attacked})
    require_same(row, one, other, part);
  if (one.camouflage == other.camouflage)
    throw Error(ErrorKind::mismatch, row + ": " + one.folder + " and " + other.folder +
                                         " measured one camouflage, not two of its seeds");
}

/// Options of a measurement that are compared. Paths are not compared: the ledger knows their content.
/// \param on_photographs  whose pictures do not depend on the measurement's seed
inline void add_options(MeasuredContent& content, const Json& options, bool on_photographs) {
  constexpr std::array paths{"mesh",    "faces", "frames",   "segmenter",      "cfg",
                             "weights", "names", "detector", "further-weights"};
  constexpr std::array free{"controls", "noise-draws", "clean-only"};
  constexpr std::array shared{"class",         "confidence", "nms",       "size",
                              "decode",        "fit",        "precision", "mask",
                              "heat-map-kind", "background", "quick",     "detections"};
  const auto is_one_of = [](const auto& names, const std::string& name) {
    return std::ranges::any_of(names, [&](const char* other) { return name == other; });
  };
  for (const auto& [name, value] : options.items()) {
    if (is_one_of(paths, name) || is_one_of(free, name)) continue;
    if (name == "seed" && on_photographs) continue;
    (name == "seed" || is_one_of(shared, name) ? content.options : content.picture)[name] = value;
  }
}
}  // namespace detail
}  // namespace tapestry::shell
