#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/compiled.hpp>

namespace tapestry::image {
/// Pictures [H, W, C] of one size, one behind the other, as networks take them: [N, H, W, C].
/// \param pictures  where they are; none null
/// \throws ShapeError if there are none or their sizes differ
template <std::floating_point T>
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
template <std::floating_point T>
[[nodiscard]] Array<T, 4> batch_of(const Array<T, 3>& picture) {
  return batch_of(std::vector<const Array<T, 3>*>{&picture});
}

/// One of a batch's pictures, [H, W, C]. \throws DomainError if there are not as many
template <std::floating_point T>
[[nodiscard]] Array<T, 3> picture_of(const Array<T, 4>& batch, std::size_t index) {
  if (index >= batch.shape(0))
    throw DomainError({"picture_of: picture ", index, " of a batch of ", batch.shape(0)});
  Array<T, 3> picture(Extents<3>{batch.shape(1), batch.shape(2), batch.shape(3)});
  std::copy_n(batch.data() + index * picture.size(), picture.size(), picture.data());
  return picture;
}

/// batch_of() of pictures on the tape, [N, H, W, C], such as a network takes.
/// \throws ShapeError as batch_of()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> batch_of(const std::vector<ArrayVariable<T, 3>>& pictures);
/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] ArrayVariable<D, 4> batch_of(const std::vector<ArrayVariable<D, 3>>& pictures) {
  return record_linear([](const auto& x) { return batch_of(x); }, pictures);
}

/// Pictures [N, H, W, C] channel by channel, [N, C, H, W]: the order of other libraries' networks. Tapestry's
/// networks take [N, H, W, C].
template <std::floating_point T>
[[nodiscard]] Array<T, 4> planes_of(const Array<T, 4>& pictures) {
  const std::size_t pixels = pictures.shape(1) * pictures.shape(2), channels = pictures.shape(3);
  Array<T, 4> planes(Extents<4>{pictures.shape(0), channels, pictures.shape(1), pictures.shape(2)});
  for (std::size_t n = 0; n < pictures.shape(0); ++n)
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
      for (std::size_t c = 0; c < channels; ++c)
        planes.data()[(n * channels + c) * pixels + pixel] =
            pictures.data()[(n * pixels + pixel) * channels + c];
  return planes;
}

/// Inverts planes_of().
template <std::floating_point T>
[[nodiscard]] Array<T, 4> pictures_of_planes(const Array<T, 4>& planes) {
  const std::size_t channels = planes.shape(1), pixels = planes.shape(2) * planes.shape(3);
  Array<T, 4> pictures(Extents<4>{planes.shape(0), planes.shape(2), planes.shape(3), channels});
  for (std::size_t n = 0; n < planes.shape(0); ++n)
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
      for (std::size_t c = 0; c < channels; ++c)
        pictures.data()[(n * pixels + pixel) * channels + c] =
            planes.data()[(n * channels + c) * pixels + pixel];
  return pictures;
}
}  // namespace tapestry::image
