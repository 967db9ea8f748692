#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/detect/pass.hpp>
#include <tapestry/detect/suppression_measure.hpp>
#include <tapestry/image/pixel_window.hpp>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
class KeptPicture;

/// What finds objects in pictures: a network whose results are the raw logits of heads, forward and backward,
/// whatever kind of file it came from. Results are the same bits for any number of threads.
template <std::floating_point T>
class Detector {
 public:
  virtual ~Detector() = default;

  /// Of the pictures that it takes, in pixels.
  [[nodiscard]] virtual std::size_t input_height() const = 0;
  [[nodiscard]] virtual std::size_t input_width() const = 0;
  [[nodiscard]] virtual std::size_t input_channels() const { return 3; }
  /// In the order of the logits that forward() gives.
  [[nodiscard]] virtual const std::vector<Head>& heads() const = 0;
  /// By which its detections are meant to suppress each other.
  [[nodiscard]] virtual SuppressionMeasure suppression_measure() const { return {}; }

  /// Logits of every head for a batch of pictures.
  ///
  /// \param images  [N, H, W, 3], RGB in [0, 1], N at least 1: pictures as everywhere else, one behind the
  ///                other. What else a network wants of its input, it makes of them itself.
  /// \param pass    takes the logits, and what `mode` says is kept
  /// \throws ShapeError unless images have the network's extents
  virtual void forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode = Mode::inference) const = 0;

  /// forward() of pictures that change from call to call within a window each, with the same bits. Where a
  /// network's layers are not reached by the window they may be taken from `kept` instead of being computed,
  /// and pull_back() may add to the windows only. The first call with a kept picture computes everything, and
  /// so does every call before which the rest of the picture, the weights or the mode have changed.
  ///
  /// \param kept  for each image, or null for one of which everything is computed; a detector that keeps
  ///              nothing leaves them as they are
  /// \throws ShapeError as forward(), unless there are as many of them as images, and for windows that leave
  ///         the picture
  virtual void forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept,
                              Pass<T>& pass, Mode mode = Mode::inference) const {
    static_cast<void>(kept);
    forward(images, pass, mode);
  }

  /// Share of a whole pass's multiply-adds, from 0 to 1, that forward_within() leaves out for a picture that
  /// changes within a window; 0 where nothing is kept. A small share is not worth the memory of what is kept.
  /// \throws ShapeError if the window leaves the picture
  [[nodiscard]] virtual double share_kept(const image::PixelWindow& window) const {
    static_cast<void>(window);
    return 0;
  }

  /// Adds (∂logits/∂images)ᵀ · logits_adjoint to images_adjoint, and the like for the parameters, each unless
  /// null; null for a head stands for zeros.
  /// \param pass  of forward() or forward_within() in another mode than inference, for parameters in
  ///              Mode::training; may be used again
  /// \throws DomainError for a pass that kept nothing, ShapeError for extents that do not fit it
  virtual void pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                         Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint = nullptr) const = 0;

  /// What one of the layers that the detector tells holds for one image of a pass, [C, H, W].
  ///
  /// \param pass   of forward() in another mode than inference
  /// \param layer  its place among those named for this, see Network::tell_layers() and GraphDetector
  /// \throws DomainError or std::out_of_range if there is no such layer or image
  [[nodiscard]] virtual Array<T, 3> layer_values(const Pass<T>& pass, std::size_t layer,
                                                 std::size_t image) const = 0;

  /// What logits_adjoint asks of such a layer for one image, [C, H, W]; parameters and errors as for
  /// pull_back() and layer_values().
  [[nodiscard]] virtual Array<T, 3> layer_adjoint(Pass<T>& pass,
                                                  const std::vector<const Array<T, 4>*>& logits_adjoint,
                                                  std::size_t layer, std::size_t image) const = 0;

  /// Adds (∂layer/∂images)ᵀ · layer_adjoint, of what such a layer holds for one image, to images_adjoint.
  ///
  /// \param layer_adjoint   [C, H, W], as layer_values()
  /// \param images_adjoint  [N, H, W, 3], of all images of the pass
  /// \throws ShapeError for extents that do not fit; otherwise as layer_adjoint()
  virtual void pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image,
                               const Array<T, 3>& layer_adjoint, Array<T, 4>& images_adjoint) const = 0;

  /// pull_back() to the images alone.
  void input_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                     Array<T, 4>& images_adjoint) const {
    std::vector<const Array<T, 4>*> pointers;
    for (const auto& array : logits_adjoint) pointers.push_back(&array);
    pull_back(pass, pointers, &images_adjoint);
  }

  /// \throws ShapeError unless images are [N, H, W, 3] of the network's extents, N at least 1
  void require_images(const Array<T, 4>& images) const {
    if (images.shape(0) == 0) throw ShapeError("Detector::forward: a batch of no images");
    require_shape("Detector::forward", "images", images,
                  {images.shape(0), input_height(), input_width(), input_channels()});
  }

 protected:
  Detector() = default;
  Detector(const Detector&) = default;
  Detector(Detector&&) = default;
  Detector& operator=(const Detector&) = default;
  Detector& operator=(Detector&&) = default;

  /// \throws DomainError if the pass kept nothing; ShapeError if the adjoints are not those of its logits
  static void require_logits_adjoint(const char* operation, const Pass<T>& pass, bool kept_something,
                                     const std::vector<const Array<T, 4>*>& logits_adjoint) {
    if (pass.mode == Mode::inference || !kept_something)
      throw DomainError(std::string(operation) +
                        ": the pass kept nothing; run forward() for a gradient first");
    if (logits_adjoint.size() != pass.logits.size())
      throw ShapeError(std::string(operation) + ": logits_adjoint has " +
                       std::to_string(logits_adjoint.size()) + " arrays, expected " +
                       std::to_string(pass.logits.size()));
    for (std::size_t h = 0; h < logits_adjoint.size(); ++h)
      if (logits_adjoint[h] != nullptr)
        require_shape(operation, "logits_adjoint", *logits_adjoint[h], pass.logits[h].shape());
  }
};

}  // namespace tapestry::detect
