#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <optional>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/best_candidate.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/detect/heat_map.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// max(0, Σ_c weight_c · A_c), [H, W].
template <std::floating_point T, class Weight>
Array<T, 2> weighted_map(const Array<T, 3>& values, Weight weight) {
  const std::size_t pixels = values.shape(1) * values.shape(2);
  auto map = zeros<T, 2>({values.shape(1), values.shape(2)});
  for (std::size_t c = 0; c < values.shape(0); ++c)
    for (std::size_t i = 0; i < pixels; ++i) map.data()[i] += weight(c, i) * values.data()[c * pixels + i];
  for (T& value : map.storage()) value = std::max(value, T(0));
  return map;
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

template <std::floating_point T>
Array<T, 2> grad_cam(const Array<T, 3>& values, const Array<T, 3>& adjoint) {
  require_shape("grad_cam", "adjoint", adjoint, values.shape());
  const std::size_t pixels = values.shape(1) * values.shape(2);
  std::vector<T> means(values.shape(0), T(0));
  for (std::size_t c = 0; c < means.size(); ++c) {
    for (std::size_t i = 0; i < pixels; ++i) means[c] += adjoint.data()[c * pixels + i];
    means[c] /= static_cast<T>(pixels);
  }
  return detail::weighted_map(values, [&](std::size_t c, std::size_t) { return means[c]; });
}

template <std::floating_point T>
Array<T, 2> grad_cam_plus_plus(const Array<T, 3>& values, const Array<T, 3>& adjoint) {
  require_shape("grad_cam_plus_plus", "adjoint", adjoint, values.shape());
  const std::size_t pixels = values.shape(1) * values.shape(2);
  std::vector<T> weights(values.shape(0), T(0));
  for (std::size_t c = 0; c < weights.size(); ++c) {
    const T *const a = values.data() + c * pixels, *const g = adjoint.data() + c * pixels;
    T sum = 0;
    for (std::size_t i = 0; i < pixels; ++i) sum += a[i];
    for (std::size_t i = 0; i < pixels; ++i) {
      const T denominator = 2 + sum * g[i];  // g² has been divided out
      if (g[i] > 0 && denominator != 0) weights[c] += g[i] / denominator;
    }
  }
  return detail::weighted_map(values, [&](std::size_t c, std::size_t) { return weights[c]; });
}

template <std::floating_point T>
Array<T, 2> layer_cam(const Array<T, 3>& values, const Array<T, 3>& adjoint) {
  require_shape("layer_cam", "adjoint", adjoint, values.shape());
  const std::size_t pixels = values.shape(1) * values.shape(2);
  return detail::weighted_map(
      values, [&](std::size_t c, std::size_t i) { return std::max(adjoint.data()[c * pixels + i], T(0)); });
}

template <std::floating_point T>
std::optional<double> share_within(const Array<T, 2>& heat, const Array<T, 2>& mask) {
  require_shape("share_within", "mask", mask, heat.shape());
  double within = 0, whole = 0;
  for (std::size_t i = 0; i < heat.size(); ++i) {
    within += static_cast<double>(heat.data()[i]) * static_cast<double>(mask.data()[i]);
    whole += static_cast<double>(heat.data()[i]);
  }
  if (!(whole > 0)) return std::nullopt;
  return std::min(within / whole, 1.0);
}

template <std::floating_point T>
std::vector<Array<T, 4>> score_adjoint(const std::vector<Head>& heads, const std::vector<Array<T, 4>>& logits,
                                       std::size_t image, std::size_t class_index,
                                       const BestCandidate& best) {
  std::vector<Array<T, 4>> adjoints;
  for (const auto& of_head : logits) adjoints.push_back(zeros<T, 4>(of_head.shape()));
  const Head& head = heads.at(best.head);
  const std::size_t cells = head.grid_height * head.grid_width;
  const std::size_t anchor = best.candidate / cells, cell = best.candidate % cells;
  T* const first = adjoints.at(best.head).data() + image * head.channel_count() * cells +
                   anchor * head.candidate_channel_count() * cells + cell;
  first[head.class_channel(class_index) * cells] = 1;
  if (const auto objectness = head.objectness_channel()) first[*objectness * cells] = 1;
  return adjoints;
}

template decltype(grad_cam<float>) grad_cam<float>;
template decltype(grad_cam<double>) grad_cam<double>;
template decltype(grad_cam_plus_plus<float>) grad_cam_plus_plus<float>;
template decltype(grad_cam_plus_plus<double>) grad_cam_plus_plus<double>;
template decltype(layer_cam<float>) layer_cam<float>;
template decltype(layer_cam<double>) layer_cam<double>;
template decltype(share_within<float>) share_within<float>;
template decltype(share_within<double>) share_within<double>;
template decltype(score_adjoint<float>) score_adjoint<float>;
template decltype(score_adjoint<double>) score_adjoint<double>;

}  // namespace tapestry::detect
