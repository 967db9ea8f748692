#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <map>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/finite.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/image/resize.hpp>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/pruned.hpp>
#include <tapestry/segment/u2_net_input.hpp>
#include <utility>
#include <vector>

namespace tapestry::segment {

/// The results of one U2Net::forward(), and what pull_back() needs. May be used again; two threads must not
/// share one.
template <std::floating_point T>
struct U2NetPass {
  Array<T, 2> mask;                  ///< [H, W] of the picture, in [0, 1]
  std::vector<Array<T, 3>> reduced;  ///< the picture ever smaller, the last [S, S, 3]
  Extents<3> extents{};              ///< of the picture
  nn::Buffer<T> input;
  nn::NetworkPass<T> network;
};

/// A salient-object network of the U²-Net family: a picture in, a mask out, and the gradient of the mask with
/// respect to the picture. As published:
///
///   1. the picture is resized to the network's square input, whatever its aspect;
///   2. u2_net_input() scales its values;
///   3. of the network's outputs the first is the mask, d0, in [0, 1] by its logistic function;
///   4. m = (d − min d) / (max d − min d); a constant d makes m = 0;
///   5. m is resized to the picture's extents, bilinearly.
///
/// Source: U-2-Net, u2net_test.py and data_loader.py. There step 1 filters with a Gaussian before pictures
/// are made smaller; here sides at least twice as long as the network's are first halved, by means of 2 × 2
/// pixels. Which object is meant is not decided here: see car_component().
template <std::floating_point T>
class U2Net {
 public:
  /// \param network  as a file tells it, with one input [1, 3, S, S]
  /// \param side     S, pixels; 0: as the network says, or 320 where it leaves it open
  /// \throws FileError (mismatch) as nn::Network, or if inputs or the first output are of other extents
  explicit U2Net(const nn::NetworkDescription& network, std::size_t side = 0)
      : network_(nn::pruned(network, {first_output(network)}), input_shape(network, side), true) {
    const nn::Shape expected{1, 1, this->side(), this->side()};
    if (network_.output_shape(0) != expected)
      throw FileError(
          ErrorKind::mismatch,
          {network.path, "", "the first output " + in_quotes(network.outputs.front()) + " is no mask",
           tapestry::detail::to_text(expected), tapestry::detail::to_text(network_.output_shape(0))});
  }

  /// S, of the network's square input; pixels.
  [[nodiscard]] std::size_t side() const { return network_.input_shape(0)[1]; }

  [[nodiscard]] const nn::Network<T>& network() const { return network_; }

  /// \param picture  [H, W, 3], RGB in [0, 1]
  /// \param pass     takes the mask, [H, W] in [0, 1], and what `mode` says is kept
  /// \throws ShapeError unless the picture has three channels; DomainError if a side is 0 or beyond 65536, or
  ///         a value is not finite; NumericError if the network's mask is not finite
  void forward(const Array<T, 3>& picture, U2NetPass<T>& pass, nn::Mode mode = nn::Mode::inference) const {
    require_shape("U2Net::forward", "picture", picture, {picture.shape(0), picture.shape(1), 3});
    if (!all_finite(picture.data(), picture.size()))
      throw DomainError("U2Net::forward: the picture has values that are not finite");
    pass.extents = picture.shape();
    reduce(picture, pass);
    const Array<T, 3> input = u2_net_input(pass.reduced.back());
    pass.input.resize(input.size());
    std::copy_n(input.data(), input.size(), pass.input.data());
    network_.forward({pass.input.data()}, pass.network, mode);

    const T* const d = pass.network.output(0);
    const std::size_t count = side() * side();
    if (!all_finite(d, count)) throw NumericError("U2Net::forward: the network's mask is not finite");
    const auto [least, most] = std::minmax_element(d, d + count);
    Array<T, 3> stretched(Extents<3>{side(), side(), 1});
    const T range = *most - *least;
    for (std::size_t i = 0; i < count; ++i)
      stretched.data()[i] = range > T(0) ? (d[i] - *least) / range : T(0);
    const auto resized = image::resize_bilinear(stretched, pass.extents[0], pass.extents[1]);
    pass.mask.resize({pass.extents[0], pass.extents[1]});
    std::copy_n(resized.data(), resized.size(), pass.mask.data());
  }

  /// The mask alone, [H, W].
  [[nodiscard]] Array<T, 2> operator()(const Array<T, 3>& picture) const {
    U2NetPass<T> pass;
    forward(picture, pass);
    return std::move(pass.mask);
  }

  /// Adds (∂mask/∂picture)ᵀ · mask_adjoint to picture_adjoint, with all five steps: also through the largest
  /// value of the picture and the least and largest of the mask, of equal ones the first.
  ///
  /// \param pass  of forward() in another mode than inference
  /// \throws ShapeError for adjoints of other extents; DomainError if the pass kept nothing
  void pull_back(U2NetPass<T>& pass, const Array<T, 2>& mask_adjoint, Array<T, 3>& picture_adjoint) const {
    require_shape("U2Net::pull_back", "mask_adjoint", mask_adjoint, {pass.extents[0], pass.extents[1]});
    require_shape("U2Net::pull_back", "picture_adjoint", picture_adjoint, pass.extents);
    if (pass.reduced.empty()) throw DomainError("U2Net::pull_back: the pass holds no results");
    const Array<T, 2> map_adjoint = adjoint_of_map(pass, mask_adjoint);
    nn::Buffer<T> input_adjoint;
    input_adjoint.resize(3 * side() * side());
    input_adjoint.fill_zero();
    network_.adjoint(pass.network, {map_adjoint.data()}, {input_adjoint.data()});

    Array<T, 3> scaled_adjoint(pass.reduced.back().shape());
    std::copy_n(input_adjoint.data(), scaled_adjoint.size(), scaled_adjoint.data());
    auto adjoint = zeros<T, 3>(pass.reduced.back().shape());
    u2_net_input_adjoint(pass.reduced.back(), scaled_adjoint, adjoint);
    for (std::size_t level = pass.reduced.size() - 1; level-- > 0;) {
      auto larger = zeros<T, 3>(pass.reduced[level].shape());
      image::resize_bilinear_adjoint(adjoint, larger);
      adjoint = std::move(larger);
    }
    image::resize_bilinear_adjoint(adjoint, picture_adjoint);
  }

 private:
  static constexpr std::size_t published_side = 320;

  [[nodiscard]] static std::string first_output(const nn::NetworkDescription& network) {
    if (network.outputs.empty())
      throw FileError(ErrorKind::mismatch,
                      {network.path, "", "no network that makes masks", "an output", "none"});
    return network.outputs.front();
  }

  [[nodiscard]] static std::map<std::string, nn::Shape> input_shape(const nn::NetworkDescription& network,
                                                                    std::size_t side) {
    const auto refuse = [&](const std::string& found) {
      throw FileError(ErrorKind::mismatch,
                      {network.path, "", "no network of pictures", "one input [1, 3, S, S]", found});
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

  /// Halves each side while it is at least twice the network's, then goes to the network's.
  void reduce(const Array<T, 3>& picture, U2NetPass<T>& pass) const {
    pass.reduced.clear();
    const auto halved = [this](std::size_t extent) {
      return extent >= 2 * side() ? (extent + 1) / 2 : extent;
    };
    for (const Array<T, 3>* from = &picture;; from = &pass.reduced.back()) {
      const std::size_t rows = halved(from->shape(0)), columns = halved(from->shape(1));
      const bool is_last = rows == from->shape(0) && columns == from->shape(1);
      pass.reduced.push_back(
          image::resize_bilinear(*from, is_last ? side() : rows, is_last ? side() : columns));
      if (is_last) return;
    }
  }

  [[nodiscard]] static bool all_finite(const T* values, std::size_t count) {
    return std::all_of(values, values + count, [](T value) { return is_finite(static_cast<float>(value)); });
  }

  /// Of the network's d, [S, S], by that of the picture's mask.
  [[nodiscard]] Array<T, 2> adjoint_of_map(const U2NetPass<T>& pass, const Array<T, 2>& mask_adjoint) const {
    Array<T, 3> resized_adjoint(Extents<3>{mask_adjoint.shape(0), mask_adjoint.shape(1), 1});
    std::copy_n(mask_adjoint.data(), mask_adjoint.size(), resized_adjoint.data());
    auto stretched_adjoint = zeros<T, 3>({side(), side(), 1});
    image::resize_bilinear_adjoint(resized_adjoint, stretched_adjoint);
    auto map_adjoint = zeros<T, 2>({side(), side()});
    const T* const d = pass.network.output(0);
    const auto [least, most] = std::minmax_element(d, d + map_adjoint.size());
    const double range = static_cast<double>(*most - *least);
    // minmax_element() finds the last of equal largest values; the first takes the adjoint.
    const T* const first_most = std::find(d, d + map_adjoint.size(), *most);
    if (!(range > 0)) return map_adjoint;
    double to_least = 0, to_most = 0;
    for (std::size_t i = 0; i < map_adjoint.size(); ++i) {
      const auto share = static_cast<double>(stretched_adjoint.data()[i]) / range;
      const double stretched = static_cast<double>(d[i] - *least) / range;
      map_adjoint.data()[i] = static_cast<T>(share);
      to_least -= share * (1 - stretched);
      to_most -= share * stretched;
    }
    map_adjoint.data()[least - d] += static_cast<T>(to_least);
    map_adjoint.data()[first_most - d] += static_cast<T>(to_most);
    return map_adjoint;
  }

  nn::Network<T> network_;
};

}  // namespace tapestry::segment
