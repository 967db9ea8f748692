#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/detect/graph_detector.hpp>
#include <tapestry/detect/graph_detector_variable.hpp>
#include <tapestry/detect/network_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(GraphDetector<T>& detector, const ArrayVariable<T, 4>& images,
                                         const ArrayVariable<T, 1>& constants,
                                         std::shared_ptr<Pass<T>> pass) {
  detector.require_images(images.value());
  require_shape("forward", "constants", constants.value(), {detector.network().constants().size()});
  tapestry::detail::require_recordable<T>(images.link(), constants.link());
  detector.network().set_constants({constants.value().data(), constants.value().data() + constants.size()});
  if (!pass) pass = std::make_shared<Pass<T>>();
  detector.forward(images.value(), *pass, Mode::training);
  const auto pullback = [&detector, pass](const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          Array<T, 4>* images_adjoint, Array<T, 1>* constants_adjoint) {
    detector.pull_back(*pass, logits_adjoint, images_adjoint, constants_adjoint);
  };
  return record_shared_arrays<T, 4>(detail::shared_logits(pass), pullback, images, constants);
}

template std::vector<ArrayVariable<float, 4>> forward<float>(GraphDetector<float>& detector,
                                                             const ArrayVariable<float, 4>& images,
                                                             const ArrayVariable<float, 1>& constants,
                                                             std::shared_ptr<Pass<float>> pass);
template std::vector<ArrayVariable<double, 4>> forward<double>(GraphDetector<double>& detector,
                                                               const ArrayVariable<double, 4>& images,
                                                               const ArrayVariable<double, 1>& constants,
                                                               std::shared_ptr<Pass<double>> pass);

}  // namespace tapestry::detect
