#pragma once
#include <tapestry/detect/detector.hpp>

namespace tapestry::detect {
/// The surest candidate of a class.
struct BestCandidate {
  std::size_t head = 0;       ///< index of its head
  std::size_t candidate = 0;  ///< anchor · cells + cell within that
  double confidence = 0;      ///< objectness times the class's probability, or the latter alone
};

/// Class and place of the candidates to search.
struct CandidateSearch {
  std::size_t class_index = 0;
  std::optional<Box> target{};  ///< only candidates whose box has iou_threshold with it, pixels of the input
  double iou_threshold = 0.5;   ///< met exactly counts
};

/// The surest candidate of one image, however unsure and before suppression; the first of equals. Candidates
/// whose box, objectness or probability is NaN or whose confidence is 0 do not count.
///
/// \param heads   of any decode family
/// \param logits  one [N, channels, H, W] a head
/// \param height  and \param width of the network's input, pixels
/// \throws ShapeError if the logits do not fit the heads; DomainError if there is no such image, or as
///         require_class() and require_layout()
template <std::floating_point T>
[[nodiscard]] std::optional<BestCandidate> best_candidate(const std::vector<Head>& heads,
                                                          const std::vector<const Array<T, 4>*>& logits,
                                                          std::size_t image, const CandidateSearch& search,
                                                          std::size_t height, std::size_t width);

/// Grad-CAM: where in a layer a score comes from. The activations A of the layer are weighted by the gradient
/// of the score, G = ∂score/∂A: here each channel by the mean of its gradient.
///
/// \param values   A, [C, H, W]
/// \param adjoint  G, [C, H, W]
/// \returns        [H, W], at least 0
/// Source: Selvaraju et al., "Grad-CAM" (ICCV 2017), eq. 1 and 2.
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] Array<T, 2> grad_cam(const Array<T, 3>& values, const Array<T, 3>& adjoint);

/// Grad-CAM++: each channel by its positive adjoints, weighted so that several instances count as one does.
/// The score is taken as e^s, with the adjoint of s given. Source: Chattopadhay et al., "Grad-CAM++"
/// (WACV 2018), eq. 18 and 19.
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] Array<T, 2> grad_cam_plus_plus(const Array<T, 3>& values, const Array<T, 3>& adjoint);

/// LayerCAM: each place by its own positive adjoint, which keeps the places of shallow layers.
/// Source: Jiang et al., "LayerCAM" (TIP 2021), eq. 6 and 7.
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] Array<T, 2> layer_cam(const Array<T, 3>& values, const Array<T, 3>& adjoint);

/// Share of a heat map that lies in a mask: Σ heat · mask / Σ heat, in [0, 1]; nothing where there is no heat
/// at all. Heat that is the same everywhere has the share of the mask's area.
///
/// \param heat  [H, W], at least 0
/// \param mask  [H, W], in [0, 1]
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] std::optional<double> share_within(const Array<T, 2>& heat, const Array<T, 2>& mask);

/// The adjoint of one candidate's score, the sum of its class logit and its objectness logit: 1 for both, 0
/// elsewhere.
///
/// \param logits  one [N, channels, H, W] a head, for their extents
/// \param best    of best_candidate()
template <std::floating_point T>
[[nodiscard]] std::vector<Array<T, 4>> score_adjoint(const std::vector<Head>& heads,
                                                     const std::vector<Array<T, 4>>& logits,
                                                     std::size_t image, std::size_t class_index,
                                                     const BestCandidate& best);

/// Logits of a batch, and the heat maps that explain them.
template <std::floating_point T>
struct ExplainedLogits {
  std::vector<ArrayVariable<T, 4>> logits;  ///< as forward() gives them
  std::vector<ArrayVariable<T, 2>> heat;    ///< [H, W] of a layer, one an image
};

/// Logits and, for each picture, the layer_cam() of the surest candidate of a class, over the first observed
/// layer of the detector, on the tape. The pullback of a map follows the layer's values. It takes the score's
/// gradient in the layer as constant, as programs with Grad-CAM do. The map is exact, off kinks, if the
/// network above the layer is piecewise linear.
///
/// \param detector  with an observed layer; must outlive the tape's last reverse(), unchanged
/// \param images    [N, H, W, 3], RGB in [0, 1]
/// \param pass      memory to use, as for forward()
/// \throws as forward(); DomainError if the detector has no observed layer, or no such class
template <std::floating_point T>
[[nodiscard]] ExplainedLogits<T> explained_forward(const Detector<T>& detector,
                                                   const ArrayVariable<T, 4>& images, std::size_t class_index,
                                                   std::shared_ptr<Pass<T>> pass = nullptr);
}  // namespace tapestry::detect
