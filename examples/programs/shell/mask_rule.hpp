#pragma once
#include <tapestry/io/frame_file.hpp>
#include <tapestry/segment/u2_net.hpp>
#include "settings.hpp"

namespace tapestry::shell {
/// Roles of inputs in ledgers, see io::InputLedger::Role.
inline constexpr const char *mask_role = "mask", *segmenter_role = "segmenter";

/// Source of the mask of a frame, see --mask.
struct MaskRule {
  std::string kind = "auto";
  std::shared_ptr<const segment::U2Net> segmenter{};  ///< of the kind u2net
};

/// \param settings complete, with bundled files filled in
/// \param warnings receives warnings about the segmenter
/// \throws FileError as read_onnx() and U2Net
MaskRule load_mask_rule(const SceneSettings& settings, std::vector<std::string>& warnings);

/// Path of the mask of dataN.npz or dataN.json: masks/dataN.png beside it or beside its folder, else
/// maskN.png beside it.
std::string mask_path_of(const std::string& frame);

/// Warning of a mask file of other extents than its frame; empty for other rules and for one that fits.
/// \param path  of the frame
/// \throws FileError as read_mask()
std::string word_on_masks(const MaskRule& rule, const std::string& path, const io::Frame& frame);

/// Replaces the mask of a frame as the rule requires.
/// \param path  of the frame; mask files lie beside it
void apply_mask_rule(const MaskRule& rule, const std::string& path, io::Frame& frame);
}  // namespace tapestry::shell
