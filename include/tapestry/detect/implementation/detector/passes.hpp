#pragma once
#include <tapestry/detect/implementation/detector/claim.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/nn/pointwise.hpp>

namespace tapestry::detect {
namespace detail {
/// Number of passes to run side by side, each on a thread: 1, except for a batch that can be dealt out evenly
/// and a small network, whose layers are too short for threads to share.
template <std::floating_point T>
[[nodiscard]] std::size_t lanes_for(const nn::Network<T>& network, std::size_t passes) {
  constexpr std::size_t few_weights = std::size_t(1) << 20U;
  const auto threads = static_cast<std::size_t>(thread_count());
  return network.weights().size() <= few_weights && passes % threads == 0 ? threads : 1;
}

/// Calls body(lane, n) for n = 0 … count − 1: in order, or with several lanes on a thread for each.
template <class Body>
void for_each_in_lanes(std::size_t lanes, std::size_t count, Body body) {
  parallel_for(lanes, [&](std::size_t lane) {
    for (std::size_t n = lane; n < count; n += lanes) body(lane, n);
  });
}
}  // namespace detail

template <std::floating_point T>
void Detector<T>::require_images(const Array<T, 4>& images) const {
  if (images.shape(0) == 0) throw ShapeError("Detector::forward: a batch of no images");
  require_shape("Detector::forward", "images", images, {images.shape(0), height_, width_, input_channels()});
}

template <std::floating_point T>
Array<T, 1> Detector<T>::weights() const {
  const auto values = network_.weights();
  Array<T, 1> weights(Extents<1>{values.size()});
  std::ranges::copy(values, weights.data());
  return weights;
}

template <std::floating_point T>
void Detector<T>::set_weights(const Array<T, 1>& weights) {
  network_.set_weights({weights.data(), weights.size()});
  tangents_->network.reset();
}

template <std::floating_point T>
const nn::Network<T>& Detector<T>::tangents() const {
  if (stages_) throw DomainError("Detector::tangents: the network's extents depend on the picture");
  const std::lock_guard<std::mutex> lock(tangents_->mutex);
  if (!tangents_->network) tangents_->network = std::make_unique<nn::Network<T>>(network_.with_tangents());
  return *tangents_->network;
}

template <std::floating_point T>
void Detector<T>::forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode) const {
  require_images(images);
  run(images, std::vector<KeptPicture<T>*>(images.shape(0), nullptr), pass, mode);
}

template <std::floating_point T>
void Detector<T>::forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept,
                                 Pass<T>& pass, Mode mode) const {
  require_images(images);
  require_kept("Detector::forward_within", *this, images, kept);
  run(images, kept, pass, mode);
}

template <std::floating_point T>
double Detector<T>::share_kept(const image::PixelWindow& window) const {
  image::require_window("Detector::share_kept", window, height_, width_);
  return stages_ ? 0 : network_.share_kept(rows_and_columns(window));
}

template <std::floating_point T>
void Detector<T>::run(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
                      Mode mode) const {
  if (stages_ && mode == Mode::training)
    throw DomainError("Detector::forward: a network whose extents depend on the picture does not train");
  pass.mode = mode;
  pass.images = images.shape(0);
  const std::size_t each = mode == Mode::training && trains_together_ ? pass.images : 1;
  const std::size_t count = pass.images / each;
  const std::size_t lanes = pass.times == nullptr ? detail::lanes_for(network_, count) : 1;
  pass.graph.resize(mode == Mode::inference ? lanes : count);  // each lane computes image after image
  pass.inputs.resize(pass.graph.size());
  resize_logits(pass);
  if (stages_) return run_stages(images, pass);
  const bool judges = claim_ && !claim_->is_judged;
  detail::for_each_in_lanes(lanes, count, [&](std::size_t lane, std::size_t n) {
    nn::NetworkPass<T>& one = pass.graph[mode == Mode::inference ? lane : n];
    nn::Buffer<T>& input = pass.inputs[mode == Mode::inference ? lane : n];
    one.set_times(pass.times);
    input.resize(each * image_size());
    const T* const first = images.data() + n * input.size();
    if (kind_.encoding == InputEncoding{}) {
      std::copy_n(first, input.size(), input.data());
    } else {
      encode(first, input.size() / 3, kind_.encoding, input.data());
    }
    if (kept[n] == nullptr || mode == Mode::training) {
      network_.forward({input.data()}, one, mode, each);
    } else {
      network_.forward_within(input.data(), rows_and_columns(kept[n]->window()), kept[n]->values(), one,
                              mode);
    }
    if (judges)
      detail::require_as_described(*claim_, kind_.decoded, shapes_.back(), one.output(shapes_.size() - 1));
    for (const HeadPiece& piece : heads_.pieces)
      for (std::size_t k = 0; k < each; ++k)
        std::copy_n(one.output(piece.output) + k * piece.size, piece.size,
                    at(piece, pass.logits[piece.head], n * each + k));
  });
  if (judges) claim_->is_judged = true;
}

template <std::floating_point T>
void Detector<T>::resize_logits(Pass<T>& pass) const {
  pass.logits.resize(logits_count());
  for (std::size_t h = 0; h < pass.logits.size(); ++h) {
    const auto [channels, height, width] = logits_extents(h);
    pass.logits[h].resize({pass.images, channels, height, width});
  }
}

template <std::floating_point T>
void Detector<T>::pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                            Array<T, 4>* images_adjoint, Array<T, 1>* weights_adjoint) const {
  require_logits_adjoint("Detector::pull_back", pass, logits_adjoint);
  if (images_adjoint != nullptr)
    require_shape("Detector::pull_back", "images_adjoint", *images_adjoint,
                  {pass.images, height_, width_, input_channels()});
  if (weights_adjoint != nullptr)
    require_shape("Detector::pull_back", "weights_adjoint", *weights_adjoint, {network_.weights().size()});
  const std::size_t count = pass.graph.size();
  const bool may_share = weights_adjoint == nullptr && pass.times == nullptr;  // else all add to the same
  detail::for_each_in_lanes(may_share ? detail::lanes_for(network_, count) : 1, count,
                            [&](std::size_t, std::size_t i) {
                              const std::size_t n = count - 1 - i;  // the last one's memory is in the cache
                              const auto adjoints = output_adjoints(pass, n, logits_adjoint);
                              pull_back_one(pass, n, adjoints.of_outputs, images_adjoint,
                                            weights_adjoint == nullptr ? nullptr : weights_adjoint->data());
                            });
}

template <std::floating_point T>
void Detector<T>::pull_back_one(Pass<T>& pass, std::size_t n, const std::vector<const T*>& of_outputs,
                                Array<T, 4>* images_adjoint, T* weights_adjoint,
                                const std::vector<T*>& gathered) const {
  if (stages_) return pull_back_stages(pass, n, of_outputs, images_adjoint, gathered);
  nn::Buffer<T> input_adjoint;
  if (images_adjoint != nullptr) {
    input_adjoint.resize(images_a_pass(pass) * image_size());
    input_adjoint.fill_zero();
  }
  pass.graph[n].set_times(pass.times);
  network_.adjoint(pass.graph[n], of_outputs, {images_adjoint != nullptr ? input_adjoint.data() : nullptr},
                   weights_adjoint, gathered);
  if (images_adjoint == nullptr) return;
  T* const to = images_adjoint->data() + n * input_adjoint.size();
  if (kind_.encoding == InputEncoding{}) {
    nn::add(input_adjoint.data(), to, input_adjoint.size());
  } else {
    encode_adjoint(input_adjoint.data(), input_adjoint.size() / 3, kind_.encoding, to);
  }
}

template <std::floating_point T>
void Detector<T>::require_logits_adjoint(const char* operation, const Pass<T>& pass,
                                         const std::vector<const Array<T, 4>*>& logits_adjoint) {
  if (pass.mode == Mode::inference || pass.graph.empty())
    throw DomainError({operation, ": the pass kept nothing; run forward() for a gradient first"});
  if (logits_adjoint.size() != pass.logits.size())
    throw ShapeError({operation, ": logits_adjoint has ", logits_adjoint.size(), " arrays, expected ",
                      pass.logits.size()});
  for (std::size_t h = 0; h < logits_adjoint.size(); ++h)
    if (logits_adjoint[h] != nullptr)
      require_shape(operation, "logits_adjoint", *logits_adjoint[h], pass.logits[h].shape());
}

template <std::floating_point T>
void Detector<T>::input_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                                Array<T, 4>& images_adjoint) const {
  std::vector<const Array<T, 4>*> pointers;
  for (const auto& array : logits_adjoint) pointers.push_back(&array);
  pull_back(pass, pointers, &images_adjoint);
}

template <std::floating_point T>
auto Detector<T>::output_adjoints(const Pass<T>& pass, std::size_t n,
                                  const std::vector<const Array<T, 4>*>& logits_adjoint) const
    -> OutputAdjoints {
  OutputAdjoints adjoints{std::vector<const T*>(shapes_.size(), nullptr), {}};
  const std::size_t each = images_a_pass(pass);
  for (const HeadPiece& piece : heads_.pieces) {
    const Array<T, 4>* adjoint = logits_adjoint[piece.head];
    if (adjoint == nullptr) continue;
    adjoints.of_outputs[piece.output] = at(piece, *adjoint, n * each);
    if (each == 1) continue;
    std::vector<T>& joined = adjoints.joined.emplace_back();
    for (std::size_t k = 0; k < each; ++k) {
      const T* const first = at(piece, *adjoint, n * each + k);
      joined.insert(joined.end(), first, first + piece.size);
    }
    adjoints.of_outputs[piece.output] = joined.data();  // stays in place when `joined` is moved
  }
  return adjoints;
}

template <std::floating_point T>
void Detector<T>::require_layer(const char* operation, const Pass<T>& pass, std::size_t layer,
                                std::size_t image) const {
  if (layer >= layer_count_)
    throw DomainError({operation, ": layer ", layer, " of the ", layer_count_, " that were named"});
  if (image >= pass.images) throw DomainError({operation, ": image ", image, " of a batch of ", pass.images});
  // It throws where a layer has other extents for this picture than for the first one.
  static_cast<void>(output_values(pass, image / images_a_pass(pass), head_output_count() + layer));
}

template <std::floating_point T>
void Detector<T>::require_whole(const char* operation, const Pass<T>& pass) {
  const auto is_within = [](const nn::NetworkPass<T>& one) { return one.is_within(); };
  if (pass.mode == Mode::inference || pass.graph.empty() || std::ranges::any_of(pass.graph, is_within))
    throw DomainError(
        {operation, ": the pass kept nothing, or only windows; run forward() for a gradient first"});
}

template <std::floating_point T>
Array<T, 3> Detector<T>::layer_values(const Pass<T>& pass, std::size_t layer, std::size_t image) const {
  require_whole("Detector::layer_values", pass);
  require_layer("Detector::layer_values", pass, layer, image);
  const auto& shape = layer_shape(layer);
  Array<T, 3> values(Extents<3>{shape[1], shape[2], shape[3]});
  const std::size_t each = images_a_pass(pass);
  std::copy_n(output_values(pass, image / each, head_output_count() + layer) + image % each * values.size(),
              values.size(), values.data());
  return values;
}

template <std::floating_point T>
Array<T, 3> Detector<T>::layer_adjoint(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                                       std::size_t layer, std::size_t image) const {
  require_whole("Detector::layer_adjoint", pass);
  require_logits_adjoint("Detector::layer_adjoint", pass, logits_adjoint);
  require_layer("Detector::layer_adjoint", pass, layer, image);
  const auto& shape = layer_shape(layer);
  auto adjoint = zeros<T, 3>({shape[1], shape[2], shape[3]});
  const std::size_t each = images_a_pass(pass), n = image / each;
  std::vector<T> of_all(each * adjoint.size(), T(0));
  std::vector<T*> gathered(shapes_.size(), nullptr);
  gathered[head_output_count() + layer] = of_all.data();
  const auto adjoints = output_adjoints(pass, n, logits_adjoint);
  auto ignored = zeros<T, 4>({pass.images, height_, width_, input_channels()});
  pull_back_one(pass, n, adjoints.of_outputs, &ignored, nullptr, gathered);
  std::copy_n(of_all.data() + image % each * adjoint.size(), adjoint.size(), adjoint.data());
  return adjoint;
}

template <std::floating_point T>
void Detector<T>::pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image,
                                  const Array<T, 3>& layer_adjoint, Array<T, 4>& images_adjoint) const {
  require_whole("Detector::pull_back_layer", pass);
  require_layer("Detector::pull_back_layer", pass, layer, image);
  const auto& shape = layer_shape(layer);
  require_shape("Detector::pull_back_layer", "layer_adjoint", layer_adjoint, {shape[1], shape[2], shape[3]});
  require_shape("Detector::pull_back_layer", "images_adjoint", images_adjoint,
                {pass.images, height_, width_, input_channels()});
  const std::size_t each = images_a_pass(pass);
  std::vector<T> of_all(each * layer_adjoint.size(), T(0));
  std::copy_n(layer_adjoint.data(), layer_adjoint.size(),
              of_all.data() + image % each * layer_adjoint.size());
  std::vector<const T*> output_adjoints(shapes_.size(), nullptr);
  output_adjoints[head_output_count() + layer] = of_all.data();
  pull_back_one(pass, image / each, output_adjoints, &images_adjoint, nullptr);
}
}  // namespace tapestry::detect
