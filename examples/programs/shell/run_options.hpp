#pragma once
#include "program.hpp"
#include "progress.hpp"
#include "run_origin.hpp"
#include "settings.hpp"
#include "stop_signal.hpp"

namespace tapestry::shell {
/// Options of every program that works in its own folder and can be resumed there.
struct RunOptions {
  std::string output;
  std::size_t checkpoint_steps = 50;
  std::size_t keep_mib = 4096;
  std::uint64_t memory_mib = 0;
  bool resume = false;
  bool accepts_other_build = false;
};

inline void add_resume_options(CLI::App& app, RunOptions& options) {
  app.option_defaults()->group("Run");
  app.add_flag("--resume", options.resume,
               "continue the run in --output; settings not given are taken from it");
  app.add_flag("--accept-other-build", options.accepts_other_build,
               "resume although version, compiler or instruction set differ from the run's, which is refused "
               "otherwise; the bits are then other ones, and the manifest states both");
}

/// \param folder prefix of the names of run folders if no folder is given
inline void add_run_options(CLI::App& app, RunOptions& options, const std::string& folder) {
  app.option_defaults()->group("Run");
  app.add_option("--output", options.output, "run folder; " + folder + "-001, -002, ... when left out");
  add_threads_option(app, "threads; 0: all cores. Results do not depend on it");
  app.add_option("--checkpoint-steps", options.checkpoint_steps, "steps between checkpoints");
  app.add_option("--keep-mib", options.keep_mib,
                 "memory for prepared views, MiB; those beyond are prepared anew");
  app.add_option("--memory-mib", options.memory_mib,
                 "most memory of the process, MiB; 0: seven eighths of the machine's. A run that needs more "
                 "ends with an error, before it begins where that is foreseen");
  add_resume_options(app, options);
}

inline void require_sound_run(const RunOptions& options, ProblemList& list) {
  list.require(options.checkpoint_steps > 0, "--checkpoint-steps must be at least 1");
  list.require(options.keep_mib <= std::size_t(1) << 24U, "--keep-mib must be at most 16777216");
  list.require(options.memory_mib <= std::size_t(1) << 24U, "--memory-mib must be at most 16777216");
}

/// Requires that the folder holds no run, unless the run is resumed.
/// \throws Error (in_use) otherwise
inline void require_free_folder(const RunOptions& options) {
  if (!options.resume && !options.output.empty() && is_there(manifest_path(options.output), ErrorKind::write))
    throw Error(ErrorKind::in_use,
                options.output + " already holds a run; give --resume to go on with it, or another --output");
}

/// Claims a run's folder, which no ledger counts as an input: without --output the next new one of `base`.
/// \throws as RunFolder and require_free_folder()
[[nodiscard]] inline std::unique_ptr<RunFolder> claim_folder(RunOptions& options, const std::string& base,
                                                             io::InputLedger& ledger) {
  const bool is_new = options.output.empty() || !is_there(options.output, ErrorKind::write);
  if (options.output.empty()) options.output = make_next_folder(base);
  ledger.leave_out(options.output);
  auto folder = std::make_unique<RunFolder>(options.output, is_new);
  require_free_folder(options);  // another process may have begun and ended a run there meanwhile
  return folder;
}

/// Takes over where a run to resume began and its instruction set, see run_origin.hpp. Must be called before
/// anything is recorded or computed.
inline void take_over_run(RunOptions& options, const std::string& program) {
  limit_memory(options.memory_mib);
  if (!options.resume || options.output.empty()) return;
  const auto folder = go_where_it_began(options.output, program, {&options.output});
  if (!folder.empty()) remark("paths of the run start in " + folder);
  adopt_instruction_set(manifest_path(options.output));
}

/// Reads the settings of a run to resume from its folder.
///
/// \param program  that must have made the run
/// \throws Error   usage without a folder, in_use naming settings that were given and differ, or the build;
///                FileError (malformed) if there is no sound manifest, or an input is gone
template <class... Settings>
void adopt_run_settings(const CLI::App& app, const RunOptions& options, const std::string& program,
                        Settings&... settings) {
  if (options.output.empty()) throw Error(ErrorKind::usage, "--resume needs --output, the folder of the run");
  const std::string path = manifest_path(options.output);
  const Json saved = read_manifest(options.output, program);
  std::vector<std::string> differing;
  (adopt_saved(app, saved["options"], path, settings, differing), ...);
  if (!differing.empty())
    throw Error(ErrorKind::in_use,
                options.output + ": cannot resume with other settings: " + listed(differing));
  const std::string build = other_facts(saved, facts_of_bits);
  if (!build.empty() && !options.accepts_other_build)
    throw Error(ErrorKind::in_use, options.output + ": cannot resume to the same bits: " + build +
                                       "; --accept-other-build goes on to other ones");
  require_inputs_of_run(json_of_settings(settings...), options.output, saved,
                        "put it there, or begin a new run");
}

/// Writes a new run's manifest, with its start folder; notes in a resumed run's the continuing process.
inline void open_manifest(Json manifest, const std::string& run, bool resumed) {
  if (resumed) {
    if (const auto warning = record_resumption(run); !warning.empty()) print_warnings({warning});
    return;
  }
  manifest["begun_in"] = begun_in(run);
  write_text(manifest_path(run), exact_text(manifest) + "\n");
}

/// Writes the manifest of a run to its new folder; checks that a folder to resume holds one that agrees.
/// \param output  file of the run that must not exist yet
/// \returns the run's identity_text()
inline std::string open_run(const RunOptions& options, const std::string& program, const Json& settings,
                            std::uint64_t seed, bool held_out, const std::string& output) {
  const std::string path = options.output + "/" + output;
  Json manifest = make_manifest(program, settings, seed, held_out);
  if (options.resume) require_same_inputs(manifest, options.output);
  if (!options.resume && is_there(path, ErrorKind::write))
    throw Error(ErrorKind::in_use, path + " is there already; give another --output");
  std::string identity = identity_text(manifest);
  open_manifest(std::move(manifest), options.output, options.resume);
  return identity;
}

/// The command that resumes a run; settings come from the manifest, including those in `adopted`.
inline std::string resume_line(const CLI::App& app, const char* program, const RunOptions& options,
                               const Json& settings, std::vector<std::string> adopted = {}) {
  std::vector<std::string> words{program, "--resume", "--output", options.output};
  adopted.insert(adopted.end(), {"resume", "output"});
  for (const auto& setting : settings.items()) adopted.push_back(setting.key());
  for (auto& word : given_options(app, adopted)) words.push_back(std::move(word));
  return shell_line(words);
}

/// Takes the remaining steps of a work. Saves at intervals, at the end and when a signal arrives.
/// \param work  has step(), finished(), steps_taken() and step_count(), as camouflage::Training
/// \throws Stopped after saving
template <class Work, class Save, class Text>
void take_steps(Work& work, std::size_t checkpoint_steps, Save save, Text text) {
  using Clock = std::chrono::steady_clock;
  ProgressLine progress;
  const auto start = Clock::now();
  const auto first = static_cast<double>(work.steps_taken());
  while (!work.finished()) {
    try {
      work.step();
    } catch (const Stopped&) {
      save();
      throw;
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const auto done = static_cast<double>(work.steps_taken());
    const double left = static_cast<double>(work.step_count()) - done;
    progress.show(text() + ", " + duration_text(seconds / std::max(1.0, done - first) * left) + " left",
                  work.finished());
    const bool is_due =
        work.finished() || StopSignal::arrived() || work.steps_taken() % checkpoint_steps == 0;
    if (is_due) save();
    StopSignal::throw_if_arrived();
  }
}

/// Runs `body`, and prints the command that resumes it if a signal stops it.
///
/// \param saved called after a stop; returns text about what was saved, may be empty
/// \returns      the exit code
template <class Body, class Saved>
int run_resumable(const std::string& folder, const std::string& resume_line, Body body, Saved saved) {
  try {
    body();
    return 0;
  } catch (const Stopped&) {
    const bool has_begun = is_there(manifest_path(folder), ErrorKind::write);
    std::cerr << '\n' << (has_begun ? "stopped" : "stopped before the first step; nothing was written");
    std::cerr << saved();
    if (has_begun) std::cerr << ". Resume with\n  " << resume_line;
    std::cerr << '\n';
    return StopSignal::exit_code();
  }
}
}  // namespace tapestry::shell
