#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>

namespace tapestry::detect {

/// Which colour a network's first input channel is.
enum class ColourOrder { rgb, bgr };

/// What a network takes for a picture's colours. With a picture in [0, 1] and d_c the deviation,
///
///   input channel c = (255 · scale · (colour that order puts at c) − mean_c) / d_c
///
/// so that scale 1/255 is for networks that were trained on [0, 1] and scale 1 for those on 0 to 255.
struct InputEncoding {
  ColourOrder order = ColourOrder::rgb;
  double scale = 1.0 / 255;
  std::array<double, 3> mean{0, 0, 0};       ///< by input channel
  std::array<double, 3> deviation{1, 1, 1};  ///< by input channel, above 0

  /// The channel of an RGB picture that input channel c shows.
  [[nodiscard]] std::size_t picture_channel(std::size_t c) const {
    return order == ColourOrder::rgb ? c : 2 - c;
  }
  bool operator==(const InputEncoding&) const = default;
};

/// Pixels as a network takes them.
/// \param pictures  [pixel, 3], RGB in [0, 1]
/// \param input     takes as many
template <std::floating_point T>
void encode(const T* pictures, std::size_t pixel_count, const InputEncoding& encoding, T* input) {
  const auto factor = static_cast<T>(255 * encoding.scale);
  std::array<T, 3> mean{}, deviation{};
  for (std::size_t c = 0; c < 3; ++c) {
    mean[c] = static_cast<T>(encoding.mean[c]);
    deviation[c] = static_cast<T>(encoding.deviation[c]);
  }
  const std::size_t first = encoding.picture_channel(0), last = encoding.picture_channel(2);
  constexpr std::size_t block = 16384;
  parallel_for(block_count(pixel_count, block), [&](std::size_t b) {
    const BlockRange range = block_range(b, pixel_count, block);
    for (std::size_t i = 3 * range.begin; i < 3 * range.end; i += 3) {
      input[i] = (factor * pictures[i + first] - mean[0]) / deviation[0];
      input[i + 1] = (factor * pictures[i + 1] - mean[1]) / deviation[1];
      input[i + 2] = (factor * pictures[i + last] - mean[2]) / deviation[2];
    }
  });
}

/// Adds the pullback of encode() to pictures_adjoint, [pixel, 3].
template <std::floating_point T>
void encode_adjoint(const T* input_adjoint, std::size_t pixel_count, const InputEncoding& encoding,
                    T* pictures_adjoint) {
  constexpr std::size_t block = 16384;
  parallel_for(block_count(pixel_count, block), [&](std::size_t b) {
    const BlockRange range = block_range(b, pixel_count, block);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto slope = static_cast<T>(255 * encoding.scale / encoding.deviation[c]);
      const std::size_t to = encoding.picture_channel(c);
      for (std::size_t i = range.begin; i < range.end; ++i)
        pictures_adjoint[3 * i + to] += slope * input_adjoint[3 * i + c];
    }
  });
}

/// Pictures as a network takes them.
/// \param pictures  [N, H, W, 3], RGB in [0, 1]
/// \returns         [N, H, W, 3]
/// \throws ShapeError unless the pictures have three channels
template <std::floating_point T>
[[nodiscard]] Array<T, 4> encoded(const Array<T, 4>& pictures, const InputEncoding& encoding) {
  auto extents = pictures.shape();
  extents[3] = 3;
  require_shape("encoded", "pictures", pictures, extents);
  Array<T, 4> input(extents);
  encode(pictures.data(), input.size() / 3, encoding, input.data());
  return input;
}

/// Adds the pullback of encoded() to pictures_adjoint; both are [N, H, W, 3].
/// \throws ShapeError unless they are of one shape with three channels
template <std::floating_point T>
void encoded_adjoint(const Array<T, 4>& input_adjoint, const InputEncoding& encoding,
                     Array<T, 4>& pictures_adjoint) {
  auto extents = pictures_adjoint.shape();
  extents[3] = 3;
  require_shape("encoded_adjoint", "pictures_adjoint", pictures_adjoint, extents);
  require_shape("encoded_adjoint", "input_adjoint", input_adjoint, extents);
  encode_adjoint(input_adjoint.data(), input_adjoint.size() / 3, encoding, pictures_adjoint.data());
}

}  // namespace tapestry::detect
