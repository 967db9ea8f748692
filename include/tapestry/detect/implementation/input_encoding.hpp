#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/input_encoding.hpp>

namespace tapestry::detect {

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

template <std::floating_point T>
Array<T, 4> encoded(const Array<T, 4>& pictures, const InputEncoding& encoding) {
  auto extents = pictures.shape();
  extents[3] = 3;
  require_shape("encoded", "pictures", pictures, extents);
  Array<T, 4> input(extents);
  encode(pictures.data(), input.size() / 3, encoding, input.data());
  return input;
}

template <std::floating_point T>
void encoded_adjoint(const Array<T, 4>& input_adjoint, const InputEncoding& encoding,
                     Array<T, 4>& pictures_adjoint) {
  auto extents = pictures_adjoint.shape();
  extents[3] = 3;
  require_shape("encoded_adjoint", "pictures_adjoint", pictures_adjoint, extents);
  require_shape("encoded_adjoint", "input_adjoint", input_adjoint, extents);
  encode_adjoint(input_adjoint.data(), input_adjoint.size() / 3, encoding, pictures_adjoint.data());
}

template decltype(encode<float>) encode<float>;
template decltype(encode<double>) encode<double>;
template decltype(encode_adjoint<float>) encode_adjoint<float>;
template decltype(encode_adjoint<double>) encode_adjoint<double>;
template Array<float, 4> encoded<float>(const Array<float, 4>& pictures, const InputEncoding& encoding);
template Array<double, 4> encoded<double>(const Array<double, 4>& pictures, const InputEncoding& encoding);
template decltype(encoded_adjoint<float>) encoded_adjoint<float>;
template decltype(encoded_adjoint<double>) encoded_adjoint<double>;

}  // namespace tapestry::detect
