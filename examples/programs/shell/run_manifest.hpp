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

// The file manifest.json of a run holds the options, the hashes of the inputs, and the facts of
// computed_by().

std::string manifest_path(const std::string& folder);

/// \param program      whose run it is
/// \param input_paths  every file that the run reads
Json make_manifest(const std::string& program, const Json& settings, std::uint64_t seed, bool held_out,
                   const std::vector<std::string>& input_paths);

/// Options and inputs, which a checkpoint must agree with.
std::string identity_text(const Json& manifest);

/// Versions that differ in their last number only know each other's runs.
/// \throws FileError (mismatch) for the run of another program or version
void require_same_program(const std::string& program, const Json& manifest, const std::string& folder);

/// Reads the manifest of the run in a folder.
/// Takes memory of at most 64 times the file and 1 MiB.
/// \throws FileError: malformed (not the manifest of a run), mismatch (of another program or version)
Json read_manifest(const std::string& folder, const std::string& program = "camouflage");

/// An input whose bytes are not those that were recorded.
struct ChangedInput {
  std::string path{};
  std::string expected{};  ///< SHA-256 as recorded; empty if the file was no input
  std::string found{};     ///< SHA-256 as the file is now; empty if it is no input any more

  bool operator==(const ChangedInput&) const = default;
};

/// Differences between two results of input_hashes(): in the order of paths those that are other or new, then
/// those that are gone.
std::vector<ChangedInput> changed_inputs(const Json& recorded, const Json& now);

/// The first ten of them, with the beginnings of their hashes.
std::string text_of(const std::vector<ChangedInput>& changed);

/// \throws Error (in_use) unless the run in a folder has the inputs of this manifest
void require_same_inputs(const Json& manifest, const std::string& folder);

}  // namespace tapestry::shell
