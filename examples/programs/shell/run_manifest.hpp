#pragma once
#include "run_folder.hpp"

namespace tapestry::shell {
// The file manifest.json of a run holds the options, the hashes of the inputs, and the facts of
// computed_by().

std::string manifest_path(const std::string& folder);

/// The manifest of a run, with the files that its ledger has recorded.
/// \param program name of the program that runs
Json make_manifest(const std::string& program, const Json& settings, std::uint64_t seed, bool held_out);

/// Options and inputs; a checkpoint must agree with them.
std::string identity_text(const Json& manifest);

/// Versions that differ only in their last number accept each other's runs.
/// \throws FileError (mismatch) for the run of another program or version
void require_same_program(const std::string& program, const Json& manifest, const std::string& folder);

/// Reads the manifest of the run in a folder. Takes memory of at most 64 times the file and 1 MiB.
/// \throws FileError: malformed (not the manifest of a run), mismatch (of another program or version)
Json read_manifest(const std::string& folder, const std::string& program = "camouflage");

/// An input whose bytes differ from the recorded ones.
struct ChangedInput {
  std::string path{};
  std::string expected{};  ///< SHA-256 as recorded; empty if it was not an input
  std::string found{};     ///< SHA-256 of the file now; empty if it is no longer an input

  bool operator==(const ChangedInput&) const = default;
};

/// Differences between two results of recorded_inputs(), in the order of paths: first those that have changed
/// or are new, then those that are missing.
std::vector<ChangedInput> changed_inputs(const Json& recorded, const Json& now);

/// The first ten changed inputs, with the beginnings of their hashes.
std::string text_of(const std::vector<ChangedInput>& changed);

/// \throws Error (in_use) unless the run in a folder has the inputs of this manifest
void require_same_inputs(const Json& manifest, const std::string& folder);
}  // namespace tapestry::shell
