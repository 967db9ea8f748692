#pragma once
#include <tapestry/segment/car_component.hpp>

namespace tapestry::segment {

Array<std::uint8_t, 2> car_component(const Array<float, 2>& mask, const std::optional<Region>& region,
                                     double threshold) {
  const std::size_t height = mask.shape(0), width = mask.shape(1);
  auto chosen = zeros<std::uint8_t, 2>({height, width});
  std::vector<std::uint8_t> waits(mask.size());
  for (std::size_t i = 0; i < mask.size(); ++i) waits[i] = static_cast<double>(mask.data()[i]) >= threshold;

  const auto lies_in_region = [&](std::size_t pixel) {
    const double x = static_cast<double>(pixel % width) + 0.5, y = static_cast<double>(pixel / width) + 0.5;
    return region && x >= region->left && x < region->right && y >= region->top && y < region->bottom;
  };
  std::vector<std::size_t> piece, best;
  std::size_t best_inside = 0;
  for (std::size_t first = 0; first < mask.size(); ++first) {
    if (waits[first] == 0) continue;
    const auto take = [&](std::size_t pixel) {
      if (waits[pixel] == 0) return;
      waits[pixel] = 0;
      piece.push_back(pixel);
    };
    piece.clear();
    take(first);
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const std::size_t pixel = piece[i], column = pixel % width;
      if (pixel >= width) take(pixel - width);
      if (column > 0) take(pixel - 1);
      if (column + 1 < width) take(pixel + 1);
      if (pixel + width < mask.size()) take(pixel + width);
    }
    const auto inside = static_cast<std::size_t>(std::count_if(piece.begin(), piece.end(), lies_in_region));
    if (region && inside == 0) continue;
    if (inside < best_inside || (inside == best_inside && piece.size() <= best.size())) continue;
    best_inside = inside;
    best.swap(piece);
  }
  for (const std::size_t pixel : best) chosen.data()[pixel] = 1;
  return chosen;
}

double mask_iou(const Array<std::uint8_t, 2>& a, const Array<std::uint8_t, 2>& b) {
  require_shape("mask_iou", "b", b, a.shape());
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a.data()[i] != 0 && b.data()[i] != 0) ++both;
    if (a.data()[i] != 0 || b.data()[i] != 0) ++either;
  }
  return either == 0 ? 1 : static_cast<double>(both) / static_cast<double>(either);
}

}  // namespace tapestry::segment
