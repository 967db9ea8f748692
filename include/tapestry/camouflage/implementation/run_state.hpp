#pragma once
#include <tapestry/camouflage/run_state.hpp>
#include <tapestry/io/npy.hpp>

namespace tapestry::camouflage {
namespace detail {
inline ObjectiveTerms terms_of(const double* row) {
  ObjectiveTerms terms;
  for (const auto& term : ObjectiveTerms::all) terms.*term.value = *row++;
  return terms;
}

/// Whether the numbers are finite, squares not negative, and all lists of the required length.
template <std::floating_point T>
void require_sound_state(const std::string& path, const TrainingState<T>& state) {
  const auto require = [&](const char* name, std::span<const T> values, double lowest) {
    if (values.size() != state.parameter.size())
      throw file_mismatch({path, "", std::string(name) + " does not fit the parameter",
                           std::to_string(state.parameter.size()) + " values",
                           std::to_string(values.size())});
    for (const T value : values)
      if (!(std::isfinite(value) && static_cast<double>(value) >= lowest))
        throw malformed_file({path, "", std::string(name) + " holds what no training comes to",
                              lowest < 0 ? "finite numbers" : "finite numbers of at least 0",
                              std::to_string(value)});
  };
  constexpr double any = std::numeric_limits<double>::lowest();
  require("parameter", {state.parameter.data(), state.parameter.size()}, any);
  require("adam_first_moment", state.adam.first_moment, any);
  require("adam_second_moment", state.adam.second_moment, 0);
  if (state.adam.step != state.step)
    throw file_mismatch({path, "", "adam_step does not fit the step number", std::to_string(state.step),
                         std::to_string(state.adam.step)});
}
}  // namespace detail

template <std::floating_point T>
void write_checkpoint(const std::string& path, const TrainingState<T>& state, const std::string& settings) {
  Array<double, 2> history(Extents<2>{state.history.size(), detail::history_columns});
  for (std::size_t i = 0; i < state.history.size(); ++i)
    for (std::size_t j = 0; j < detail::history_columns; ++j)
      history(i, j) = state.history[i].*ObjectiveTerms::all[j].value;
  io::NpzWriter file;
  file.add("format", checkpoint_format);
  file.add("settings", std::string_view(settings));
  file.add("step", state.step);
  file.add("parameter", state.parameter);
  file.add("adam_step", state.adam.step);
  file.add("adam_first_moment", state.adam.first_moment);
  file.add("adam_second_moment", state.adam.second_moment);
  file.add("history", history);
  file.write(path);
}

template <std::floating_point T>
Checkpoint<T> read_checkpoint(const std::string& path) {
  const auto file = io::NpzFile::read(path);
  const auto number = [&](const char* name) {
    const auto values = file.get(name).template as<std::uint64_t>();
    if (values.size() != 1) throw file_mismatch({path, "", std::string(name) + " is not one number"});
    return values.front();
  };
  const std::uint64_t format = number("format");
  if (format != checkpoint_format)
    throw file_mismatch({path, "", "checkpoint of another format", std::to_string(checkpoint_format),
                         std::to_string(format)});
  Checkpoint<T> checkpoint;
  const auto settings = file.get("settings").template as<std::uint8_t>();
  checkpoint.settings.assign(settings.begin(), settings.end());
  auto& state = checkpoint.state;
  state.step = number("step");
  state.parameter = file.template array<T, 2>("parameter");
  state.adam.step = number("adam_step");
  state.adam.first_moment = file.get("adam_first_moment").template as<T>();
  state.adam.second_moment = file.get("adam_second_moment").template as<T>();
  detail::require_sound_state(path, state);
  const auto history = file.template array<double, 2>("history");
  if (history.shape(0) != state.step || history.shape(1) != detail::history_columns)
    throw file_mismatch({path, "", "history does not fit the step number"});
  state.history.reserve(history.shape(0));
  for (std::size_t i = 0; i < history.shape(0); ++i)
    state.history.push_back(detail::terms_of(history.data() + i * detail::history_columns));
  return checkpoint;
}
}  // namespace tapestry::camouflage
