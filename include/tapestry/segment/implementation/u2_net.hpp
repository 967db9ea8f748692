#pragma once
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/segment/car_component.hpp>
#include <tapestry/segment/u2_net.hpp>

namespace tapestry::segment {
Array<std::uint8_t, 2> car_component(const Array<float, 2>& mask, const std::optional<Region>& region,
                                     double threshold) {
  const std::size_t height = mask.shape(0), width = mask.shape(1);
  auto chosen = zeros<std::uint8_t, 2>({height, width});
  std::vector<std::uint8_t> waits(mask.size());
  for (std::size_t i = 0; i < mask.size(); ++i) waits[i] = static_cast<double>(mask.data()[i]) >= threshold;

  const auto lies_in_region = [&](std::size_t pixel) {
    const double x = static_cast<double>(pixel % width) + 0.5, y = static_cast<double>(pixel / width) + 0.5;
    return region && x >= region->left && x < region->right && y >= region->top && y < region->bottom;
  };
  std::vector<std::size_t> piece, best;
  std::size_t best_inside = 0;
  for (std::size_t first = 0; first < mask.size(); ++first) {
    if (waits[first] == 0) continue;
    const auto take = [&](std::size_t pixel) {
      if (waits[pixel] == 0) return;
      waits[pixel] = 0;
      piece.push_back(pixel);
    };
    piece.clear();
    take(first);
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const std::size_t pixel = piece[i], column = pixel % width;
      if (pixel >= width) take(pixel - width);
      if (column > 0) take(pixel - 1);
      if (column + 1 < width) take(pixel + 1);
      if (pixel + width < mask.size()) take(pixel + width);
    }
    const auto inside = static_cast<std::size_t>(std::count_if(piece.begin(), piece.end(), lies_in_region));
    if (region && inside == 0) continue;
    if (inside < best_inside || (inside == best_inside && piece.size() <= best.size())) continue;
    best_inside = inside;
    best.swap(piece);
  }
  for (const std::size_t pixel : best) chosen.data()[pixel] = 1;
  return chosen;
}

double mask_iou(const Array<std::uint8_t, 2>& a, const Array<std::uint8_t, 2>& b) {
  require_shape("mask_iou", "b", b, a.shape());
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a.data()[i] != 0 && b.data()[i] != 0) ++both;
    if (a.data()[i] != 0 || b.data()[i] != 0) ++either;
  }
  return either == 0 ? 1 : static_cast<double>(both) / static_cast<double>(either);
}

Array<float, 3> u2_net_input(const Array<float, 3>& picture) {
  require_shape("u2_net_input", "picture", picture, {picture.shape(0), picture.shape(1), 3});
  Array<float, 3> input(picture.shape());
  const float largest = picture.size() == 0 ? 0.0F : picture.data()[detail::brightest(picture)];
  const double scale = largest > 0 ? 1 / static_cast<double>(largest) : 1;
  for (std::size_t i = 0; i < picture.size(); ++i)
    input.data()[i] = static_cast<float>(
        (static_cast<double>(picture.data()[i]) * scale - detect::imagenet_encoding.mean[i % 3]) /
        detect::imagenet_encoding.deviation[i % 3]);
  return input;
}

void u2_net_input_adjoint(const Array<float, 3>& picture, const Array<float, 3>& input_adjoint,
                          Array<float, 3>& picture_adjoint) {
  require_shape("u2_net_input_adjoint", "picture", picture, {picture.shape(0), picture.shape(1), 3});
  require_shape("u2_net_input_adjoint", "input_adjoint", input_adjoint, picture.shape());
  require_shape("u2_net_input_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  if (picture.size() == 0) return;
  const std::size_t place = detail::brightest(picture);
  const auto largest = static_cast<double>(picture.data()[place]);
  const double scale = largest > 0 ? 1 / largest : 1;
  double along_picture = 0;  // Σ x̄ · p / deviation
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const double share =
        static_cast<double>(input_adjoint.data()[i]) / detect::imagenet_encoding.deviation[i % 3];
    picture_adjoint.data()[i] += static_cast<float>(share * scale);
    along_picture += share * static_cast<double>(picture.data()[i]);
  }
  if (largest > 0) picture_adjoint.data()[place] -= static_cast<float>(along_picture * scale * scale);
}

U2Net::U2Net(const nn::NetworkDescription& network, std::size_t side)
    : network_(nn::pruned(network, {first_output(network)}), input_shape(network, side), true) {
  const nn::Shape expected{1, 1, this->side(), this->side()};
  if (network_.output_shape(0) != expected)
    throw file_mismatch(
        {network.path, "", "the first output " + in_quotes(network.outputs.front()) + " is no mask",
         tapestry::detail::to_text(expected), tapestry::detail::to_text(network_.output_shape(0))});
}

void U2Net::forward(const Array<float, 3>& picture, U2NetPass& pass, nn::Mode mode) const {
  require_shape("U2Net::forward", "picture", picture, {picture.shape(0), picture.shape(1), 3});
  if (!all_finite(picture.data(), picture.size()))
    throw DomainError("U2Net::forward: the picture has values that are not finite");
  pass.extents = picture.shape();
  reduce(picture, pass);
  const Array<float, 3> input = u2_net_input(pass.reduced.back());
  pass.input.resize(input.size());
  std::copy_n(input.data(), input.size(), pass.input.data());
  network_.forward({pass.input.data()}, pass.network, mode);

  const float* const d = pass.network.output(0);
  const std::size_t count = side() * side();
  if (!all_finite(d, count)) throw NumericError("U2Net::forward: the network's mask is not finite");
  const auto [least, most] = std::minmax_element(d, d + count);
  Array<float, 3> stretched(Extents<3>{side(), side(), 1});
  const float range = *most - *least;
  for (std::size_t i = 0; i < count; ++i) stretched.data()[i] = range > 0 ? (d[i] - *least) / range : 0;
  const auto resized = image::resize_bilinear(stretched, pass.extents[0], pass.extents[1]);
  pass.mask.resize({pass.extents[0], pass.extents[1]});
  std::copy_n(resized.data(), resized.size(), pass.mask.data());
}

Array<float, 2> U2Net::operator()(const Array<float, 3>& picture) const {
  U2NetPass pass;
  forward(picture, pass);
  return std::move(pass.mask);
}

void U2Net::pull_back(U2NetPass& pass, const Array<float, 2>& mask_adjoint,
                      Array<float, 3>& picture_adjoint) const {
  require_shape("U2Net::pull_back", "mask_adjoint", mask_adjoint, {pass.extents[0], pass.extents[1]});
  require_shape("U2Net::pull_back", "picture_adjoint", picture_adjoint, pass.extents);
  if (pass.reduced.empty()) throw DomainError("U2Net::pull_back: the pass holds no results");
  const Array<float, 2> map_adjoint = adjoint_of_map(pass, mask_adjoint);
  nn::Buffer<float> input_adjoint;
  input_adjoint.resize(3 * side() * side());
  input_adjoint.fill_zero();
  network_.adjoint(pass.network, {map_adjoint.data()}, {input_adjoint.data()});

  Array<float, 3> scaled_adjoint(pass.reduced.back().shape());
  std::copy_n(input_adjoint.data(), scaled_adjoint.size(), scaled_adjoint.data());
  auto adjoint = zeros<float, 3>(pass.reduced.back().shape());
  u2_net_input_adjoint(pass.reduced.back(), scaled_adjoint, adjoint);
  for (std::size_t level = pass.reduced.size() - 1; level-- > 0;) {
    auto larger = zeros<float, 3>(pass.reduced[level].shape());
    image::resize_bilinear_adjoint(adjoint, larger);
    adjoint = std::move(larger);
  }
  image::resize_bilinear_adjoint(adjoint, picture_adjoint);
}

std::string U2Net::first_output(const nn::NetworkDescription& network) {
  if (network.outputs.empty())
    throw file_mismatch({network.path, "", "no network that makes masks", "an output", "none"});
  return network.outputs.front();
}

std::map<std::string, nn::Shape> U2Net::input_shape(const nn::NetworkDescription& network, std::size_t side) {
  const auto refuse = [&](const std::string& found) {
    throw file_mismatch({network.path, "", "no network of pictures", "one input [1, 3, S, S]", found});
  };
  if (network.inputs.size() != 1) refuse(std::to_string(network.inputs.size()) + " inputs");
  const nn::InputDescription& input = network.inputs.front();
  if (input.shape.size() != 4)
    refuse(in_quotes(input.name) + " of " + std::to_string(input.shape.size()) + " axes");
  nn::Shape shape{1, 3};
  for (const std::size_t axis : {2U, 3U}) {
    const std::size_t own = input.shape[axis].value_or(published_side);
    shape.push_back(side == 0 ? own : side);
  }
  nn::Shape stated = shape;
  for (const std::size_t axis : {0U, 1U}) stated[axis] = input.shape[axis].value_or(shape[axis]);
  if (stated[0] != 1 || stated[1] != 3 || shape[2] != shape[3] || shape[2] == 0)
    refuse(in_quotes(input.name) + " " + tapestry::detail::to_text(stated));
  return {{input.name, std::move(shape)}};
}

void U2Net::reduce(const Array<float, 3>& picture, U2NetPass& pass) const {
  pass.reduced.clear();
  const auto halved = [this](std::size_t extent) { return extent >= 2 * side() ? (extent + 1) / 2 : extent; };
  for (const Array<float, 3>* from = &picture;; from = &pass.reduced.back()) {
    const std::size_t rows = halved(from->shape(0)), columns = halved(from->shape(1));
    const bool is_last = rows == from->shape(0) && columns == from->shape(1);
    pass.reduced.push_back(
        image::resize_bilinear(*from, is_last ? side() : rows, is_last ? side() : columns));
    if (is_last) return;
  }
}

Array<float, 2> U2Net::adjoint_of_map(const U2NetPass& pass, const Array<float, 2>& mask_adjoint) const {
  Array<float, 3> resized_adjoint(Extents<3>{mask_adjoint.shape(0), mask_adjoint.shape(1), 1});
  std::copy_n(mask_adjoint.data(), mask_adjoint.size(), resized_adjoint.data());
  auto stretched_adjoint = zeros<float, 3>({side(), side(), 1});
  image::resize_bilinear_adjoint(resized_adjoint, stretched_adjoint);
  auto map_adjoint = zeros<float, 2>({side(), side()});
  const float* const d = pass.network.output(0);
  const auto [least, most] = std::minmax_element(d, d + map_adjoint.size());
  const double range = static_cast<double>(*most - *least);
  // minmax_element() finds the last of equal largest values; the first takes the adjoint.
  const float* const first_most = std::find(d, d + map_adjoint.size(), *most);
  if (!(range > 0)) return map_adjoint;
  double to_least = 0, to_most = 0;
  for (std::size_t i = 0; i < map_adjoint.size(); ++i) {
    const auto share = static_cast<double>(stretched_adjoint.data()[i]) / range;
    const double stretched = static_cast<double>(d[i] - *least) / range;
    map_adjoint.data()[i] = static_cast<float>(share);
    to_least -= share * (1 - stretched);
    to_most -= share * stretched;
  }
  map_adjoint.data()[least - d] += static_cast<float>(to_least);
  map_adjoint.data()[first_most - d] += static_cast<float>(to_most);
  return map_adjoint;
}

ArrayVariable<float, 2> mask(const U2Net& network, const ArrayVariable<float, 3>& picture) {
  auto pass = std::make_shared<U2NetPass>();
  network.forward(picture.value(), *pass,
                  picture.is_active() ? nn::Mode::input_gradient : nn::Mode::inference);
  const auto pullback = [&network, pass](const Array<float, 2>& mask_adjoint,
                                         Array<float, 3>* picture_adjoint) {
    network.pull_back(*pass, mask_adjoint, *picture_adjoint);
  };
  return record_array(std::shared_ptr<const Array<float, 2>>(pass, &pass->mask), pullback, picture);
}
}  // namespace tapestry::segment
