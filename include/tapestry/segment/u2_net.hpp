#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/core/finite.hpp>
#include <tapestry/nn/network/network.hpp>

namespace tapestry::segment {
namespace detail {
/// Index of the largest value, the first of equal ones.
[[nodiscard]] inline std::size_t brightest(const Array<float, 3>& picture) {
  return static_cast<std::size_t>(std::max_element(picture.data(), picture.data() + picture.size()) -
                                  picture.data());
}
}  // namespace detail

/// Input of a network of the U²-Net family: a picture divided by its largest value, then scaled by mean and
/// standard deviation of ImageNet.
///
///   x[i, j, c] = (p[i, j, c] / max p − mean[c]) / deviation[c]
///
/// Source: U-2-Net, data_loader.py, ToTensorLab with flag 0. A black picture is not divided.
///
/// \param picture  p, [S, S, 3], RGB in [0, 1]
/// \returns        [S, S, 3]
/// \throws ShapeError unless there are three channels
[[nodiscard]] Array<float, 3> u2_net_input(const Array<float, 3>& picture);

/// Adds (∂x/∂p)ᵀ · input_adjoint to picture_adjoint, [S, S, 3]. Divides all values by the largest
/// one, of equal ones the first.
void u2_net_input_adjoint(const Array<float, 3>& picture, const Array<float, 3>& input_adjoint,
                          Array<float, 3>& picture_adjoint);

/// The results of one U2Net::forward(), and what pull_back() needs. May be used again; two threads must not
/// share one.
struct U2NetPass {
  Array<float, 2> mask;                  ///< [H, W] of the picture, in [0, 1]
  std::vector<Array<float, 3>> reduced;  ///< the picture ever smaller, the last [S, S, 3]
  Extents<3> extents{};                  ///< of the picture
  nn::Buffer<float> input;
  nn::NetworkPass<float> network;
};

/// A salient-object network of the U²-Net family: a picture in, a mask out, and the gradient of the mask with
/// respect to the picture. As published:
///
///   1. the picture is resized to the network's square input, whatever its aspect;
///   2. u2_net_input() scales its values;
///   3. the network's first output, d0, is the mask d, in [0, 1] by a logistic function;
///   4. m = (d − min d) / (max d − min d); a constant d makes m = 0;
///   5. m is resized to the picture's extents, bilinearly.
///
/// Source: U-2-Net, u2net_test.py and data_loader.py. There step 1 filters with a Gaussian before pictures
/// are made smaller; here sides at least twice as long as the network's are first halved, by means of 2 × 2
/// pixels. car_component() chooses the object.
class U2Net {
 public:
  /// \param network  as read from a file, with one input [1, 3, S, S]
  /// \param side     S, pixels; 0: the network's own, or 320 where it leaves S open
  /// \throws FileError (mismatch) as nn::Network, or if inputs or the first output are of other extents
  explicit U2Net(const nn::NetworkDescription& network, std::size_t side = 0);

  /// S, of the network's square input; pixels.
  [[nodiscard]] std::size_t side() const { return network_.input_shape(0)[1]; }

  [[nodiscard]] const nn::Network<float>& network() const { return network_; }

  /// \param picture  [H, W, 3], RGB in [0, 1]
  /// \param pass     receives the mask, [H, W] in [0, 1], and what `mode` keeps
  /// \throws ShapeError unless the picture has three channels; DomainError if a side is 0 or beyond 65536, or
  ///         a value is not finite; NumericError if the network's mask is not finite
  void forward(const Array<float, 3>& picture, U2NetPass& pass, nn::Mode mode = nn::Mode::inference) const;

  /// The mask alone, [H, W].
  [[nodiscard]] Array<float, 2> operator()(const Array<float, 3>& picture) const;

  /// Adds (∂mask/∂picture)ᵀ · mask_adjoint to picture_adjoint, with all five steps: also through the largest
  /// value of the picture and the least and largest of the mask, of equal ones the first.
  ///
  /// \param pass  of forward() in another mode than inference
  /// \throws ShapeError for adjoints of other extents; DomainError if the pass kept nothing
  void pull_back(U2NetPass& pass, const Array<float, 2>& mask_adjoint,
                 Array<float, 3>& picture_adjoint) const;

 private:
  static constexpr std::size_t published_side = 320;

  [[nodiscard]] static std::string first_output(const nn::NetworkDescription& network);

  [[nodiscard]] static std::map<std::string, nn::Shape> input_shape(const nn::NetworkDescription& network,
                                                                    std::size_t side);

  /// Halves each side while it is at least twice the network's, then resizes to the network's.
  void reduce(const Array<float, 3>& picture, U2NetPass& pass) const;

  [[nodiscard]] static bool all_finite(const float* values, std::size_t count) {
    return std::all_of(values, values + count, [](float value) { return is_finite(value); });
  }

  /// Adjoint of the network's map d, [S, S], given the adjoint of the picture's mask.
  [[nodiscard]] Array<float, 2> adjoint_of_map(const U2NetPass& pass,
                                               const Array<float, 2>& mask_adjoint) const;

  nn::Network<float> network_;
};

/// The mask of a picture on the tape: U2Net::forward(), whose pullback is U2Net::pull_back(). A passive
/// picture records nothing.
///
/// \param network  must outlive the tape's last reverse()
/// \param picture  [H, W, 3], RGB in [0, 1]
/// \returns        [H, W] in [0, 1]
/// \throws ShapeError, DomainError and NumericError as U2Net::forward()
[[nodiscard]] ArrayVariable<float, 2> mask(const U2Net& network, const ArrayVariable<float, 3>& picture);
}  // namespace tapestry::segment
