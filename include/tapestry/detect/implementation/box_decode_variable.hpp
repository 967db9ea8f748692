#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/box_decode_variable.hpp>
#include <tapestry/detect/box_formula.hpp>
#include <tapestry/detect/class_score.hpp>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
ArrayVariable<T, 3> confidences(const DecodedHead<T>& head) {
  if (!head.has_objectness) return head.classes;
  return broadcast(head.objectness, head.classes.shape()) * head.classes;
}

}  // namespace tapestry::detect

namespace tapestry::detect::detail {

/// Calls visit(image, candidate, place, first) for every candidate of a batch; its channel c lies at
/// first + c · H · W of the logits.
template <class Visit>
void for_each_decoded(const Head& head, std::size_t images, double input_height, double input_width,
                      Visit visit) {
  const std::size_t cells = head.grid_height * head.grid_width;
  for (std::size_t n = 0; n < images; ++n)
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells, cell = candidate % cells;
      const CandidatePlace place{anchor, cell / head.grid_width, cell % head.grid_width, input_width,
                                 input_height};
      const std::size_t before = n * head.channel_count() + anchor * head.candidate_channel_count();
      visit(n, candidate, place, before * cells + cell);
    }
}

template <class T>
[[nodiscard]] std::vector<Array<T, 3>> decoded_arrays(const Head& head, const Array<T, 4>& logits,
                                                      double input_height, double input_width) {
  const std::size_t images = logits.shape(0), count = head.candidate_count();
  const std::size_t cells = head.grid_height * head.grid_width;
  std::vector<Array<T, 3>> arrays{Array<T, 3>(Extents<3>{images, count, 4}),
                                  Array<T, 3>(Extents<3>{images, count, 1}),
                                  Array<T, 3>(Extents<3>{images, count, head.classes})};
  const auto decode_one = [&](std::size_t n, std::size_t candidate, const CandidatePlace& place,
                              std::size_t first) {
    const auto logit = [&](std::size_t channel) {
      return static_cast<double>(logits.data()[first + channel * cells]);
    };
    const Box box = decode_box(head, place, logit);
    const std::array<double, 4> values{box.cx, box.cy, box.w, box.h};
    for (std::size_t i = 0; i < 4; ++i) arrays[0](n, candidate, i) = static_cast<T>(values[i]);
    arrays[1](n, candidate, 0) = static_cast<T>(probability(head, logit(surest_channel(head, logit))));
    const ClassScores scores(head, logit);
    for (std::size_t k = 0; k < head.classes; ++k) arrays[2](n, candidate, k) = static_cast<T>(scores(k));
  };
  for_each_decoded(head, images, input_height, input_width, decode_one);
  return arrays;
}

/// Adds the pullback of decoded_arrays(); null for what nothing depends on.
template <class T>
void decoded_arrays_adjoint(const Head& head, const Array<T, 4>& logits, double input_height,
                            double input_width, const std::vector<const Array<T, 3>*>& adjoints,
                            Array<T, 4>& logits_adjoint) {
  const std::size_t cells = head.grid_height * head.grid_width;
  const auto add_one = [&](std::size_t n, std::size_t candidate, const CandidatePlace& place,
                           std::size_t first) {
    const auto logit = [&](std::size_t channel) {
      return static_cast<double>(logits.data()[first + channel * cells]);
    };
    const auto add = [&](std::size_t channel, double adjoint) {
      logits_adjoint.data()[first + channel * cells] += static_cast<T>(adjoint);
    };
    const auto add_score = [&](std::size_t channel, T adjoint) {
      if (adjoint != T(0))
        add(channel, static_cast<double>(adjoint) * probability_slope(head, logit(channel)));
    };
    if (adjoints[0] != nullptr) {
      const auto of_box = [&](std::size_t i) { return static_cast<double>((*adjoints[0])(n, candidate, i)); };
      decode_box_adjoint(head, place, logit, {of_box(0), of_box(1), of_box(2), of_box(3)}, add);
    }
    if (adjoints[1] != nullptr) add_score(surest_channel(head, logit), (*adjoints[1])(n, candidate, 0));
    if (adjoints[2] == nullptr) return;
    ClassScores(head, logit)
        .adjoint([&](std::size_t k) { return static_cast<double>((*adjoints[2])(n, candidate, k)); }, add);
  };
  for_each_decoded(head, logits.shape(0), input_height, input_width, add_one);
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

template <std::floating_point T>
DecodedHead<T> decode(const Head& head, const ArrayVariable<T, 4>& logits, std::size_t input_height,
                      std::size_t input_width) {
  require_layout("decode", head);
  require_shape("decode", "logits", logits.value(),
                {logits.shape()[0], head.channel_count(), head.grid_height, head.grid_width});
  const auto height = static_cast<double>(input_height), width = static_cast<double>(input_width);
  const auto pullback = [head, values = logits.shared_value(), height, width](
                            const std::vector<const Array<T, 3>*>& adjoints, Array<T, 4>* logits_adjoint) {
    detail::decoded_arrays_adjoint(head, *values, height, width, adjoints, *logits_adjoint);
  };
  auto results =
      record_arrays<T, 3>(detail::decoded_arrays(head, logits.value(), height, width), pullback, logits);
  return {results[0], results[1], results[2], head.has_objectness()};
}

template <std::floating_point T>
std::vector<DecodedHead<T>> detail::decoded_heads(const std::vector<Head>& heads,
                                                  const std::vector<ArrayVariable<T, 4>>& logits,
                                                  std::size_t input_height, std::size_t input_width) {
  if (logits.size() != heads.size())
    throw ShapeError("decode: logits of " + std::to_string(logits.size()) + " heads, expected " +
                     std::to_string(heads.size()));
  std::vector<DecodedHead<T>> decoded;
  for (std::size_t h = 0; h < logits.size(); ++h)
    decoded.push_back(decode(heads[h], logits[h], input_height, input_width));
  return decoded;
}

template decltype(detail::decoded_heads<float>) detail::decoded_heads<float>;
template decltype(detail::decoded_heads<double>) detail::decoded_heads<double>;
template decltype(confidences<float>) confidences<float>;
template decltype(confidences<double>) confidences<double>;
template DecodedHead<float> decode<float>(const Head& head, const ArrayVariable<float, 4>& logits,
                                          std::size_t input_height, std::size_t input_width);
template DecodedHead<double> decode<double>(const Head& head, const ArrayVariable<double, 4>& logits,
                                            std::size_t input_height, std::size_t input_width);

}  // namespace tapestry::detect
