#pragma once
#include <tapestry/raster/detail/fragment_shader.hpp>

namespace tapestry::raster::detail {
/// The rows of an operator that belong to a band of pixel rows.
template <std::floating_point T>
struct OperatorBand {
  std::vector<std::uint32_t> pixels;
  std::vector<std::uint32_t> entry_counts;
  std::vector<std::uint32_t> texels_of;
  std::vector<T> weights;
  std::vector<Tap> taps;  // taps of the current pixel
  std::size_t pixel = 0;  // the pixel under way

  void reserve(std::size_t pixel_count) {
    pixels.reserve(pixel_count);
    entry_counts.reserve(pixel_count);
    texels_of.reserve(4 * pixel_count);
    weights.reserve(4 * pixel_count);
  }

  /// Ends the current pixel: taps of the same texel become one entry.
  void finish_pixel() {
    if (taps.empty()) return;
    const auto is_before = [](const Tap& a, const Tap& b) { return a.texel < b.texel; };
    if (!std::is_sorted(taps.begin(), taps.end(), is_before))               // one face's taps mostly are
      std::sort(taps.begin(), taps.end(), [](const Tap& a, const Tap& b) {  // one order for every library
        return a.texel != b.texel ? a.texel < b.texel : a.weight < b.weight;
      });
    const std::size_t first = texels_of.size();
    for (std::size_t i = 0; i < taps.size();) {
      double weight = 0;
      const std::size_t texel = taps[i].texel;
      for (; i < taps.size() && taps[i].texel == texel; ++i) weight += taps[i].weight;
      texels_of.push_back(static_cast<std::uint32_t>(texel));
      weights.push_back(static_cast<T>(weight));
    }
    pixels.push_back(static_cast<std::uint32_t>(pixel));
    entry_counts.push_back(static_cast<std::uint32_t>(texels_of.size() - first));
    taps.clear();
  }
};

/// Turns painted fragments into rows of an operator; in a filtered atlas several at a time.
template <std::floating_point T, class Lighting>
class PaintedFragments {
 public:
  PaintedFragments(const FragmentShader<Lighting>& shader, OperatorBand<T>& band)
      : shader_(shader), band_(band), waiting_(shader) {}

  void add(const Fragment& fragment) {
    if (!shader_.filter) {
      begin(fragment.pixel);
      shader_.add_taps(fragment, band_.taps);
      return;
    }
    pixels_[waiting_.count] = fragment.pixel;
    scales_[waiting_.count] = fragment.coverage * shader_.light_of(fragment);
    waiting_.add(fragment);
    if (waiting_.is_full()) add_waiting();
  }

  void finish() {
    if (shader_.filter) add_waiting();
    band_.finish_pixel();
  }

 private:
  void begin(std::size_t pixel) {
    if (pixel != band_.pixel) band_.finish_pixel();
    band_.pixel = pixel;
  }

  void add_waiting() {
    shader_.filter->choose(waiting_.batch, waiting_.count);
    for (std::size_t i = 0; i < waiting_.count; ++i) {
      begin(pixels_[i]);
      shader_.filter->visit_chosen(waiting_.batch, i, [&](const Tap& tap) {
        band_.taps.push_back({tap.texel, tap.weight * scales_[i]});
      });
    }
    waiting_.count = 0;
  }

  const FragmentShader<Lighting>& shader_;
  OperatorBand<T>& band_;
  FilteredFragments<Lighting> waiting_;
  std::array<std::size_t, LookupBatch::size> pixels_;
  std::array<double, LookupBatch::size> scales_;
};
}  // namespace tapestry::raster::detail
