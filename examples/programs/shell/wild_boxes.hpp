#pragma once
#include <tapestry/detect/box_decode.hpp>

namespace tapestry::shell {
/// Counts boxes that no object has: the centre lies outside the picture, or the box is larger than the
/// picture by half, or thinner than a quarter of a pixel. Outputs that are misread have such boxes.
class WildBoxes {
 public:
  /// \param height, width  of the picture whose pixels the boxes are in
  void add(const std::vector<detect::Detection>& detections, std::size_t height, std::size_t width) {
    const auto is_wild = [](double centre, double extent, std::size_t side) {
      const auto most = static_cast<double>(side);
      return centre < 0 || centre > most || extent > 1.5 * most || extent < 0.25;
    };
    all_ += detections.size();
    for (const detect::Detection& one : detections)
      if (is_wild(one.box.cx, one.box.w, width) || is_wild(one.box.cy, one.box.h, height)) ++wild_;
  }

  /// A sentence about them if more than half are wild; else empty.
  [[nodiscard]] std::string word() const {
    if (2 * wild_ <= all_) return "";
    return std::to_string(wild_) + " of " + std::to_string(all_) +
           " boxes lie outside the picture, or have extents that no object has; are the outputs what "
           "--detector, a description or --decode states?";
  }

 private:
  std::size_t all_ = 0, wild_ = 0;
};
}  // namespace tapestry::shell
