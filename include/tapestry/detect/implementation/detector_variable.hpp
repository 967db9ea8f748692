#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect::detail {

template <class T>
std::vector<std::shared_ptr<const Array<T, 4>>> shared_logits(const std::shared_ptr<Pass<T>>& pass) {
  std::vector<std::shared_ptr<const Array<T, 4>>> logits;
  for (const auto& head : pass->logits) logits.emplace_back(pass, &head);
  return logits;
}

template <class T>
std::vector<ArrayVariable<T, 4>> record_logits(const Detector<T>& detector,
                                               const std::shared_ptr<Pass<T>>& pass,
                                               const ArrayVariable<T, 4>& images) {
  const auto pullback = [&detector, pass](const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          Array<T, 4>* images_adjoint) {
    detector.pull_back(*pass, logits_adjoint, images_adjoint);
  };
  return record_shared_arrays<T, 4>(shared_logits(pass), pullback, images);
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

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

namespace tapestry::detect::detail {

template decltype(shared_logits<float>) shared_logits<float>;
template decltype(shared_logits<double>) shared_logits<double>;
template decltype(record_logits<float>) record_logits<float>;
template decltype(record_logits<double>) record_logits<double>;

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

template std::vector<ArrayVariable<float, 4>> forward<float>(const Detector<float>& detector,
                                                             const ArrayVariable<float, 4>& images,
                                                             std::shared_ptr<Pass<float>> pass);
template std::vector<ArrayVariable<double, 4>> forward<double>(const Detector<double>& detector,
                                                               const ArrayVariable<double, 4>& images,
                                                               std::shared_ptr<Pass<double>> pass);
template decltype(forward_within<float>) forward_within<float>;
template decltype(forward_within<double>) forward_within<double>;

template std::vector<ArrayVariable<float, 4>> forward<float>(Detector<float>& detector,
                                                             const ArrayVariable<float, 4>& images,
                                                             const ArrayVariable<float, 1>& weights,
                                                             std::shared_ptr<Pass<float>> pass);
template std::vector<ArrayVariable<double, 4>> forward<double>(Detector<double>& detector,
                                                               const ArrayVariable<double, 4>& images,
                                                               const ArrayVariable<double, 1>& weights,
                                                               std::shared_ptr<Pass<double>> pass);

}  // namespace tapestry::detect
