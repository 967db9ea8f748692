#pragma once
#include <tapestry/evaluate/controls.hpp>

namespace tapestry::shell {
/// The controls that --controls names, see SurveySettings; other parameters as evaluate::make_controls().
inline std::vector<evaluate::Control> measured_controls(const std::string& controls,
                                                        const raster::PaintedMesh& car,
                                                        const camouflage::Paint<float>& paint,
                                                        std::uint64_t seed, std::size_t noise_draws = 1) {
  return controls == "all" ? evaluate::make_controls(car, paint, seed, noise_draws)
                           : evaluate::matched_controls(car, paint, seed, noise_draws);
}
}  // namespace tapestry::shell
