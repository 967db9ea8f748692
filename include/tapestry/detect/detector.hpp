#pragma once
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/detect/pass.hpp>
#include <tapestry/detect/suppression.hpp>

/// \file
/// The first header of detect/: from a picture to boxes, and from logits back to the picture.
///
///   picture --> encoded --> nn::Network --> logits of heads --> boxes, scores --> detections
///    RGB     InputEncoding                     Head            box_decode      suppression
///
/// A head has a grid of cells. Each candidate of a cell has a box, class scores and, in most families, an
/// objectness, see DecodeFamily. Losses take the raw logits; everything up to these has derivatives.
///
/// Read next: head.hpp, detector_description.hpp, box_decode.hpp, suppression.hpp.

namespace tapestry::detect {
template <std::floating_point T>
class KeptPicture;

/// Finds objects in pictures: a network whose results are the raw logits of heads, forward and backward, with
/// the encoding of its input and the names of its classes, whatever file they came from; see
/// io::read_detector(). Results are the same bits for any number of threads. Several threads may call const
/// members of one detector at once, each with a Pass of its own.
///
/// The heads of an export are read before the logistic function that it ends with, so that losses get raw
/// logits; boxes_and_scores and end_to_end are the exceptions, see DecodedOutputs. The first call of
/// forward() checks the values that a description states, probabilities and numbers of classes. Pictures of a
/// batch run one after another on all threads, those of a small network side by side: a batch costs no more a
/// picture than one. Only a network with batch statistics runs the batch together.
///
/// A network whose extents depend on the picture, as of proposals or behind a suppression, runs as an
/// nn::StagedNetwork, with gradients to the picture; it does not train, and forward_within() computes all.
template <std::floating_point T>
class Detector {
 public:
  /// \param network  of one input [1, 3, H, W] or [3, H, W]
  /// \param kind     encoding of pictures and meaning of the outputs
  /// \param size     side of the square input, pixels; 0: the network's own
  /// \param layers   names of values within the network, for layer_values() and layer_adjoint()
  /// \param simplifies  as in nn::Network; without, weights have the names of the file's values
  /// \throws FileError (mismatch) as nn::Network, or if the network's outputs are not of this kind, or a
  ///         layer is not one of its maps
  Detector(const nn::NetworkDescription& network, DetectorDescription kind, std::size_t size = 0,
           const std::vector<std::string>& layers = {}, bool simplifies = true);

  /// A network of pictures in RGB from 0 to 1, whose first outputs are the raw logits of these heads, in
  /// their order. Without heads its first output, [1, C, H, W], takes the place of logits.
  /// \throws FileError as above; ShapeError unless the outputs have the heads' extents
  Detector(nn::NetworkDescription network, std::vector<Head> heads,
           const std::vector<std::string>& layers = {}, bool simplifies = true);

  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;
  ~Detector();

  /// Extents of the pictures in its input, pixels.
  [[nodiscard]] std::size_t input_height() const { return height_; }
  [[nodiscard]] std::size_t input_width() const { return width_; }
  [[nodiscard]] std::size_t input_channels() const { return network_.input_shape(0)[3]; }
  /// The heads, in the order of the logits of forward().
  [[nodiscard]] const std::vector<Head>& heads() const { return heads_.heads; }
  [[nodiscard]] const DetectorDescription& description() const { return kind_; }

  /// Placement of a photograph on the input.
  [[nodiscard]] const image::Fit& fit() const { return kind_.fit; }
  void set_fit(const image::Fit& fit) { kind_.fit = fit; }
  /// Overlap measure for non-maximum suppression.
  [[nodiscard]] const SuppressionMeasure& suppression_measure() const { return measure_; }
  void set_suppression_measure(const SuppressionMeasure& measure) { measure_ = measure; }
  /// Names of the classes, in their order; empty where they are known by number only.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  void set_names(std::vector<std::string> names) { names_ = std::move(names); }
  /// The class of a name or, if no class has it, of a number.
  /// \throws Error (mismatch) listing the known names, or if the number is too large; (usage) for a name
  ///         where there are none
  [[nodiscard]] std::size_t class_index(std::string_view name) const;

  void set_engine(nn::Engine engine) {
    network_.set_engine(engine);
    tangents_->network.reset();
    if (stages_) stages_->set_engine(engine);
  }

  [[nodiscard]] const nn::Network<T>& network() const { return network_; }
  /// network() with its derivative along a direction, for second order: see nn::Network::with_tangents(). It
  /// is made at the first call, and anew after set_weights() and set_engine().
  /// \throws DomainError as there, and if extents depend on the picture
  [[nodiscard]] const nn::Network<T>& tangents() const;
  /// Where outputs of network() lie in the logits.
  [[nodiscard]] const std::vector<HeadPiece>& head_pieces() const { return heads_.pieces; }

  /// Values of the constants that training changes, one behind the other; see nn::Network::weight_blocks().
  [[nodiscard]] Array<T, 1> weights() const;
  /// Earlier passes keep their results; for an adjoint call forward() again.
  /// \throws ShapeError unless there are as many as weights()
  void set_weights(const Array<T, 1>& weights);

  /// A photograph, [h, w, 3] of any extents, RGB in [0, 1], as a batch of one picture that forward() takes.
  /// \throws DomainError if an extent is 0
  [[nodiscard]] Array<T, 4> input(const Array<T, 3>& photograph) const;

  /// Logits of every head for a batch of pictures.
  ///
  /// \param images  [N, H, W, 3], RGB in [0, 1], N at least 1: pictures as everywhere else, one behind the
  ///                other. The detector itself applies the input encoding of the network.
  /// \param pass    receives the logits, and what `mode` keeps
  /// \throws ShapeError unless images have the network's extents; FileError (mismatch) naming an output whose
  ///         values contradict the description, at the first call
  void forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode = Mode::inference) const;

  /// forward() of pictures that change from call to call within a window each, with the same bits. Layers
  /// that the window does not reach are taken from `kept` instead of being computed, and pull_back() may add
  /// to the windows only. The first call with a kept picture computes everything, and so does every call
  /// after a change of the rest of the picture, the weights or the mode.
  ///
  /// \param kept  one for each image; null: everything of the image is computed
  /// \throws ShapeError as forward(), unless there are as many of them as images, and for windows that leave
  ///         the picture
  void forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
                      Mode mode = Mode::inference) const;

  /// Share of a whole pass's multiply-adds, from 0 to 1, that forward_within() leaves out for a picture that
  /// changes within a window; 0 where nothing is kept. A small share is not worth its memory.
  /// \throws ShapeError if the window leaves the picture
  [[nodiscard]] double share_kept(const image::PixelWindow& window) const;

  /// Objects found in one image of the batch: decode(), then suppress() within each class, most confident
  /// first.
  ///
  /// \param logits      of forward()
  /// \param confidence  above which a box counts
  /// \param overlap     above which the surer of two boxes of a class suppresses the other
  /// \returns boxes in pixels of the input; see in_photograph()
  /// \throws as decode() and suppress()
  [[nodiscard]] std::vector<Detection> detections(const std::vector<Array<T, 4>>& logits,
                                                  std::size_t image = 0, double confidence = 0.25,
                                                  double overlap = 0.45) const;

  /// The same boxes in pixels of the photograph that input() put in.
  [[nodiscard]] std::vector<Detection> in_photograph(std::vector<Detection> detections, std::size_t height,
                                                     std::size_t width) const;

  /// Adds (∂logits/∂images)ᵀ · logits_adjoint to images_adjoint, and the same for the weights, each unless
  /// null. A null head stands for zeros.
  /// \param pass  of forward() or forward_within() in another mode than inference, for weights in
  ///              Mode::training; may be used again
  /// \param weights_adjoint  in the order of weights()
  /// \throws DomainError for a pass that kept nothing, ShapeError for extents that do not fit it
  void pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                 Array<T, 4>* images_adjoint, Array<T, 1>* weights_adjoint = nullptr) const;

  /// pull_back() to the images alone.
  void input_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                     Array<T, 4>& images_adjoint) const;

  /// Extents of an observed layer, [1, C, H, W].
  [[nodiscard]] const nn::Shape& layer_shape(std::size_t layer) const {
    return shapes_.at(head_output_count() + layer);
  }

  /// Activations of an observed layer for one image, [C, H, W].
  ///
  /// \param pass   of forward() in another mode than inference
  /// \param layer  its index among the named layers
  /// \throws DomainError if there is no such layer or image, or the pass kept nothing or only windows
  [[nodiscard]] Array<T, 3> layer_values(const Pass<T>& pass, std::size_t layer, std::size_t image) const;

  /// Gradient of the loss with respect to such a layer for one image, [C, H, W]; parameters and errors as for
  /// pull_back() and layer_values().
  [[nodiscard]] Array<T, 3> layer_adjoint(Pass<T>& pass,
                                          const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          std::size_t layer, std::size_t image) const;

  /// Adds (∂layer/∂images)ᵀ · layer_adjoint, for such a layer of one image, to images_adjoint.
  ///
  /// \param layer_adjoint   [C, H, W], as layer_values()
  /// \param images_adjoint  [N, H, W, 3], of all images of the pass
  /// \throws ShapeError for extents that do not fit; otherwise as layer_adjoint()
  void pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image, const Array<T, 3>& layer_adjoint,
                       Array<T, 4>& images_adjoint) const;

  /// \throws ShapeError unless images are [N, H, W, 3] of the network's extents, N at least 1
  void require_images(const Array<T, 4>& images) const;

 private:
  /// A network of an input [1, 3, H, W].
  struct OfBatch {
    const nn::NetworkDescription& network;
  };
  Detector(OfBatch of, DetectorDescription kind, std::size_t size, const std::vector<std::string>& layers,
           bool simplifies);

  [[nodiscard]] std::size_t head_output_count() const {
    return shapes_.size() - layer_count_ - (claim_ ? 1 : 0);
  }
  [[nodiscard]] std::vector<nn::Shape> head_shapes() const {
    return {shapes_.begin(), shapes_.begin() + static_cast<std::ptrdiff_t>(head_output_count())};
  }

  /// Adjoints of the network's outputs for one pass, and the arrays they point to.
  struct OutputAdjoints {
    std::vector<const T*> of_outputs{};
    std::vector<std::vector<T>> joined{};  ///< of a pass with several images
  };
  [[nodiscard]] OutputAdjoints output_adjoints(const Pass<T>& pass, std::size_t n,
                                               const std::vector<const Array<T, 4>*>& logits_adjoint) const;

  /// Adds the pullback of one pass to the images that it ran.
  /// \param gathered  as outputs_gathered of nn::Network::adjoint()
  void pull_back_one(Pass<T>& pass, std::size_t n, const std::vector<const T*>& of_outputs,
                     Array<T, 4>* images_adjoint, T* weights_adjoint,
                     const std::vector<T*>& gathered = {}) const;

  [[nodiscard]] std::size_t image_size() const { return input_channels() * height_ * width_; }

  /// Images that a pass of the network runs together.
  [[nodiscard]] static std::size_t images_a_pass(const Pass<T>& pass) {
    return pass.images / pass.graph.size();
  }

  /// \throws FileError (mismatch) unless all layers are maps
  void require_layers(const std::string& path, const std::vector<std::string>& layers) const;

  /// \throws DomainError if there is no such layer or image
  void require_layer(const char* operation, const Pass<T>& pass, std::size_t layer, std::size_t image) const;

  /// Extents of a head's logits for one image, or of the output in their place.
  [[nodiscard]] std::array<std::size_t, 3> logits_extents(std::size_t head) const;
  [[nodiscard]] std::size_t logits_count() const { return heads_.pieces.back().head + 1; }

  /// \param kept  one an image, null where everything is computed
  void run(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
           Mode mode) const;

  void resize_logits(Pass<T>& pass) const;

  /// run() of a network in stages, image after image.
  void run_stages(const Array<T, 4>& images, Pass<T>& pass) const;

  /// The same as pull_back_one() for a staged network.
  void pull_back_stages(Pass<T>& pass, std::size_t n, const std::vector<const T*>& of_outputs,
                        Array<T, 4>* images_adjoint, const std::vector<T*>& gathered) const;

  /// Values of an output for the images of one pass.
  /// \throws ShapeError if its extents depend on the picture and differ from the first one's
  [[nodiscard]] const T* output_values(const Pass<T>& pass, std::size_t n, std::size_t output) const;

  /// \throws DomainError for a pass that kept nothing, or only windows
  static void require_whole(const char* operation, const Pass<T>& pass);

  /// \throws DomainError if the pass kept nothing; ShapeError if the adjoints do not fit its logits
  static void require_logits_adjoint(const char* operation, const Pass<T>& pass,
                                     const std::vector<const Array<T, 4>*>& logits_adjoint);

  /// Start of a piece of image n in its head's logits.
  template <class Logits>
  [[nodiscard]] static auto* at(const HeadPiece& piece, Logits& logits, std::size_t n) {
    const std::size_t cells = logits.shape(2) * logits.shape(3);
    return logits.data() + (n * logits.shape(1) + piece.first_channel) * cells;
  }

  DetectorDescription kind_;
  std::size_t layer_count_ = 0;
  std::unique_ptr<detail::OutputClaim> claim_;  ///< null if nothing is stated; else the output is the last
  std::unique_ptr<nn::StagedNetwork<T>> stages_{};  ///< if extents depend on the picture; then network_ only
  nn::Network<T> network_;                          ///< has its input
  /// network_.with_tangents(), once it is wanted.
  struct Tangents {
    std::mutex mutex{};
    std::unique_ptr<nn::Network<T>> network{};
  };
  std::unique_ptr<Tangents> tangents_ = std::make_unique<Tangents>();
  std::vector<nn::Shape> shapes_;  ///< of the outputs
  std::size_t height_ = 0, width_ = 0;
  ExportedHeads heads_;
  bool trains_together_ = false;
  SuppressionMeasure measure_{};
  std::vector<std::string> names_{};
};

/// Logits of every head for a batch of pictures, [N, H, W, 3], RGB in [0, 1]; errors as Detector::forward().
template <std::floating_point T>
[[nodiscard]] std::vector<Array<T, 4>> forward(const Detector<T>& detector, const Array<T, 4>& images) {
  Pass<T> pass;
  detector.forward(images, pass);
  return std::move(pass.logits);
}

extern template class Detector<float>;
extern template class Detector<double>;
}  // namespace tapestry::detect
