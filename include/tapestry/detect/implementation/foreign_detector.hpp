#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/detect/foreign_detector.hpp>
#include <tapestry/detect/input_encoding.hpp>
#include <tapestry/image/planes.hpp>
#include <tapestry/nn/network/network.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
void ForeignDetector<T>::forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode) const {
  if (mode != Mode::inference) refuse_gradient("forward");
  this->require_images(images);
  pass.mode = mode;
  pass.images = images.shape(0);
  pass.graph.resize(1);
  const Head& head = heads().front();
  pass.logits.resize(1);
  pass.logits[0].resize({pass.images, head.channel_count(), head.grid_height, head.grid_width});
  const Array<T, 4> input = image::planes_of(encoded(images, kind_.encoding));
  std::vector<float> picture(3 * height_ * width_);
  for (std::size_t n = 0; n < pass.images; ++n) {
    std::transform(input.data() + n * picture.size(), input.data() + (n + 1) * picture.size(),
                   picture.begin(), [](T value) { return static_cast<float>(value); });
    const auto outputs = run(picture);
    std::vector<nn::Buffer<T>> values(outputs.size());
    std::vector<const T*> pointers;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      values[i].resize(outputs[i].values.size());
      std::ranges::transform(outputs[i].values, values[i].data(),
                             [](float value) { return static_cast<T>(value); });
      pointers.push_back(values[i].data());
    }
    decoding_.forward(pointers, pass.graph[0], mode);
    const std::size_t size = head.channel_count() * head.candidate_count();
    std::copy_n(pass.graph[0].output(0), size, pass.logits[0].data() + n * size);
  }
}

template <std::floating_point T>
void ForeignDetector<T>::refuse_gradient(const char* operation) {
  throw DomainError("ForeignDetector::" + std::string(operation) +
                    ": a foreign detector runs forward only and tells no layers");
}

template <std::floating_point T>
std::vector<ForeignOutput> ForeignDetector<T>::run_first(const Engine& engine, std::size_t size) {
  if (!engine) throw DomainError("ForeignDetector: the engine is an empty function");
  return engine(std::vector<float>(size));
}

template <std::floating_point T>
nn::NetworkDescription ForeignDetector<T>::decoding_of(const DetectorDescription& kind,
                                                       const std::vector<nn::Shape>& shapes,
                                                       std::size_t height, std::size_t width) {
  if (kind.head != HeadKind::boxes_and_scores)
    throw DomainError("ForeignDetector: heads are " + std::string(name_of(kind.head)) +
                      ", expected boxes_and_scores");
  const std::vector<std::string> names{kind.decoded.boxes, kind.decoded.scores};
  const std::size_t count = names[0] == names[1] ? 1 : 2;
  if (shapes.size() != count)
    throw FileError(ErrorKind::mismatch, {subject, "", "outputs of one picture", std::to_string(count),
                                          std::to_string(shapes.size())});
  nn::NetworkDescription description;
  description.path = subject;
  description.opset = 13;
  for (const auto& shape : shapes)
    if (shape.size() != 3 || shape[0] != 1)
      throw FileError(ErrorKind::mismatch, {subject, "", "axes of an output",
                                            kind.decoded.channels_first ? "[1, channels, candidates]"
                                                                        : "[1, candidates, channels]",
                                            tapestry::detail::to_text(shape)});
  for (std::size_t i = 0; i < count; ++i)
    description.inputs.push_back({names[i], {shapes[i].begin(), shapes[i].end()}});
  description.outputs = {add_decoded_outputs(description, kind.decoded, height, width)};
  return description;
}

template <std::floating_point T>
std::vector<nn::Shape> ForeignDetector<T>::shapes_of(const std::vector<ForeignOutput>& outputs) {
  std::vector<nn::Shape> shapes;
  for (const ForeignOutput& output : outputs) {
    if (nn::size_of(output.shape) != output.values.size())
      throw FileError(ErrorKind::mismatch,
                      {subject, "", "values of an output", std::to_string(nn::size_of(output.shape)),
                       std::to_string(output.values.size())});
    shapes.push_back(output.shape);
  }
  return shapes;
}

template <std::floating_point T>
std::vector<ForeignOutput> ForeignDetector<T>::run(const std::vector<float>& picture) const {
  const std::lock_guard lock(one_at_a_time_);
  auto outputs = engine_(picture);
  if (shapes_of(outputs) != shapes_)
    throw FileError(ErrorKind::mismatch, {subject, "", "extents that change from picture to picture"});
  return outputs;
}

template class ForeignDetector<float>;
template class ForeignDetector<double>;

}  // namespace tapestry::detect
