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

namespace detail {
/// A pass of a detector with tangents: the arrays of logits, and as many of their tangents.
template <std::floating_point T>
struct TangentPass {
  std::vector<HeadPiece> pieces;
  std::size_t outputs, heads;  ///< of the network without tangents
  std::vector<Extents<4>> shapes{};
  std::vector<nn::NetworkPass<T>> graph{};
  std::vector<nn::Buffer<T>> inputs{};  ///< of each image, then its tangent

  TangentPass(const Detector<T>& detector, std::size_t images)
      : pieces(detector.head_pieces()),
        outputs(detector.tangents().output_count() / 2),
        heads(pieces.back().head + 1),
        graph(images),
        inputs(2 * images) {
    for (std::size_t i = 0; i < 2 * heads; ++i) {
      const Head& head = detector.heads().at(i % heads);
      shapes.push_back({images, head.channel_count(), head.grid_height, head.grid_width});
    }
  }

  /// Calls visit(array, output of the network, first element in image n, number of elements).
  template <class Visit>
  void for_each_piece(std::size_t n, Visit visit) const {
    for (std::size_t i = 0; i < 2; ++i)
      for (const HeadPiece& piece : pieces) {
        const Extents<4>& extents = shapes[i * heads + piece.head];
        visit(i * heads + piece.head, i * outputs + piece.output,
              (n * extents[1] + piece.first_channel) * extents[2] * extents[3], piece.size);
      }
  }
};
}  // namespace detail

template <std::floating_point T>
std::pair<std::vector<ArrayVariable<T, 4>>, std::vector<ArrayVariable<T, 4>>> forward_tangents(
    const Detector<T>& detector, const ArrayVariable<T, 4>& inputs, const ArrayVariable<T, 4>& tangents) {
  const nn::Network<T>& network = detector.tangents();
  detector.require_images(inputs.value());
  require_shape("forward_tangents", "tangents", tangents.value(), inputs.shape());
  const std::size_t images = inputs.shape()[0], size = inputs.size() / images;
  const auto pass = std::make_shared<detail::TangentPass<T>>(detector, images);
  std::vector<Array<T, 4>> values;
  for (const Extents<4>& shape : pass->shapes) values.emplace_back(shape);
  const auto mode = inputs.is_active() || tangents.is_active() ? Mode::input_gradient : Mode::inference;
  for (std::size_t n = 0; n < images; ++n) {
    for (std::size_t i = 0; i < 2; ++i) {
      nn::Buffer<T>& input = pass->inputs[2 * n + i];
      input.resize(size);
      std::copy_n((i == 0 ? inputs : tangents).value().data() + n * size, size, input.data());
    }
    network.forward({pass->inputs[2 * n].data(), pass->inputs[2 * n + 1].data()}, pass->graph[n], mode);
    pass->for_each_piece(n, [&](std::size_t array, std::size_t output, std::size_t first, std::size_t count) {
      std::copy_n(pass->graph[n].output(output), count, values[array].data() + first);
    });
  }
  const auto pullback = [=, &network](const std::vector<const Array<T, 4>*>& adjoints,
                                      Array<T, 4>* inputs_adjoint, Array<T, 4>* tangents_adjoint) {
    for (std::size_t n = images; n-- > 0;) {
      std::vector<const T*> of_outputs(2 * pass->outputs, nullptr);
      pass->for_each_piece(n, [&](std::size_t array, std::size_t output, std::size_t first, std::size_t) {
        if (adjoints[array] != nullptr) of_outputs[output] = adjoints[array]->data() + first;
      });
      const auto of_image = [&](Array<T, 4>* all) {
        return all == nullptr ? nullptr : all->data() + n * size;
      };
      network.adjoint(pass->graph[n], of_outputs, {of_image(inputs_adjoint), of_image(tangents_adjoint)});
    }
  };
  auto all = record_arrays<T, 4>(std::move(values), pullback, inputs, tangents);
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(pass->heads);
  return {{all.begin(), middle}, {middle, all.end()}};
}
}  // namespace tapestry::detect
