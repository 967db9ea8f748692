#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/io/gradient_picture.hpp>
#include <tapestry/io/image_file.hpp>

namespace tapestry::io {

template <std::floating_point T>
void write_gradient(const std::string& path, const Array<T, 4>& gradient) {
  require_shape("write_gradient", "gradient", gradient, {1, gradient.shape(1), gradient.shape(2), 3});
  auto picture = image::picture_of(gradient, 0);
  T largest = 0;
  for (const T value : picture.storage()) largest = std::max(largest, std::abs(value));
  if (largest == 0) largest = 1;
  for (T& value : picture.storage()) value = (1 + std::cbrt(value / largest)) / 2;
  write_image(path, picture);
}

template decltype(write_gradient<float>) write_gradient<float>;
template decltype(write_gradient<double>) write_gradient<double>;

}  // namespace tapestry::io
