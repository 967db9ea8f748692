#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/core/compiled.hpp>

namespace tapestry::detect {

/// Colour of a network's first input channel.
enum class ColourOrder { rgb, bgr };

/// Encoding of a picture's colours for a network. With a picture in [0, 1] and d_c the deviation,
///
///   input channel c = (255 · scale · (colour that order puts at c) − mean_c) / d_c
///
/// so that scale 1/255 is for networks that were trained on [0, 1] and scale 1 for those on 0 to 255.
struct InputEncoding {
  ColourOrder order = ColourOrder::rgb;
  double scale = 1.0 / 255;
  std::array<double, 3> mean{0, 0, 0};       ///< by input channel
  std::array<double, 3> deviation{1, 1, 1};  ///< by input channel, above 0

  /// The channel of an RGB picture that belongs to input channel c.
  [[nodiscard]] std::size_t picture_channel(std::size_t c) const {
    return order == ColourOrder::rgb ? c : 2 - c;
  }
  bool operator==(const InputEncoding&) const = default;
};

/// RGB in [0, 1], normalised by mean and deviation of ImageNet's colours, as torchvision states them.
inline constexpr InputEncoding imagenet_encoding{
    ColourOrder::rgb, 1.0 / 255, {0.485, 0.456, 0.406}, {0.229, 0.224, 0.225}};

/// Encodes pixels for a network.
/// \param pictures  [pixel, 3], RGB in [0, 1]
/// \param input     takes as many
template <std::floating_point T>
void encode(const T* pictures, std::size_t pixel_count, const InputEncoding& encoding, T* input);

/// Adds the pullback of encode() to pictures_adjoint, [pixel, 3].
template <std::floating_point T>
void encode_adjoint(const T* input_adjoint, std::size_t pixel_count, const InputEncoding& encoding,
                    T* pictures_adjoint);

/// Encodes pictures for a network.
/// \param pictures  [N, H, W, 3], RGB in [0, 1]
/// \returns         [N, H, W, 3]
/// \throws ShapeError unless the pictures have three channels
template <std::floating_point T>
[[nodiscard]] Array<T, 4> encoded(const Array<T, 4>& pictures, const InputEncoding& encoding);

/// Adds the pullback of encoded() to pictures_adjoint; both are [N, H, W, 3].
/// \throws ShapeError unless they are of one shape with three channels
template <std::floating_point T>
void encoded_adjoint(const Array<T, 4>& input_adjoint, const InputEncoding& encoding,
                     Array<T, 4>& pictures_adjoint);

/// encoded() of pictures on the tape; its pullback is encoded_adjoint(). Errors as there.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> encoded(const ArrayVariable<T, 4>& pictures, const InputEncoding& encoding);

}  // namespace tapestry::detect
