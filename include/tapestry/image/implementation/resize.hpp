#pragma once
#include <tapestry/image/batch.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/image/resize.hpp>

namespace tapestry::image {
namespace detail {
/// out[i] = (1 − share)·in[first] + share·in[second] along one axis.
struct AxisTap {
  std::size_t first;
  std::size_t second;
  double share;
};

/// Taps of every output position, from (i + ½)·from/to − ½ clamped to the first and last input.
inline std::vector<AxisTap> axis_taps(std::size_t from, std::size_t to) {
  std::vector<AxisTap> taps(to);
  const double ratio = static_cast<double>(from) / static_cast<double>(to);
  for (std::size_t i = 0; i < to; ++i) {
    const double position = (static_cast<double>(i) + 0.5) * ratio - 0.5;
    if (position <= 0) {
      taps[i] = {0, 0, 0};
    } else if (position >= static_cast<double>(from - 1)) {
      taps[i] = {from - 1, from - 1, 0};
    } else {
      const auto first = static_cast<std::size_t>(position);
      taps[i] = {first, first + 1, position - static_cast<double>(first)};
    }
  }
  return taps;
}
}  // namespace detail

template <std::floating_point T>
Array<T, 3> resize_bilinear(const Array<T, 3>& picture, std::size_t height, std::size_t width) {
  detail::require_size("resize_bilinear", picture.shape(0), picture.shape(1));
  detail::require_size("resize_bilinear", height, width);
  const std::size_t channels = picture.shape(2), stride = picture.shape(1) * channels;
  const auto rows = detail::axis_taps(picture.shape(0), height);
  const auto columns = detail::axis_taps(picture.shape(1), width);
  Array<T, 3> resized(Extents<3>{height, width, channels});
  const T* const from = picture.data();
  T* const to = resized.data();
  parallel_for_blocks(height, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const T* const upper = from + rows[i].first * stride;
      const T* const lower = from + rows[i].second * stride;
      const auto down = static_cast<T>(rows[i].share);
      for (std::size_t j = 0; j < width; ++j) {
        const std::size_t left = columns[j].first * channels, right = columns[j].second * channels;
        const auto across = static_cast<T>(columns[j].share);
        for (std::size_t c = 0; c < channels; ++c) {
          const T above = upper[left + c] * (1 - across) + upper[right + c] * across;
          const T below = lower[left + c] * (1 - across) + lower[right + c] * across;
          to[(i * width + j) * channels + c] = above * (1 - down) + below * down;
        }
      }
    }
  });
  return resized;
}

template <std::floating_point T>
void resize_bilinear_adjoint(const Array<T, 3>& resized_adjoint, Array<T, 3>& picture_adjoint) {
  const std::size_t height = resized_adjoint.shape(0), width = resized_adjoint.shape(1);
  const std::size_t channels = picture_adjoint.shape(2), stride = picture_adjoint.shape(1) * channels;
  detail::require_size("resize_bilinear_adjoint", picture_adjoint.shape(0), picture_adjoint.shape(1));
  detail::require_size("resize_bilinear_adjoint", height, width);
  require_shape("resize_bilinear_adjoint", "resized_adjoint", resized_adjoint, {height, width, channels});
  const auto rows = detail::axis_taps(picture_adjoint.shape(0), height);
  const auto columns = detail::axis_taps(picture_adjoint.shape(1), width);

  std::vector<std::vector<std::size_t>> readers(picture_adjoint.shape(0));  // output rows of each input row
  for (std::size_t i = 0; i < height; ++i) {
    readers[rows[i].first].push_back(i);
    if (rows[i].second != rows[i].first) readers[rows[i].second].push_back(i);
  }
  parallel_for(readers.size(), [&](std::size_t row) {
    T* const to = picture_adjoint.data() + row * stride;
    for (const std::size_t i : readers[row]) {
      const auto down = static_cast<T>(rows[i].first == row ? 1 - rows[i].share : rows[i].share);
      const T* const from = resized_adjoint.data() + i * width * channels;
      for (std::size_t j = 0; j < width; ++j) {
        const auto across = static_cast<T>(columns[j].share);
        for (std::size_t c = 0; c < channels; ++c) {
          const T value = down * from[j * channels + c];
          to[columns[j].first * channels + c] += (1 - across) * value;
          to[columns[j].second * channels + c] += across * value;
        }
      }
    }
  });
}

template <std::floating_point T>
ArrayVariable<T, 4> batch_of(const std::vector<ArrayVariable<T, 3>>& pictures) {
  std::vector<const Array<T, 3>*> values;
  for (const auto& picture : pictures) values.push_back(&picture.value());
  const auto pullback = [](const Array<T, 4>& batch_adjoint,
                           const std::vector<Array<T, 3>*>& picture_adjoints) {
    const T* from = batch_adjoint.data();
    for (auto* const adjoint : picture_adjoints) {
      const std::size_t size = batch_adjoint.size() / batch_adjoint.shape(0);
      for (std::size_t i = 0; adjoint != nullptr && i < size; ++i) adjoint->data()[i] += from[i];
      from += size;
    }
  };
  return record_array(batch_of(values), pullback, pictures);
}
}  // namespace tapestry::image
