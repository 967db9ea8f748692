#pragma once
#include <string>
#include <tapestry/detect/decode_family.hpp>
#include <tapestry/detect/network_config/layer.hpp>
#include <vector>

namespace tapestry::detect {
namespace detail {

/// All heads are of one family with anchors, and those of the family scaled read activations.
void check_decode(const NetworkConfig& config);

}  // namespace detail

/// The decode family of a network's heads; darknet where there is none.
[[nodiscard]] DecodeFamily decode_family_of(const NetworkConfig& config);

/// The same network with heads of this decode family. A cfg that says new_coords=1 is scaled and stays so;
/// one that does not say it leaves the choice open. A [region] is of the family darknet.
///
/// \throws FileError (mismatch) for a family that contradicts new_coords=1 or [region] or has no anchors, and
/// for scaled
///         unless each head reads a convolution with activation=logistic
[[nodiscard]] NetworkConfig with_decode(NetworkConfig config, DecodeFamily family);

/// One remark for each head that puts σ on what has been through it: Darknet computes that, too, but hardly
/// any detector means it.
[[nodiscard]] std::vector<std::string> decode_warnings(const NetworkConfig& config);

}  // namespace tapestry::detect
