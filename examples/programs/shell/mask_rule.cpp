#include "mask_rule.hpp"

#include <tapestry/io/image_file.hpp>
#include <tapestry/io/input_ledger.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/segment/car_component.hpp>

namespace tapestry::shell {
namespace {
std::string extents_text(std::size_t height, std::size_t width) {
  return std::to_string(width) + "x" + std::to_string(height);
}

/// The mask of a file, 1 where it is not 0. One of other extents, of the same shape, is resampled bilinearly
/// before, as the program of Wang et al. (FCA) does, which widens the mask by up to one of its pixels.
Array<std::uint8_t, 2> mask_from_file(const std::string& path, const io::Frame& frame) {
  const auto grey = io::read_mask(path);
  const std::size_t height = frame.image.shape(0), width = frame.image.shape(1);
  if (grey.shape(0) * width != grey.shape(1) * height)
    throw file_mismatch({path, "", "mask of another shape than its frame", extents_text(height, width),
                         extents_text(grey.shape(0), grey.shape(1))});
  Array<float, 3> values(Extents<3>{grey.shape(0), grey.shape(1), 1});
  std::copy_n(grey.data(), grey.size(), values.data());
  if (grey.shape(0) != height) values = image::resize_bilinear(values, height, width);
  Array<std::uint8_t, 2> mask(Extents<2>{height, width});
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = values.data()[i] > 0 ? 1 : 0;
  return mask;
}

/// The car as segmented by a network, in the box of the frame's label if it has one. If none is found, the
/// mask is empty, and the car of that frame counts as hidden.
Array<std::uint8_t, 2> segmented_mask(const segment::U2Net& segmenter, const io::Frame& frame) {
  std::optional<segment::Region> region;
  if (frame.label) {
    const detect::Box& box = frame.label->box;
    region = {box.cx - box.w / 2, box.cy - box.h / 2, box.cx + box.w / 2, box.cy + box.h / 2};
  }
  return segment::car_component(segmenter(image::from_bytes<float>(frame.image)), region);
}
}  // namespace

MaskRule load_mask_rule(const SceneSettings& settings, std::vector<std::string>& warnings) {
  MaskRule rule{settings.mask};
  if (rule.kind != "u2net") return rule;
  const io::InputLedger::Role role(segmenter_role);
  const auto network = io::read_onnx(settings.segmenter);
  rule.segmenter = std::make_shared<const segment::U2Net>(network);
  if (const auto untrue = nn::untrue_shape(network)) warnings.push_back(*untrue);
  return rule;
}

std::string mask_path_of(const std::string& frame) {
  const std::filesystem::path path = io::path_of(frame), folder = path.parent_path();
  const std::string stem = path.stem().string();
  for (const auto& masks : {folder / "masks", folder / ".." / "masks"})
    if (const auto mask = (masks / io::path_of(stem + ".png")).string(); io::is_there(mask)) return mask;
  return (folder / ("mask" + (stem.starts_with("data") ? stem.substr(4) : stem) + ".png")).string();
}

std::string word_on_masks(const MaskRule& rule, const std::string& path, const io::Frame& frame) {
  if (rule.kind != "file") return {};
  const std::string mask_path = mask_path_of(path);
  const auto mask = io::read_mask(mask_path);
  const auto& picture = frame.image;
  if (mask.shape(0) == picture.shape(0)) return {};
  return mask_path + ": a mask of " + extents_text(mask.shape(0), mask.shape(1)) + " for a frame of " +
         extents_text(picture.shape(0), picture.shape(1)) +
         "; such masks are resampled bilinearly, and all that is not 0 is the car";
}

void apply_mask_rule(const MaskRule& rule, const std::string& path, io::Frame& frame) {
  const io::InputLedger::Role role(mask_role);
  if (rule.kind == "file") frame.mask = mask_from_file(mask_path_of(path), frame);
  if (rule.kind == "u2net") frame.mask = segmented_mask(*rule.segmenter, frame);
  if (rule.kind == "silhouette") frame.mask.reset();
}
}  // namespace tapestry::shell
