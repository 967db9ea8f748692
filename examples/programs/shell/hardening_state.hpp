#pragma once
#include <tapestry/camouflage/training.hpp>
#include <tapestry/io/npy.hpp>
#include <tapestry/optim/adam.hpp>

#include "hardening_pictures.hpp"

namespace tapestry::shell {

/// One step of the weights, as history.csv lists it: terms of the training loss, and the last loss of the
/// round's paint.
struct HardeningStep {
  double box = 0, objectness = 0, classification = 0, total = 0, attack = 0;

  struct Number {
    const char* name;
    double HardeningStep::*value;
  };
  static const std::array<Number, 5> all;
};
inline constexpr std::array<HardeningStep::Number, 5> HardeningStep::all{
    {{"box", &HardeningStep::box},
     {"objectness", &HardeningStep::objectness},
     {"classification", &HardeningStep::classification},
     {"total", &HardeningStep::total},
     {"attack", &HardeningStep::attack}}};

/// Everything that changes while a detector is hardened. Two runs with equal states and settings continue
/// with the same bits.
struct HardeningState {
  std::uint64_t done = 0;               ///< steps of all rounds, those of the paint alone included
  Array<float, 1> parameters;           ///< of the detector
  optim::AdamState<float> adam;         ///< of the detector's parameters
  Array<float, 2> paint;                ///< the round's texture parameter, [texel, 3]
  optim::AdamState<float> attack;       ///< of the paint
  std::vector<Array<float, 2>> paints;  ///< colours of finished rounds
  std::vector<HardeningStep> history;   ///< one entry a step of the weights
};

namespace detail {
inline constexpr std::uint64_t hardening_format = 1;

/// \throws FileError (mismatch) unless two sizes agree
inline void require_size(const std::string& path, const std::string& what, std::size_t expected,
                         std::size_t found) {
  if (expected != found)
    throw FileError(ErrorKind::mismatch, {path, "", what + " does not fit the run", std::to_string(expected),
                                          std::to_string(found)});
}

inline void add_adam(io::NpzWriter& file, const std::string& name, const optim::AdamState<float>& adam) {
  file.add(name + "_step", adam.step);
  file.add(name + "_first_moment", adam.first_moment);
  file.add(name + "_second_moment", adam.second_moment);
}

inline std::uint64_t number_of(const io::NpzFile& file, const std::string& name) {
  const auto values = file.get(name).as<std::uint64_t>();
  require_size(file.path(), name, 1, values.size());
  return values.front();
}

/// The values of a member, all finite.
inline std::vector<float> finite_values(const io::NpzFile& file, const std::string& name, std::size_t count,
                                        float least = std::numeric_limits<float>::lowest()) {
  auto values = file.get(name).as<float>();
  require_size(file.path(), name, count, values.size());
  for (const float value : values)
    if (!(std::isfinite(value) && value >= least))
      throw FileError(ErrorKind::malformed,
                      {file.path(), "", name + " holds what no training comes to",
                       least < 0 ? "finite numbers" : "finite numbers of at least 0", std::to_string(value)});
  return values;
}

inline optim::AdamState<float> adam_of(const io::NpzFile& file, const std::string& name, std::size_t count) {
  return {finite_values(file, name + "_first_moment", count),
          finite_values(file, name + "_second_moment", count, 0), number_of(file, name + "_step")};
}
}  // namespace detail

/// Writes the checkpoint; the previous one survives any interruption.
/// \param identity  of the run, see identity_text()
inline void write_hardening(const std::string& path, const HardeningState& state,
                            const std::string& identity) {
  Array<float, 3> paints(Extents<3>{state.paints.size(), state.paint.shape(0), 3});
  for (std::size_t i = 0; i < state.paints.size(); ++i)
    std::copy_n(state.paints[i].data(), state.paint.size(), paints.data() + i * state.paint.size());
  Array<double, 2> history(Extents<2>{state.history.size(), 5});
  for (std::size_t i = 0; i < state.history.size(); ++i) {
    std::size_t column = 0;
    for (const auto& number : HardeningStep::all) history(i, column++) = state.history[i].*number.value;
  }
  io::NpzWriter file;
  file.add("format", detail::hardening_format);
  file.add("settings", std::string_view(identity));
  file.add("done", state.done);
  file.add("parameters", state.parameters);
  detail::add_adam(file, "adam", state.adam);
  file.add("paint", state.paint);
  detail::add_adam(file, "attack", state.attack);
  file.add("paints", paints);
  file.add("history", history);
  file.write(path);
}

/// \param fresh  initial state; the checkpoint must have its extents
/// \throws FileError: malformed (damaged, or numbers that no training reaches), mismatch (a newer format, or
///         other extents); Error (in_use) for the checkpoint of a run with other settings
inline HardeningState read_hardening(const std::string& path, const std::string& identity,
                                     const HardeningState& fresh) {
  const auto file = io::NpzFile::read(path);
  const auto format = detail::number_of(file, "format");
  if (format != detail::hardening_format)
    throw FileError(ErrorKind::mismatch, {path, "", "checkpoint of another format",
                                          std::to_string(detail::hardening_format), std::to_string(format)});
  const auto settings = file.get("settings").as<std::uint8_t>();
  if (std::string(settings.begin(), settings.end()) != identity)
    throw Error(ErrorKind::in_use, path + ": belongs to a run with other settings");
  HardeningState state = fresh;
  state.done = detail::number_of(file, "done");
  const auto parameters = file.get("parameters").as<float>();
  detail::require_size(path, "parameters", fresh.parameters.size(), parameters.size());
  for (std::size_t i = 0; i < parameters.size(); ++i)  // settings of operators may be infinite
    if (!std::isfinite(parameters[i]) && parameters[i] != fresh.parameters(i))
      throw FileError(ErrorKind::malformed, {path, "", "parameters holds what no training comes to",
                                             "finite numbers", std::to_string(parameters[i])});
  std::copy(parameters.begin(), parameters.end(), state.parameters.data());
  state.adam = detail::adam_of(file, "adam", fresh.parameters.size());
  const auto paint = detail::finite_values(file, "paint", fresh.paint.size());
  std::copy(paint.begin(), paint.end(), state.paint.data());
  state.attack = detail::adam_of(file, "attack", fresh.paint.size());
  const auto paints = file.array<float, 3>("paints");
  detail::require_size(path, "paints", paints.shape(0) * fresh.paint.size(), paints.size());
  for (std::size_t i = 0; i < paints.shape(0); ++i) {
    state.paints.push_back(fresh.paint);
    std::copy_n(paints.data() + i * fresh.paint.size(), fresh.paint.size(), state.paints.back().data());
  }
  const auto history = file.array<double, 2>("history");
  detail::require_size(path, "history", 5 * history.shape(0), history.size());
  for (std::size_t i = 0; i < history.shape(0); ++i)
    state.history.push_back({history(i, 0), history(i, 1), history(i, 2), history(i, 3), history(i, 4)});
  return state;
}

}  // namespace tapestry::shell
