#pragma once
#include <tapestry/camouflage/training.hpp>

#include "checkpoint_file.hpp"
#include "hardening_pictures.hpp"
#include "learner.hpp"

namespace tapestry::shell {

/// One step of the weights, as history.csv lists it: terms of the training loss, and the last loss of the
/// round's paint.
struct HardeningStep : LossTerms {
  double attack = 0;
  static const std::array<StepNumber<HardeningStep>, 5> all;
};
inline constexpr std::array<StepNumber<HardeningStep>, 5> HardeningStep::all{
    {{"box", &HardeningStep::box},
     {"objectness", &HardeningStep::objectness},
     {"classification", &HardeningStep::classification},
     {"total", &HardeningStep::total},
     {"attack", &HardeningStep::attack}}};

/// Everything that changes while a detector is hardened. Two runs with equal states and settings continue
/// with the same bits.
struct HardeningState {
  std::uint64_t done = 0;               ///< steps of all rounds, with steps of the paint alone
  Array<float, 1> parameters;           ///< of the detector
  optim::AdamState<float> adam;         ///< of the detector's parameters
  Array<float, 2> paint;                ///< the round's texture parameter, [texel, 3]
  optim::AdamState<float> attack;       ///< of the paint
  std::vector<Array<float, 2>> paints;  ///< colours of finished rounds
  std::vector<HardeningStep> history;   ///< one entry a step of the weights
};

/// Writes the checkpoint; the previous one survives any interruption.
/// \param identity  of the run, see identity_text()
inline void write_hardening(const std::string& path, const HardeningState& state,
                            const std::string& identity) {
  Array<float, 3> paints(Extents<3>{state.paints.size(), state.paint.shape(0), 3});
  for (std::size_t i = 0; i < state.paints.size(); ++i)
    std::copy_n(state.paints[i].data(), state.paint.size(), paints.data() + i * state.paint.size());
  io::NpzWriter file = begun_checkpoint(identity);
  file.add("done", state.done);
  file.add("parameters", state.parameters);
  detail::add_adam(file, "adam", state.adam);
  file.add("paint", state.paint);
  detail::add_adam(file, "attack", state.attack);
  file.add("paints", paints);
  file.add("history", detail::rows_of(state.history));
  file.write(path);
}

/// \param fresh  initial state; the checkpoint must have its extents
/// \throws FileError: malformed (damaged, or numbers that no training reaches), mismatch (a newer format, or
///         other extents); Error (in_use) for the checkpoint of a run with other settings
inline HardeningState read_hardening(const std::string& path, const std::string& identity,
                                     const HardeningState& fresh) {
  const auto file = read_checkpoint_file(path, identity);
  HardeningState state = fresh;
  state.done = detail::number_of(file, "done");
  state.parameters = detail::weights_of(file, "parameters", fresh.parameters);
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
  state.history = detail::history_of<HardeningStep>(file);
  return state;
}

}  // namespace tapestry::shell
