#pragma once
#include <functional>
#include "run_manifest.hpp"

namespace tapestry::shell {
// Sets the facts that decide a run's bits besides its options. Relative paths of its settings start where it
// began, and its instruction set is taken over, wherever this processor has it. Differences that remain are
// named: --resume, which promises the run's bits, refuses them unless they are accepted; a measurement warns.

/// The folder where this process works, for the manifest of a run: the absolute path, and the path from the
/// run's own folder, which stays right where both are moved together.
Json begun_in(const std::string& run);

/// Resolves a path kept in a folder's file from here: relative to the folder where that work began, now or
/// then, see begun_in(); else unchanged.
std::string path_of_work(const std::string& folder, const Json& kept, const std::string& path);

/// Enters the folder where a run began if it holds more of the run's inputs, by their hashes, than the
/// current folder. Nothing happens without a manifest.
/// \param paths  relative to the current folder; made absolute, except empty ones
/// \returns      the new folder; empty if it is the current one
/// \throws FileError as read_manifest()
std::string go_where_it_began(const std::string& run, const std::string& program,
                              const std::vector<std::string*>& paths);

/// Takes over the instruction set that a manifest or a measurement's settings state, unless the environment
/// names one or this processor lacks it. Must be called before anything is computed.
/// \param path  of the file; nothing happens where there is none
void adopt_instruction_set(const std::string& path);

/// Facts of computed_by() that decide the last bits; the commit seldom changes them.
inline const std::vector<std::string> facts_of_bits{"version", "compiler", "instruction_set"};

/// Adds the facts of this process to the manifest of a run that it resumes, if they differ.
/// \returns  a warning; empty if they are the same
std::string record_resumption(const std::string& run);

/// Facts of this process that differ from those in a manifest: "compiler (was 12.2.0, now 13.1.0)".
std::string other_facts(const Json& manifest, const std::vector<std::string>& facts);

/// Differences between what two works of one program keep: facts of the bits, some members, options or, if
/// all of these are equal, inputs.
/// \param lacking  values of options that one of them lacks
std::string differences(const Json& was, const Json& now, const std::vector<std::string>& members = {},
                        const Json& lacking = Json::object());

/// \param options   settings of a run as they are used
/// \param remedy    last words of the message
/// \throws FileError (malformed) for the first input of the run that is not there, naming its option
void require_inputs_of_run(const Json& options, const std::string& run, const Json& manifest,
                           const std::string& remedy);

/// Adds the hashes of the files in a run's folder that the run has written to its manifest.
/// \param is_output  by the file's name
void record_outputs(const std::string& run, const std::function<bool(const std::string& name)>& is_output);

/// Warnings about files in a run's folder that the run has not written, except `compared`.
std::vector<std::string> warnings_about_outputs(const std::string& run, const std::string& compared);
}  // namespace tapestry::shell
