#pragma once
#include <tapestry/detect/detector.hpp>
#include "catch.hpp"
#include "paths.hpp"
#include "raw_numbers.hpp"

namespace tapestry::test {
/// Calls check(folder) unless the exports are missing.
template <class Check>
void with_export(const char* name, Check check) {
  const std::filesystem::path folder = in_shared(std::string("data/exports/") + name);
  if (std::filesystem::exists(folder))
    check(folder);
  else
    WARN("skipped: no exports in TAPESTRY_SHARED");
}

/// The picture that the framework was given.
template <class T>
Array<T, 4> picture_of(const detect::Detector<T>& detector, const std::filesystem::path& folder) {
  const std::size_t height = detector.input_height(), width = detector.input_width();
  const auto planes = raw_numbers<float>(folder / "in.bin");
  Array<T, 4> picture(Extents<4>{1, height, width, 3});
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < height * width; ++i)
      picture.data()[3 * i + c] = static_cast<T>(planes[c * height * width + i]);
  return picture;
}

/// Checks that each of the framework's results is among the detections.
/// \param counts_classes  whether labels must be the detector's, too
inline void require_results(const std::filesystem::path& folder, const std::vector<detect::Detection>& found,
                            bool counts_classes) {
  const auto boxes = raw_numbers<double>(folder / "out.0.bin"),
             scores = raw_numbers<double>(folder / "out.1.bin");
  const auto labels = counts_classes ? raw_numbers<double>(folder / "out.2.bin") : std::vector<double>{};
  REQUIRE(!scores.empty());
  std::size_t there = 0;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const auto is_same = [&](const detect::Detection& one) {
      const auto& box = one.box;
      return std::abs(one.confidence - scores[i]) <= 1e-5 &&
             (!counts_classes || static_cast<double>(one.class_index) == labels[i]) &&
             std::abs(box.cx - (boxes[4 * i] + boxes[4 * i + 2]) / 2) <= 1e-3 &&
             std::abs(box.cy - (boxes[4 * i + 1] + boxes[4 * i + 3]) / 2) <= 1e-3 &&
             std::abs(box.w - (boxes[4 * i + 2] - boxes[4 * i])) <= 1e-3 &&
             std::abs(box.h - (boxes[4 * i + 3] - boxes[4 * i + 1])) <= 1e-3;
    };
    if (std::ranges::any_of(found, is_same)) ++there;
  }
  CHECK(there == scores.size());
}
}  // namespace tapestry::test
