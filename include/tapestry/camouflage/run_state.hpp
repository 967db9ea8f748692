#pragma once
#include <tapestry/camouflage/training.hpp>

namespace tapestry::camouflage {
/// The layout of checkpoint files; a reader refuses others.
inline constexpr std::uint64_t checkpoint_format = 2;

namespace detail {
inline constexpr std::size_t history_columns = ObjectiveTerms::all.size();
}  // namespace detail

/// Writes a checkpoint that NumPy can read too; atomically, so that the previous one survives any
/// interruption. The archive's checksums guard every member.
///
/// \param settings  text that identifies the run's settings, compared on resume
/// \throws FileError (write)
template <std::floating_point T>
void write_checkpoint(const std::string& path, const TrainingState<T>& state, const std::string& settings);

/// Copies of Training::kept_bytes() that write_checkpoint() takes: the state's, and those of NpzWriter.
inline constexpr std::uint64_t checkpoint_copies = 3;

/// Reads a checkpoint.
template <std::floating_point T>
struct Checkpoint {
  TrainingState<T> state;
  std::string settings;
};

/// Takes memory of at most 4 times the file, 24 times its arrays and 1 MiB.
/// \throws FileError: malformed (damaged, or numbers that no training reaches), mismatch (another format, or
///         members that do not fit each other)
template <std::floating_point T>
[[nodiscard]] Checkpoint<T> read_checkpoint(const std::string& path);
}  // namespace tapestry::camouflage
