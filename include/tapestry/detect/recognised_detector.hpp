#pragma once
#include <optional>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::detect {

/// The description of a known detector, by the shape of what is behind its outputs:
///
///   yolox    three convolutions on each of three grids, of 4, 1 and K filters
///   nanodet  on each of three grids either one convolution of K + 32 filters, with K classes and 32 bins in
///            outputs of their own, or two of K and 32
///
/// Exports of other detectors may look alike; a description by hand goes before this.
[[nodiscard]] std::optional<DetectorDescription> recognised_detector(const nn::NetworkDescription& network);

}  // namespace tapestry::detect
