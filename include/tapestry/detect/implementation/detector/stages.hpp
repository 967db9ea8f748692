#pragma once
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/implementation/detector/claim.hpp>
#include <tapestry/image/batch.hpp>

/// \file
/// Detectors with as many candidates as the picture has proposals: logits of a network in stages, [1, 4 + K,
/// 1, n], in an array with room for more.

namespace tapestry::detect {
namespace detail {
/// Extents of a network's outputs; of one in stages at a first picture, with room for all candidates.
template <std::floating_point T>
[[nodiscard]] std::vector<nn::Shape> first_shapes(const nn::Network<T>& network,
                                                  const nn::StagedNetwork<T>* stages,
                                                  std::size_t most_candidates) {
  std::vector<nn::Shape> shapes;
  for (std::size_t i = 0; stages == nullptr && i < network.output_count(); ++i)
    shapes.push_back(network.output_shape(i));
  if (stages == nullptr) return shapes;
  nn::Buffer<T> black(nn::size_of(stages->input_shape(0)));
  black.fill_zero();
  nn::StagedPass<T> pass;
  stages->forward({black.data()}, pass);
  for (std::size_t i = 0; i < pass.output_count(); ++i) shapes.push_back(pass.output_shape(i));
  shapes.front().at(3) = most_candidates;
  return shapes;
}

/// Copies the logits of all candidates; fills the remaining room with others.
/// \param shape  [1, 4 + K, 1, room]
/// \throws Error (limit) if there are more
template <std::floating_point T>
void take_candidates(const nn::StagedPass<T>& one, const nn::Shape& shape, T* logits) {
  constexpr std::size_t box = 4;
  const std::size_t channels = shape[1], room = shape[3], count = one.output_shape(0).at(3);
  if (count > room)
    throw Error(ErrorKind::limit, {"Detector: ", count, " candidates in a picture, at most ", room,
                                   "; state more as 'candidates' of the description's outputs"});
  const auto least = static_cast<double>(least_probability);
  for (std::size_t c = 0; c < channels; ++c) {
    T* const to = logits + c * room;
    std::copy_n(one.output(0) + c * count, count, to);
    std::fill_n(to + count, room - count, c < box ? T(0) : static_cast<T>(std::log(least / (1 - least))));
  }
}
}  // namespace detail

template <std::floating_point T>
void Detector<T>::run_stages(const Array<T, 4>& images, Pass<T>& pass) const {
  pass.stages.resize(pass.graph.size());
  const Array<T, 4> planes = image::planes_of(encoded(images, kind_.encoding));
  const bool judges = claim_ && !claim_->is_judged;
  bool has_judged = false;
  for (std::size_t n = 0; n < pass.images; ++n) {
    const std::size_t lane = pass.mode == Mode::inference ? n % pass.graph.size() : n;
    nn::Buffer<T>& input = pass.inputs[lane];
    input.resize(image_size());
    std::copy_n(planes.data() + n * input.size(), input.size(), input.data());
    nn::StagedPass<T>& one = pass.stages[lane];
    stages_->forward({input.data()}, one, pass.mode);
    const nn::Shape& shape = shapes_.front();
    detail::take_candidates(one, shape, pass.logits[0].data() + n * nn::size_of(shape));
    const std::size_t last = one.output_count() - 1;
    if (!judges || nn::size_of(one.output_shape(last)) == 0) continue;
    detail::require_as_described(*claim_, kind_.decoded, one.output_shape(last), one.output(last));
    has_judged = true;
  }
  if (has_judged) claim_->is_judged = true;
}

template <std::floating_point T>
void Detector<T>::pull_back_stages(Pass<T>& pass, std::size_t n, const std::vector<const T*>& of_outputs,
                                   Array<T, 4>* images_adjoint, const std::vector<T*>& gathered) const {
  nn::StagedPass<T>& one = pass.stages[n];
  std::vector<const T*> adjoints = of_outputs;
  std::vector<T> of_candidates;  // those that are there
  const std::size_t channels = shapes_.front()[1], room = shapes_.front()[3],
                    count = one.output_shape(0).at(3);
  if (adjoints[0] != nullptr) {
    for (std::size_t c = 0; c < channels; ++c)
      of_candidates.insert(of_candidates.end(), adjoints[0] + c * room, adjoints[0] + c * room + count);
    adjoints[0] = of_candidates.data();
  }
  Array<T, 4> planes = zeros<T, 4>({1, input_channels(), height_, width_});
  stages_->adjoint(one, adjoints, {planes.data()}, gathered);
  if (images_adjoint == nullptr) return;
  const Array<T, 4> input_adjoint = image::pictures_of_planes(planes);
  encode_adjoint(input_adjoint.data(), height_ * width_, kind_.encoding,
                 images_adjoint->data() + n * image_size());
}

template <std::floating_point T>
const T* Detector<T>::output_values(const Pass<T>& pass, std::size_t n, std::size_t output) const {
  if (!stages_) return pass.graph[n].output(output);
  const nn::StagedPass<T>& one = pass.stages[n];
  if (one.output_shape(output) != shapes_[output])
    throw ShapeError({"Detector: layer ", output - head_output_count(), " is ", one.output_shape(output),
                      " for this picture and ", shapes_[output], " for another"});
  return one.output(output);
}
}  // namespace tapestry::detect
