#pragma once
#include <cstddef>
#include <cstdint>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <vector>

#include "measurement.hpp"
#include "report.hpp"

namespace tapestry::shell {

/// What a survey shows: colours, [texel, 3], and the sheets that collect the pictures drawn of them.
struct SurveyedTexture {
  const Array<float, 2>* colours = nullptr;
  std::vector<Bitmap>* sheet = nullptr;  ///< none when null
};

/// Measures the untouched frames, the car in its own colours, the camouflage unless its colours are null, and
/// the controls, all in the usable views.
/// \throws Stopped when a signal arrives meanwhile
inline RunReport survey(Meter& meter, camouflage::ViewStore<float>& store,
                        const std::vector<std::size_t>& usable, const SurveyedTexture& clean,
                        const SurveyedTexture& adversarial, std::uint64_t seed) {
  const auto controls = make_controls(clean.colours->shape(0), seed);
  const bool has_camouflage = adversarial.colours != nullptr;
  meter.announce((2 + (has_camouflage ? 1 : 0) + controls.size()) * usable.size());
  RunReport report;
  report.photo = measure("photo", meter, store, usable, nullptr);
  report.clean = measure("clean", meter, store, usable, clean.colours, clean.sheet);
  if (has_camouflage) {
    report.adversarial = measure("adversarial", meter, store, usable, adversarial.colours, adversarial.sheet);
    report.asr = evaluate::attack_success_rate(report.clean.found, report.adversarial->found);
  }
  for (const auto& control : controls)
    report.controls.push_back(measure(control.name, meter, store, usable, &control.colours));
  return report;
}

}  // namespace tapestry::shell
