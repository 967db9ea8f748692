#include "mask_rule.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <tapestry/core/error.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/segment/car_component.hpp>

namespace tapestry::shell {
namespace {

Array<std::uint8_t, 2> mask_from_file(const std::string& path, const io::Frame& frame) {
  const auto grey = io::read_mask(path);
  if (grey.shape(0) != frame.image.shape(0) || grey.shape(1) != frame.image.shape(1)) {
    const auto text = [](std::size_t height, std::size_t width) {
      return std::to_string(width) + "x" + std::to_string(height);
    };
    throw FileError(ErrorKind::mismatch,
                    {path, "", "mask of another size than its frame",
                     text(frame.image.shape(0), frame.image.shape(1)), text(grey.shape(0), grey.shape(1))});
  }
  Array<std::uint8_t, 2> mask(grey.shape());
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = grey.data()[i] > 0 ? 1 : 0;
  return mask;
}

/// The car as segmented by a network, in the box of the frame's label if it has one. If none is found, the
/// mask is empty, and the car of that frame counts as hidden.
Array<std::uint8_t, 2> segmented_mask(const segment::U2Net<float>& segmenter, const io::Frame& frame) {
  std::optional<segment::Region> region;
  if (frame.label) {
    const detect::Box& box = frame.label->box;
    region = {box.cx - box.w / 2, box.cy - box.h / 2, box.cx + box.w / 2, box.cy + box.h / 2};
  }
  return segment::car_component(segmenter(image::from_bytes<float>(frame.image)), region);
}

}  // namespace

MaskRule load_mask_rule(const SceneSettings& settings) {
  MaskRule rule{settings.mask};
  if (rule.kind == "u2net")
    rule.segmenter = std::make_shared<const segment::U2Net<float>>(io::read_onnx(settings.segmenter));
  return rule;
}

std::string mask_path_of(const std::string& frame) {
  const std::filesystem::path path(frame);
  std::string stem = path.stem().string();
  if (stem.rfind("data", 0) == 0) stem = stem.substr(4);
  return (path.parent_path() / ("mask" + stem + ".png")).string();
}

void apply_mask_rule(const MaskRule& rule, const std::string& path, io::Frame& frame) {
  if (rule.kind == "file") frame.mask = mask_from_file(mask_path_of(path), frame);
  if (rule.kind == "u2net") frame.mask = segmented_mask(*rule.segmenter, frame);
  if (rule.kind == "silhouette") frame.mask.reset();
}

}  // namespace tapestry::shell
