#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/compiled.hpp>
#include <vector>

namespace tapestry::image {

/// Pictures [H, W, C] of one size, one behind the other, as networks take them: [N, H, W, C].
/// \param pictures  where they are; none null
/// \throws ShapeError if there are none or their sizes differ
template <class T>
[[nodiscard]] Array<T, 4> batch_of(const std::vector<const Array<T, 3>*>& pictures) {
  if (pictures.empty()) throw ShapeError("batch_of: no pictures");
  const auto& first = *pictures.front();
  Array<T, 4> batch(Extents<4>{pictures.size(), first.shape(0), first.shape(1), first.shape(2)});
  T* to = batch.data();
  for (const auto* picture : pictures) {
    require_shape("batch_of", "picture", *picture, first.shape());
    to = std::copy_n(picture->data(), picture->size(), to);
  }
  return batch;
}

/// One picture as a batch, [1, H, W, C].
template <class T>
[[nodiscard]] Array<T, 4> batch_of(const Array<T, 3>& picture) {
  return batch_of(std::vector<const Array<T, 3>*>{&picture});
}

/// One of a batch's pictures, [H, W, C]. \throws DomainError if there are not as many
template <class T>
[[nodiscard]] Array<T, 3> picture_of(const Array<T, 4>& batch, std::size_t index) {
  if (index >= batch.shape(0))
    throw DomainError("picture_of: picture " + std::to_string(index) + " of a batch of " +
                      std::to_string(batch.shape(0)));
  Array<T, 3> picture(Extents<3>{batch.shape(1), batch.shape(2), batch.shape(3)});
  std::copy_n(batch.data() + index * picture.size(), picture.size(), picture.data());
  return picture;
}

}  // namespace tapestry::image
