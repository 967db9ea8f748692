#pragma once
#include <string>
#include <tapestry/detect/detector.hpp>
#include <tapestry/io/read_detector.hpp>
#include <vector>

#include "settings.hpp"

namespace tapestry::shell {

/// io::read_detector() of the files that options name.
///
/// A detector of 80 classes without names gets the names of COCO and a warning, unless --class is a number.
/// \param warnings  takes remarks on the files
/// \param layers    as DetectorFiles::layers
/// \throws Error (usage) for options that do not go together
[[nodiscard]] detect::Detector<float> load_detector(const DetectorSettings& settings,
                                                    std::vector<std::string>& warnings,
                                                    const std::vector<std::string>& layers = {});

}  // namespace tapestry::shell
