#pragma once
#include <cmath>
#include <tapestry/core/array.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/vector_exp.hpp>

namespace tapestry::image {
/// BGR to RGB, and back: exchanges the first and the third channel.
///
/// \param picture  [H, W, 3]
/// \throws ShapeError if there are not three channels
template <class Element>
[[nodiscard]] Array<Element, 3> swap_red_blue(Array<Element, 3> picture) {
  if (picture.shape(2) != 3) {
    throw ShapeError({"swap_red_blue: picture has ", picture.shape(2), " channels, expected 3"});
  }
  for (std::size_t i = 0; i < picture.size(); i += 3) std::swap(picture.data()[i], picture.data()[i + 2]);
  return picture;
}

/// Bytes 0 … 255 to colours 0 … 1.
template <std::floating_point T>
[[nodiscard]] Array<T, 3> from_bytes(const Array<std::uint8_t, 3>& bytes) {
  std::array<T, 256> shares{};  // divided once a byte, not once a pixel
  for (std::size_t byte = 0; byte < shares.size(); ++byte) shares[byte] = static_cast<T>(byte) / 255;
  Array<T, 3> picture(bytes.shape());
  std::transform(bytes.begin(), bytes.end(), picture.begin(),
                 [&](std::uint8_t byte) { return shares[byte]; });
  return picture;
}

/// Colours to the nearest bytes; below 0 and NaN give 0, above 1 gives 255. Inverts from_bytes() exactly.
template <std::floating_point T>
[[nodiscard]] Array<std::uint8_t, 3> to_bytes(const Array<T, 3>& picture) {
  Array<std::uint8_t, 3> bytes(picture.shape());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const T scaled = picture.data()[i] * 255 + T(0.5);
    const bool is_low = !(scaled >= 1);  // NaN too
    bytes.data()[i] = is_low ? std::uint8_t{0} : static_cast<std::uint8_t>(scaled < 255 ? scaled : T(255));
  }
  return bytes;
}

// Light adds up, the numbers of a picture do not: a byte of sRGB stands for an amount of light by a curve.
// Fine black and white stripes that blend in a far pixel give half the light, which a camera writes as
// 0.735; the mean of their numbers is 0.5.
//
// Source of the curve: IEC 61966-2-1, except that its two parts meet where they cross. The standard rounds
// that place (to 0.04045 and 0.0031308), which leaves a step of 2e-8 that a derivative would not see. Both
// parts continue beyond 0 to 1.

/// Space for blending, filtering and lighting colours. Colours that are read, optimised, shown to a detector
/// or written are always encoded.
enum class ColourSpace {
  encoded,  ///< as in sRGB pictures; so do the FCA paper's program and most differentiable renderers
  linear    ///< in proportion to light, as in front of a camera
};

/// All of them.
inline constexpr std::array colour_spaces{ColourSpace::encoded, ColourSpace::linear};

/// The name in options and manifests.
[[nodiscard]] constexpr const char* name_of(ColourSpace space) {
  return space == ColourSpace::encoded ? "encoded" : "linear";
}

/// \throws DomainError if no space has that name
[[nodiscard]] inline ColourSpace colour_space_by_name(const std::string& name) {
  for (const ColourSpace space : colour_spaces)
    if (name == name_of(space)) return space;
  throw DomainError({"no colour space ", in_quotes(name), "; expected encoded or linear"});
}

namespace detail {
inline constexpr double crossing_encoded = 0.0404482362771081917;  ///< where the line meets the power
inline constexpr double crossing_linear = 0.00313066844250063403;
}  // namespace detail

/// The light of an encoded value.
template <std::floating_point T>
[[nodiscard]] T linearised(T encoded) {
  return encoded <= T(detail::crossing_encoded) ? encoded / T(12.92)
                                                : std::pow((encoded + T(0.055)) / T(1.055), T(2.4));
}

/// d linearised / d encoded, for an encoded value and its light.
template <std::floating_point T>
[[nodiscard, gnu::always_inline]] inline T linearised_slope(T encoded, T linear) {
  const T of_power = T(2.4) * linear / (encoded + T(0.055));
  return encoded <= T(detail::crossing_encoded) ? 1 / T(12.92) : of_power;
}

/// The encoded value of an amount of light: the inverse of linearised().
template <std::floating_point T>
[[nodiscard]] T encoded(T linear) {
  return linear <= T(detail::crossing_linear) ? T(12.92) * linear
                                              : T(1.055) * std::pow(linear, 1 / T(2.4)) - T(0.055);
}

/// d encoded / d linear, for an amount of light and its encoded value.
template <std::floating_point T>
[[nodiscard]] T encoded_slope(T linear, T encoded) {
  return linear <= T(detail::crossing_linear) ? T(12.92) : (encoded + T(0.055)) / (T(2.4) * linear);
}

namespace detail {
/// linearised() for loops of vectors: in float with a relative error of 6e-7 at most (by std::pow 4e-7), the
/// same with every C library.
template <std::floating_point T>
struct Linearise {
  const T* encoded;
  T* light;
  [[gnu::always_inline]] void operator()(std::size_t i) const {
    if constexpr (std::same_as<T, float>) {
      using tapestry::detail::vector_exp, tapestry::detail::vector_log;
      const float base = (encoded[i] + 0.055F) / 1.055F;
      const float power = base * base * vector_exp(0.4F * vector_log(base));
      const float line = encoded[i] / 12.92F;
      light[i] = encoded[i] <= static_cast<float>(crossing_encoded) ? line : power;
    } else {
      light[i] = linearised(encoded[i]);
    }
  }
};

/// Adds the pullback of linearised().
template <std::floating_point T>
struct LinearisedPullback {
  const T *encoded, *light, *light_adjoint;
  T* encoded_adjoint;
  [[gnu::always_inline]] void operator()(std::size_t i) const {
    encoded_adjoint[i] += light_adjoint[i] * linearised_slope(encoded[i], light[i]);
  }
};
}  // namespace detail

/// linearised() of every value, in float with a relative error of 6e-7 at most.
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] Array<T, Rank> linearised(const Array<T, Rank>& colours) {
  Array<T, Rank> light(colours.shape());
  parallel_for_vectors(light.size(), detail::Linearise<T>{colours.data(), light.data()});
  return light;
}

/// encoded() of every value.
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] Array<T, Rank> encoded(const Array<T, Rank>& light) {
  Array<T, Rank> colours(light.shape());
  parallel_for_vectors(colours.size(), [from = light.data(), to = colours.data()](std::size_t i) {
    to[i] = encoded(from[i]);
  });
  return colours;
}

/// Encoded colours converted to a space.
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] Array<T, Rank> in_space(ColourSpace space, Array<T, Rank> colours) {
  return space == ColourSpace::linear ? linearised(colours) : colours;
}
}  // namespace tapestry::image
