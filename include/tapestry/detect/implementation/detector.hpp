#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <system_error>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/detect/foreign_engine.hpp>
#include <tapestry/detect/input_encoding.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/detect/raw_outputs.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/image/planes.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/pruned.hpp>
#include <tapestry/nn/window.hpp>
#include <utility>
#include <variant>
#include <vector>

namespace tapestry::detect {

namespace detail {
/// Whether a network takes the statistics of the batch that it runs.
[[nodiscard]] inline bool takes_batch_statistics(const nn::NetworkDescription& network) {
  return std::ranges::any_of(network.nodes, [](const nn::Node& node) {
    const auto found = node.attributes.find("training_mode");
    if (node.operation != "BatchNormalization" || found == node.attributes.end()) return false;
    const auto* const mode = std::get_if<std::int64_t>(&found->second);
    return mode != nullptr && *mode != 0;
  });
}

[[nodiscard]] inline nn::NetworkDescription with_outputs(nn::NetworkDescription network,
                                                         const std::vector<std::string>& layers) {
  network.outputs.insert(network.outputs.end(), layers.begin(), layers.end());
  return network;
}

inline constexpr const char* foreign_subject = "outputs of a foreign engine";

[[nodiscard]] inline std::vector<ForeignOutput> first_outputs(const ForeignEngine& engine, std::size_t size) {
  if (!engine) throw DomainError("Detector: the engine is an empty function");
  return engine(std::vector<float>(size));
}

[[nodiscard]] inline std::vector<nn::Shape> shapes_of(const std::vector<ForeignOutput>& outputs) {
  std::vector<nn::Shape> shapes;
  for (const ForeignOutput& output : outputs) {
    if (nn::size_of(output.shape) != output.values.size())
      throw FileError(ErrorKind::mismatch,
                      {foreign_subject, "", "values of an output", std::to_string(nn::size_of(output.shape)),
                       std::to_string(output.values.size())});
    shapes.push_back(output.shape);
  }
  return shapes;
}

/// The network that makes a head's logits of a foreign engine's outputs of these extents.
[[nodiscard]] inline nn::NetworkDescription decoding_of(const DetectorDescription& kind,
                                                        const std::vector<nn::Shape>& shapes,
                                                        std::size_t height, std::size_t width) {
  if (kind.head != HeadKind::boxes_and_scores)
    throw DomainError("Detector: heads of a foreign engine are " + std::string(name_of(kind.head)) +
                      ", expected boxes_and_scores");
  const std::vector<std::string> names{kind.decoded.boxes, kind.decoded.scores};
  const std::size_t count = names[0] == names[1] ? 1 : 2;
  if (shapes.size() != count)
    throw FileError(ErrorKind::mismatch, {foreign_subject, "", "outputs of one picture",
                                          std::to_string(count), std::to_string(shapes.size())});
  nn::NetworkDescription description;
  description.path = foreign_subject;
  description.opset = 13;
  for (const auto& shape : shapes)
    if (shape.size() != 3 || shape[0] != 1)
      throw FileError(ErrorKind::mismatch, {foreign_subject, "", "axes of an output",
                                            kind.decoded.channels_first ? "[1, channels, candidates]"
                                                                        : "[1, candidates, channels]",
                                            tapestry::detail::to_text(shape)});
  for (std::size_t i = 0; i < count; ++i)
    description.inputs.push_back({names[i], {shapes[i].begin(), shapes[i].end()}});
  description.outputs = {add_decoded_outputs(description, kind.decoded, height, width)};
  return description;
}
}  // namespace detail

template <std::floating_point T>
struct Detector<T>::Foreign {
  ForeignEngine engine;
  std::vector<nn::Shape> shapes;  ///< of its outputs
  std::mutex one_at_a_time{};
};

template <std::floating_point T>
Detector<T>::Detector(const nn::NetworkDescription& network, DetectorDescription kind, std::size_t size,
                      const std::vector<std::string>& layers, bool simplifies)
    : kind_(std::move(kind)),
      layer_count_(layers.size()),
      network_(showing_heads(network, kind_, size, layers), sizes(network, size), true, simplifies),
      height_(network_.input_shape(0)[1]),
      width_(network_.input_shape(0)[2]),
      heads_(exported_heads(network.path, kind_, output_shapes(), height_, width_)),
      trains_together_(detail::takes_batch_statistics(network)) {
  require_layers(network.path, layers);
}

template <std::floating_point T>
Detector<T>::Detector(const nn::NetworkDescription& network, std::vector<Head> heads,
                      const std::vector<std::string>& layers, bool simplifies)
    : layer_count_(layers.size()),
      network_(detail::with_outputs(network, layers), {}, true, simplifies),
      height_(network_.input_shape(0)[1]),
      width_(network_.input_shape(0)[2]),
      heads_{std::move(heads), {}},
      trains_together_(detail::takes_batch_statistics(network)) {
  for (std::size_t h = 0; h < std::max<std::size_t>(1, heads_.heads.size()); ++h)
    heads_.pieces.push_back({h, h, 0, nn::size_of(network_.output_shape(h))});
  for (std::size_t h = 0; h < heads_.heads.size(); ++h) {
    const Head& head = heads_.heads[h];
    const nn::Shape expected{1, head.channel_count(), head.grid_height, head.grid_width};
    if (network_.output_shape(h) != expected)
      throw ShapeError("Detector: output " + std::to_string(h) + " is " +
                       tapestry::detail::to_text(network_.output_shape(h)) + ", expected " +
                       tapestry::detail::to_text(expected));
  }
  require_layers(network.path, layers);
}

template <std::floating_point T>
Detector<T>::Detector(const ForeignEngine& engine, DetectorDescription kind, std::size_t height,
                      std::size_t width)
    : kind_(std::move(kind)),
      foreign_(new Foreign{engine, detail::shapes_of(detail::first_outputs(engine, 3 * height * width))}),
      network_(detail::decoding_of(kind_, foreign_->shapes, height, width)),
      height_(height),
      width_(width),
      heads_(exported_heads(detail::foreign_subject, kind_, output_shapes(), height, width)) {}

template <std::floating_point T>
std::size_t Detector<T>::class_index(std::string_view name) const {
  if (!names_.empty()) {
    const auto found = std::ranges::find(names_, name);
    if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
    std::string list;
    for (std::size_t i = 0; i < std::min<std::size_t>(names_.size(), 20); ++i)
      list += (i > 0 ? ", " : "") + names_[i];
    if (names_.size() > 20) list += ", … (" + std::to_string(names_.size()) + " in all)";
    throw Error(ErrorKind::mismatch, "no class is named " + in_quotes(name) + "; there are " + list);
  }
  const std::size_t classes = heads().empty() ? 0 : heads().front().classes;
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  if (name.empty() || error != std::errc{} || end != name.data() + name.size())
    throw Error(ErrorKind::usage, "class " + in_quotes(name) +
                                      " needs the names of the classes; without them it must be a number");
  if (index >= classes)
    throw Error(ErrorKind::mismatch,
                "class " + std::string(name) + ": the detector has " + std::to_string(classes) + " classes");
  return index;
}

template <std::floating_point T>
Array<T, 4> Detector<T>::input(const Array<T, 3>& photograph) const {
  return image::batch_of(image::fitted(photograph, height_, width_, kind_.fit));
}

template <std::floating_point T>
std::vector<Detection> Detector<T>::detections(const std::vector<Array<T, 4>>& logits, std::size_t image,
                                               double confidence, double overlap) const {
  return suppress(decode(heads(), logits, image, confidence, height_, width_), overlap, true, measure_);
}

template <std::floating_point T>
std::vector<Detection> Detector<T>::in_photograph(std::vector<Detection> detections, std::size_t height,
                                                  std::size_t width) const {
  const auto back = image::picture_from_canvas(height, width, height_, width_, kind_.fit.kind);
  for (Detection& detection : detections) {
    Box& box = detection.box;
    box = {back.x(box.cx), back.y(box.cy), back.width(box.w), back.height(box.h)};
  }
  return detections;
}

template <std::floating_point T>
void Detector<T>::require_images(const Array<T, 4>& images) const {
  if (images.shape(0) == 0) throw ShapeError("Detector::forward: a batch of no images");
  require_shape("Detector::forward", "images", images, {images.shape(0), height_, width_, input_channels()});
}

template <std::floating_point T>
void Detector<T>::require_logits_adjoint(const char* operation, const Pass<T>& pass,
                                         const std::vector<const Array<T, 4>*>& logits_adjoint) {
  if (pass.mode == Mode::inference || pass.graph.empty())
    throw DomainError(std::string(operation) + ": the pass kept nothing; run forward() for a gradient first");
  if (logits_adjoint.size() != pass.logits.size())
    throw ShapeError(std::string(operation) + ": logits_adjoint has " +
                     std::to_string(logits_adjoint.size()) + " arrays, expected " +
                     std::to_string(pass.logits.size()));
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
void Detector<T>::require_layers(const std::string& path, const std::vector<std::string>& layers) const {
  for (std::size_t layer = 0; layer < layer_count_; ++layer)
    if (const auto& shape = layer_shape(layer); shape.size() != 4 || shape[0] != 1)
      throw FileError(ErrorKind::mismatch, {path, "", "layer " + in_quotes(layers[layer]),
                                            "maps, [1, C, H, W]", std::to_string(shape.size()) + " axes"});
}

template <std::floating_point T>
void Detector<T>::require_layer(const char* operation, const Pass<T>& pass, std::size_t layer,
                                std::size_t image) const {
  if (layer >= layer_count_)
    throw DomainError(std::string(operation) + ": layer " + std::to_string(layer) + " of the " +
                      std::to_string(layer_count_) + " that were named");
  if (image >= pass.images || pass.graph.empty())
    throw DomainError(std::string(operation) + ": image " + std::to_string(image) + " of a batch of " +
                      std::to_string(pass.images));
}

template <std::floating_point T>
std::array<std::size_t, 3> Detector<T>::logits_extents(std::size_t head) const {
  if (!heads_.heads.empty())
    return {heads_.heads[head].channel_count(), heads_.heads[head].grid_height,
            heads_.heads[head].grid_width};
  const nn::Shape& shape = network_.output_shape(0);
  return {shape.at(1), shape.at(2), shape.at(3)};
}

template <std::floating_point T>
Array<T, 3> Detector<T>::layer_values(const Pass<T>& pass, std::size_t layer, std::size_t image) const {
  require_whole("Detector::layer_values", pass);
  require_layer("Detector::layer_values", pass, layer, image);
  const auto& shape = layer_shape(layer);
  Array<T, 3> values(Extents<3>{shape[1], shape[2], shape[3]});
  const std::size_t each = images_a_pass(pass);
  std::copy_n(pass.graph[image / each].output(head_output_count() + layer) + image % each * values.size(),
              values.size(), values.data());
  return values;
}

template <std::floating_point T>
void Detector<T>::require_whole(const char* operation, const Pass<T>& pass) {
  const auto is_within = [](const nn::NetworkPass<T>& one) { return one.is_within(); };
  if (pass.mode == Mode::inference || pass.graph.empty() || std::ranges::any_of(pass.graph, is_within))
    throw DomainError(std::string(operation) +
                      ": the pass kept nothing, or only windows; run forward() for a gradient first");
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
  std::vector<T*> gathered(network_.output_count(), nullptr);
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
  require_shape("Detector::pull_back_layer", "Detector::layer_adjoint", layer_adjoint,
                {shape[1], shape[2], shape[3]});
  require_shape("Detector::pull_back_layer", "images_adjoint", images_adjoint,
                {pass.images, height_, width_, input_channels()});
  const std::size_t each = images_a_pass(pass);
  std::vector<T> of_all(each * layer_adjoint.size(), T(0));
  std::copy_n(layer_adjoint.data(), layer_adjoint.size(),
              of_all.data() + image % each * layer_adjoint.size());
  std::vector<const T*> asked(network_.output_count(), nullptr);
  asked[head_output_count() + layer] = of_all.data();
  pull_back_one(pass, image / each, asked, &images_adjoint, nullptr);
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
  return foreign_ ? 0 : network_.share_kept(rows_and_columns(window));
}

template <std::floating_point T>
void Detector<T>::run(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
                      Mode mode) const {
  if (foreign_ && mode != Mode::inference)
    throw DomainError("Detector::forward: a foreign engine runs forward only");
  pass.mode = mode;
  pass.images = images.shape(0);
  pass.ran_by.reset();
  const std::size_t each = mode == Mode::training && trains_together_ ? pass.images : 1;
  const std::size_t count = pass.images / each;
  pass.graph.resize(mode == Mode::inference ? 1 : count);  // whose memory serves one image after another
  pass.inputs.resize(pass.graph.size());
  pass.logits.resize(logits_count());
  for (std::size_t h = 0; h < pass.logits.size(); ++h) {
    const auto [channels, height, width] = logits_extents(h);
    pass.logits[h].resize({pass.images, channels, height, width});
  }
  if (foreign_) return run_foreign(images, pass);
  for (std::size_t n = 0; n < count; ++n) {
    nn::NetworkPass<T>& one = pass.graph[mode == Mode::inference ? 0 : n];
    nn::Buffer<T>& input = pass.inputs[mode == Mode::inference ? 0 : n];
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
    for (const HeadPiece& piece : heads_.pieces)
      for (std::size_t k = 0; k < each; ++k)
        std::copy_n(one.output(piece.output) + k * piece.size, piece.size,
                    at(piece, pass.logits[piece.head], n * each + k));
  }
}

template <std::floating_point T>
void Detector<T>::run_foreign(const Array<T, 4>& images, Pass<T>& pass) const {
  const Array<T, 4> input = image::planes_of(encoded(images, kind_.encoding));
  std::vector<float> picture(image_size());
  const HeadPiece& piece = heads_.pieces.front();
  for (std::size_t n = 0; n < pass.images; ++n) {
    std::transform(input.data() + n * picture.size(), input.data() + (n + 1) * picture.size(),
                   picture.begin(), [](T value) { return static_cast<float>(value); });
    const auto outputs = [&] {
      const std::lock_guard lock(foreign_->one_at_a_time);
      return foreign_->engine(picture);
    }();
    if (detail::shapes_of(outputs) != foreign_->shapes)
      throw FileError(ErrorKind::mismatch,
                      {detail::foreign_subject, "", "extents that change from picture to picture"});
    std::vector<nn::Buffer<T>> values(outputs.size());
    std::vector<const T*> pointers;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      values[i].resize(outputs[i].values.size());
      std::ranges::transform(outputs[i].values, values[i].data(),
                             [](float value) { return static_cast<T>(value); });
      pointers.push_back(values[i].data());
    }
    network_.forward(pointers, pass.graph[0]);
    std::copy_n(pass.graph[0].output(0), piece.size, at(piece, pass.logits[0], n));
  }
}

template <std::floating_point T>
void Detector<T>::pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                            Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint) const {
  require_logits_adjoint("Detector::pull_back", pass, logits_adjoint);
  if (images_adjoint != nullptr)
    require_shape("Detector::pull_back", "images_adjoint", *images_adjoint,
                  {pass.images, height_, width_, input_channels()});
  if (parameters_adjoint != nullptr)
    require_shape("Detector::pull_back", "parameters_adjoint", *parameters_adjoint,
                  {network_.constants().size()});
  for (std::size_t n = pass.graph.size(); n-- > 0;) {  // the last one's memory is in the cache
    const auto adjoints = output_adjoints(pass, n, logits_adjoint);
    pull_back_one(pass, n, adjoints.of_outputs, images_adjoint,
                  parameters_adjoint == nullptr ? nullptr : parameters_adjoint->data());
  }
}

template <std::floating_point T>
void Detector<T>::pull_back_one(Pass<T>& pass, std::size_t n, const std::vector<const T*>& of_outputs,
                                Array<T, 4>* images_adjoint, T* constants_adjoint,
                                const std::vector<T*>& gathered) const {
  nn::Buffer<T> input_adjoint;
  if (images_adjoint != nullptr) {
    input_adjoint.resize(images_a_pass(pass) * image_size());
    input_adjoint.fill_zero();
  }
  network_.adjoint(pass.graph[n], of_outputs, {images_adjoint != nullptr ? input_adjoint.data() : nullptr},
                   constants_adjoint, gathered);
  if (images_adjoint == nullptr) return;
  T* const to = images_adjoint->data() + n * input_adjoint.size();
  if (kind_.encoding == InputEncoding{}) {
    for (std::size_t i = 0; i < input_adjoint.size(); ++i) to[i] += input_adjoint.data()[i];
  } else {
    encode_adjoint(input_adjoint.data(), input_adjoint.size() / 3, kind_.encoding, to);
  }
}

template <std::floating_point T>
std::map<std::string, nn::Shape> Detector<T>::sizes(const nn::NetworkDescription& network, std::size_t size) {
  const auto refuse = [&](const std::string& found) {
    throw FileError(ErrorKind::mismatch,
                    {network.path, "", "not a detector of pictures", "one input [1, 3, H, W]", found});
  };
  if (network.inputs.size() != 1) refuse(std::to_string(network.inputs.size()) + " inputs");
  const auto& shape = network.inputs.front().shape;
  if (shape.size() != 4 || shape[1].value_or(3) != 3 || shape[0].value_or(1) != 1)
    refuse("input " + in_quotes(network.inputs.front().name) + " of other extents");
  if (size == 0 && (!shape[2] || !shape[3]))
    throw FileError(ErrorKind::mismatch,
                    {network.path, "", "the input's size is open; state it with --size"});
  return {{network.inputs.front().name, {1, 3, size == 0 ? *shape[2] : size, size == 0 ? *shape[3] : size}}};
}

template <std::floating_point T>
void Detector<T>::require_value(const nn::NetworkDescription& network, const std::string& what,
                                const std::string& name) {
  const auto makes = [&](const nn::Node& node) { return std::ranges::count(node.outputs, name) > 0; };
  if (std::ranges::none_of(network.nodes, makes))
    throw FileError(ErrorKind::mismatch,
                    {network.path, "", "no node makes the " + what + " " + in_quotes(name)});
}

template <std::floating_point T>
nn::NetworkDescription Detector<T>::showing_heads(const nn::NetworkDescription& network,
                                                  const DetectorDescription& kind, std::size_t size,
                                                  const std::vector<std::string>& layers) {
  for (const std::string& layer : layers) require_value(network, "layer", layer);
  if (kind.head != HeadKind::boxes_and_scores) {
    auto outputs = raw_outputs(network);
    outputs.insert(outputs.end(), layers.begin(), layers.end());
    return nn::pruned(network, std::move(outputs));
  }
  require_value(network, "output", kind.decoded.boxes);
  require_value(network, "output", kind.decoded.scores);
  const auto input = sizes(network, size).begin()->second;
  auto shown = network;
  std::vector<std::string> outputs{add_decoded_outputs(shown, kind.decoded, input[2], input[3])};
  outputs.insert(outputs.end(), layers.begin(), layers.end());
  return nn::pruned(std::move(shown), std::move(outputs));
}

template <std::floating_point T>
std::vector<nn::Shape> Detector<T>::output_shapes() const {
  std::vector<nn::Shape> shapes;
  for (std::size_t i = 0; i < head_output_count(); ++i) shapes.push_back(network_.output_shape(i));
  return shapes;
}

template <std::floating_point T>
auto Detector<T>::output_adjoints(const Pass<T>& pass, std::size_t n,
                                  const std::vector<const Array<T, 4>*>& logits_adjoint) const
    -> OutputAdjoints {
  OutputAdjoints adjoints{std::vector<const T*>(network_.output_count(), nullptr), {}};
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
    adjoints.of_outputs[piece.output] = joined.data();  // which a move of `joined` leaves where it is
  }
  return adjoints;
}

template <std::floating_point T>
Detector<T>::Detector(Detector&&) noexcept = default;

template <std::floating_point T>
Detector<T>& Detector<T>::operator=(Detector&&) noexcept = default;

template <std::floating_point T>
Detector<T>::~Detector() = default;

template class Detector<float>;
template class Detector<double>;

}  // namespace tapestry::detect
