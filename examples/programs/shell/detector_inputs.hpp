#pragma once
#include <tapestry/io/read_detector.hpp>
#include "settings.hpp"

namespace tapestry::shell {
/// io::read_detector() of the files that options name.
/// \param warnings receives warnings about the files
/// \param layers    as DetectorFiles::layers
/// \throws Error (usage) for options that do not go together
[[nodiscard]] detect::Detector<float> load_detector(const DetectorSettings& settings,
                                                    std::vector<std::string>& warnings,
                                                    const std::vector<std::string>& layers = {});
}  // namespace tapestry::shell
