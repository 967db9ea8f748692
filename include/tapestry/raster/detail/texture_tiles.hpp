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

namespace tapestry::raster {

/// The entries of a TextureOperator in the order of tiles, which are runs of texels, and within a tile in the
/// order of the operator. When adjoints are added up, each tile belongs to one thread, so that threads share
/// nothing.
template <std::floating_point T>
struct TextureTiles {
  /// Entries of one pixel, from the end of the segment before.
  struct Segment {
    std::uint32_t pixel;
    std::uint32_t end;
  };
  std::vector<std::uint32_t> tile_begin;  ///< first segment of each tile, and one more
  std::vector<Segment> segments;
  std::vector<std::uint32_t> texels_of;
  std::vector<T> weights;
};

/// Sorts entries by tiles, in two passes, one to count and one to place: takes about as long as two adjoints.
/// \param picture  TextureOperator, whose texels ascend within each pixel
template <std::floating_point T, class Operator>
[[nodiscard]] TextureTiles<T> texture_tiles(const Operator& picture) {
  // 2¹⁴ texels of float take 192 KiB, which a core's own cache holds; of small textures as many tiles as
  // threads need to share them out evenly.
  constexpr int largest = 14, smallest = 6, tiles_wanted = 6;
  const int bits =
      std::clamp(static_cast<int>(std::bit_width(picture.texel_count)) - tiles_wanted, smallest, largest);
  const std::size_t tiles = (picture.texel_count >> static_cast<unsigned>(bits)) + 1;
  const auto for_each_segment = [&](auto visit) {
    for (std::size_t row = 0; row < picture.pixels.size(); ++row) {
      const std::uint32_t end = picture.row_begin[row + 1];
      for (std::uint32_t i = picture.row_begin[row]; i < end;) {
        const std::uint32_t tile = picture.texels_of[i] >> static_cast<unsigned>(bits), begin = i;
        while (i < end && picture.texels_of[i] >> static_cast<unsigned>(bits) == tile) ++i;
        visit(picture.pixels[row], tile, begin, i);
      }
    }
  };
  TextureTiles<T> result;
  result.tile_begin.assign(tiles + 1, 0);
  std::vector<std::uint32_t> entry(tiles + 1, 0);  // the next one of each tile
  for_each_segment([&](std::uint32_t, std::uint32_t tile, std::uint32_t begin, std::uint32_t end) {
    ++result.tile_begin[tile + 1];
    entry[tile + 1] += end - begin;
  });
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    result.tile_begin[tile + 1] += result.tile_begin[tile];
    entry[tile + 1] += entry[tile];
  }
  std::vector<std::uint32_t> segment(result.tile_begin.begin(), result.tile_begin.end() - 1);
  result.segments.resize(result.tile_begin.back());
  result.texels_of.resize(picture.texels_of.size());
  result.weights.resize(picture.weights.size());
  for_each_segment([&](std::uint32_t pixel, std::uint32_t tile, std::uint32_t begin, std::uint32_t end) {
    std::copy(picture.texels_of.begin() + begin, picture.texels_of.begin() + end,
              result.texels_of.begin() + entry[tile]);
    std::copy(picture.weights.begin() + begin, picture.weights.begin() + end,
              result.weights.begin() + entry[tile]);
    entry[tile] += end - begin;
    result.segments[segment[tile]++] = {pixel, entry[tile]};
  });
  return result;
}

/// Memory that tiles hold.
template <std::floating_point T>
[[nodiscard]] std::size_t memory_bytes(const TextureTiles<T>& tiles) {
  return (tiles.tile_begin.capacity() + tiles.texels_of.capacity()) * sizeof(std::uint32_t) +
         tiles.segments.capacity() * sizeof(typename TextureTiles<T>::Segment) +
         tiles.weights.capacity() * sizeof(T);
}

namespace detail {

/// Adds the entries of all tiles to texels_adjoint: each texel's in the order of the operator.
/// \param light  colour of the light
template <std::floating_point T>
void scatter(const TextureTiles<T>& tiles, const std::array<T, 3>& light, const T* render_adjoint,
             T* texels_adjoint) {
  parallel_for(tiles.tile_begin.size() - 1, [&](std::size_t tile) {
    const std::uint32_t begin = tiles.tile_begin[tile], end = tiles.tile_begin[tile + 1];
    const T* const weights = tiles.weights.data();
    const std::uint32_t* const texels_of = tiles.texels_of.data();
    std::uint32_t i = begin == 0 ? 0 : tiles.segments[begin - 1].end;
    for (std::uint32_t segment = begin; segment < end; ++segment) {
      const auto [index, last] = tiles.segments[segment];
      const T* const pixel = render_adjoint + 3 * std::size_t{index};
      const T red = light[0] * pixel[0], green = light[1] * pixel[1], blue = light[2] * pixel[2];
      for (; i < last; ++i) {
        T* const colour = texels_adjoint + 3 * std::size_t{texels_of[i]};
        colour[0] += weights[i] * red;
        colour[1] += weights[i] * green;
        colour[2] += weights[i] * blue;
      }
    }
  });
}

}  // namespace detail
}  // namespace tapestry::raster
