#pragma once
#include <tapestry/detect/detector_variable.hpp>

namespace tapestry::detect {
namespace detail {

template <std::floating_point T>
std::vector<std::shared_ptr<const Array<T, 4>>> shared_logits(const std::shared_ptr<Pass<T>>& pass) {
  std::vector<std::shared_ptr<const Array<T, 4>>> logits;
  for (const auto& head : pass->logits) logits.emplace_back(pass, &head);
  return logits;
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> record_logits(const Detector<T>& detector,
                                               const std::shared_ptr<Pass<T>>& pass,
                                               const ArrayVariable<T, 4>& images) {
  const auto pullback = [&detector, pass](const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          Array<T, 4>* images_adjoint) {
    detector.pull_back(*pass, logits_adjoint, images_adjoint);
  };
  return record_shared_arrays<T, 4>(shared_logits(pass), pullback, images);
}

}  // namespace detail

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
  parallel_for_blocks(pixel_count, block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = 3 * begin; i < 3 * end; i += 3) {
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
  parallel_for_blocks(pixel_count, block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto slope = static_cast<T>(255 * encoding.scale / encoding.deviation[c]);
      const std::size_t to = encoding.picture_channel(c);
      for (std::size_t i = begin; i < end; ++i)
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

template <std::floating_point T>
ArrayVariable<T, 4> encoded(const ArrayVariable<T, 4>& pictures, const InputEncoding& encoding) {
  const auto pullback = [encoding](const Array<T, 4>& input_adjoint, Array<T, 4>* pictures_adjoint) {
    encoded_adjoint(input_adjoint, encoding, *pictures_adjoint);
  };
  return record_array(encoded(pictures.value(), encoding), pullback, pictures);
}

template <std::floating_point T>
Pass<T>::Pass() = default;

template <std::floating_point T>
Pass<T>::Pass(Pass&&) noexcept = default;

template <std::floating_point T>
Pass<T>& Pass<T>::operator=(Pass&&) noexcept = default;

template <std::floating_point T>
Pass<T>::~Pass() = default;

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(const Detector<T>& detector, const ArrayVariable<T, 4>& images,
                                         std::shared_ptr<Pass<T>> pass) {
  if (!pass) pass = std::make_shared<Pass<T>>();
  detector.forward(images.value(), *pass, images.is_active() ? Mode::input_gradient : Mode::inference);
  return detail::record_logits(detector, pass, images);
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward_within(const Detector<T>& detector,
                                                const ArrayVariable<T, 4>& images,
                                                const std::vector<KeptPicture<T>*>& kept,
                                                std::shared_ptr<Pass<T>> pass) {
  if (!pass) pass = std::make_shared<Pass<T>>();
  detector.forward_within(images.value(), kept, *pass, Mode::input_gradient);
  return detail::record_logits(detector, pass, images);
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(Detector<T>& detector, const ArrayVariable<T, 4>& images,
                                         const ArrayVariable<T, 1>& weights, std::shared_ptr<Pass<T>> pass) {
  detector.require_images(images.value());
  require_shape("forward", "weights", weights.value(), {detector.network().weights().size()});
  tapestry::detail::require_recordable<T>(images.link(), weights.link());
  detector.set_weights(weights.value());
  if (!pass) pass = std::make_shared<Pass<T>>();
  detector.forward(images.value(), *pass, Mode::training);
  const auto pullback = [&detector, pass](const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          Array<T, 4>* images_adjoint, Array<T, 1>* weights_adjoint) {
    detector.pull_back(*pass, logits_adjoint, images_adjoint, weights_adjoint);
  };
  return record_shared_arrays<T, 4>(detail::shared_logits(pass), pullback, images, weights);
}

}  // namespace tapestry::detect
