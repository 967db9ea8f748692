#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <map>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/nn/network/network.hpp>
#include <vector>

namespace tapestry::detect {

/// A detector that is a network of operators, as ONNX files hold them. Its heads are read before the logistic
/// function that exports end with, so that losses get raw logits, but for those of boxes_and_scores, see
/// DecodedOutputs. Pictures of a batch run one after another, each with all threads: a batch costs no more a
/// picture than one. Only where the network takes the statistics of a batch they train together.
template <std::floating_point T>
class GraphDetector final : public Detector<T> {
 public:
  /// \param network  as a file tells it, with one input [1, 3, H, W]
  /// \param kind     how pictures go in and what the outputs mean
  /// \param size     side of the square input, pixels; 0: as the network says
  /// \param layers   names of values within the network that layer_values() and layer_adjoint() tell
  /// \param simplifies  as of nn::Network; without, weights have the names of the file's values
  /// \throws FileError (mismatch) as nn::Network, or if the network's outputs are not of this kind, or a
  /// layer
  ///         is not one of its maps
  GraphDetector(const nn::NetworkDescription& network, DetectorDescription kind, std::size_t size = 0,
                const std::vector<std::string>& layers = {}, bool simplifies = true);

  /// A network of pictures in RGB from 0 to 1, whose first outputs are the raw logits of these heads, in
  /// their order. Without heads its first output, [1, C, H, W], is handed out in the place of logits. \throws
  /// FileError as above; ShapeError unless the outputs have the heads' extents
  GraphDetector(const nn::NetworkDescription& network, std::vector<Head> heads,
                const std::vector<std::string>& layers = {}, bool simplifies = true);
  GraphDetector(GraphDetector&&) noexcept;
  GraphDetector& operator=(GraphDetector&&) noexcept;
  ~GraphDetector() override;

  /// Of the layers that were named, [1, C, H, W].
  [[nodiscard]] const nn::Shape& layer_shape(std::size_t layer) const {
    return network_.output_shape(head_output_count() + layer);
  }

  [[nodiscard]] Array<T, 3> layer_values(const Pass<T>& pass, std::size_t layer,
                                         std::size_t image) const override;

  [[nodiscard]] Array<T, 3> layer_adjoint(Pass<T>& pass,
                                          const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          std::size_t layer, std::size_t image) const override;

  void pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image, const Array<T, 3>& layer_adjoint,
                       Array<T, 4>& images_adjoint) const override;

  [[nodiscard]] std::size_t input_height() const override { return network_.input_shape(0)[1]; }
  [[nodiscard]] std::size_t input_width() const override { return network_.input_shape(0)[2]; }
  [[nodiscard]] std::size_t input_channels() const override { return network_.input_shape(0)[3]; }
  [[nodiscard]] const std::vector<Head>& heads() const override { return heads_.heads; }
  [[nodiscard]] const DetectorDescription& description() const { return kind_; }

  void set_engine(nn::Engine engine) { network_.set_engine(engine); }

  /// The network's constants, and which of them are weights.
  [[nodiscard]] const nn::Network<T>& network() const { return network_; }
  [[nodiscard]] nn::Network<T>& network() { return network_; }

  void forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode = Mode::inference) const override;

  void forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
                      Mode mode = Mode::inference) const override;

  [[nodiscard]] double share_kept(const image::PixelWindow& window) const override;

  /// \param parameters_adjoint  in the order of network().constants(); only its weights are added to
  void pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                 Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint = nullptr) const override;

 private:
  [[nodiscard]] static std::map<std::string, nn::Shape> sizes(const nn::NetworkDescription& network,
                                                              std::size_t size);

  static void require_value(const nn::NetworkDescription& network, const std::string& what,
                            const std::string& name);

  /// The network with other outputs: what the heads are made of, then the layers.
  [[nodiscard]] static nn::NetworkDescription showing_heads(const nn::NetworkDescription& network,
                                                            const DetectorDescription& kind, std::size_t size,
                                                            const std::vector<std::string>& layers);

  [[nodiscard]] std::size_t head_output_count() const { return network_.output_count() - layer_count_; }

  [[nodiscard]] std::vector<nn::Shape> output_shapes() const;

  /// Adjoints of the network's outputs for one pass, and what they point to.
  struct OutputAdjoints {
    std::vector<const T*> of_outputs{};
    std::vector<std::vector<T>> joined{};  ///< of a pass with several images
  };
  [[nodiscard]] OutputAdjoints output_adjoints(const Pass<T>& pass, std::size_t n,
                                               const std::vector<const Array<T, 4>*>& logits_adjoint) const;

  /// Adds the pullback of one pass to the images that it ran.
  /// \param gathered  as outputs_gathered of nn::Network::adjoint()
  void pull_back_one(Pass<T>& pass, std::size_t n, const std::vector<const T*>& of_outputs,
                     Array<T, 4>* images_adjoint, T* constants_adjoint,
                     const std::vector<T*>& gathered = {}) const;

  [[nodiscard]] std::size_t image_size() const { return input_channels() * input_height() * input_width(); }

  /// Images that a pass of the network runs together.
  [[nodiscard]] static std::size_t images_a_pass(const Pass<T>& pass) {
    return pass.images / pass.graph.size();
  }

  /// \throws FileError (mismatch) unless all layers are maps
  void require_layers(const std::string& path, const std::vector<std::string>& layers) const;

  /// \throws DomainError if there is no such layer or image
  void require_layer(const char* operation, const Pass<T>& pass, std::size_t layer, std::size_t image) const;

  /// Extents of a head's logits for one image, or of what stands in their place.
  [[nodiscard]] std::array<std::size_t, 3> logits_extents(std::size_t head) const;
  [[nodiscard]] std::size_t logits_count() const { return heads_.pieces.back().head + 1; }

  /// \param kept  one an image, null where everything is computed
  void run(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
           Mode mode) const;

  /// \throws DomainError for a pass that kept nothing, or only windows
  static void require_whole(const char* operation, const Pass<T>& pass);

  /// Where a piece of image n begins within its head's logits.
  template <class Logits>
  [[nodiscard]] static auto* at(const HeadPiece& piece, Logits& logits, std::size_t n) {
    const std::size_t cells = logits.shape(2) * logits.shape(3);
    return logits.data() + (n * logits.shape(1) + piece.first_channel) * cells;
  }

  DetectorDescription kind_;
  std::size_t layer_count_;
  nn::Network<T> network_;
  ExportedHeads heads_;
  bool trains_together_;
};

extern template class GraphDetector<float>;
extern template class GraphDetector<double>;

}  // namespace tapestry::detect
