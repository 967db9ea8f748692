#pragma once
#include <tapestry/detect/kept_picture.hpp>

namespace tapestry::detect {
namespace detail {
/// The logits of a pass, which live as long as any of them is held.
template <std::floating_point T>
[[nodiscard]] std::vector<std::shared_ptr<const Array<T, 4>>> shared_logits(
    const std::shared_ptr<Pass<T>>& pass);

/// The logits of a pass as one record, whose pullback reaches the pictures.
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> record_logits(const Detector<T>& detector,
                                                             const std::shared_ptr<Pass<T>>& pass,
                                                             const ArrayVariable<T, 4>& images);
}  // namespace detail

/// Logits of every head for a batch of pictures, as one record on the active tape: its pullback is
/// Detector::pull_back(), and nothing is recorded or kept for the weights. Passive pictures record nothing.
///
/// \param detector  must outlive the tape's last reverse(), unchanged
/// \param images   [N, H, W, 3], RGB in [0, 1]
/// \param pass     memory for loops that record again and again. Use it for nothing else before the
///                 tape's last reverse(); each call overwrites the logits of the call before. Null takes
///                 new memory.
/// \throws ShapeError as Detector::forward(); DomainError if images are on no active tape
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(const Detector<T>& detector,
                                                       const ArrayVariable<T, 4>& images,
                                                       std::shared_ptr<Pass<T>> pass = nullptr);

/// The same bits for pictures that each change within a window from call to call, computing only what the
/// windows reach: see Detector::forward_within(). The pictures' adjoint equals forward()'s within the
/// windows, and may be zero elsewhere. Constant pictures run in the same mode as others, since kept
/// layers belong to one mode.
///
/// \param kept  for each image, or null to compute everything of it; needed during the call only
/// \throws ShapeError as Detector::forward_within(); DomainError as forward()
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward_within(const Detector<T>& detector,
                                                              const ArrayVariable<T, 4>& images,
                                                              const std::vector<KeptPicture<T>*>& kept,
                                                              std::shared_ptr<Pass<T>> pass = nullptr);

/// The same in training mode, differentiable by the pictures and by the weights. Batch normalisation in the
/// network keeps its running statistics.
///
/// The detector takes over the weights' values, which must stay unchanged until the tape's last reverse().
///
/// \param images     [N, H, W, 3], RGB in [0, 1]
/// \param weights    in the order of detector.weights()
/// \param pass       as above
/// \throws ShapeError as Detector::forward(), or for another number of weights; the detector's
///         weights then stay
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(Detector<T>& detector,
                                                       const ArrayVariable<T, 4>& images,
                                                       const ArrayVariable<T, 1>& weights,
                                                       std::shared_ptr<Pass<T>> pass = nullptr);

/// Logits of every head of Detector::tangents(), and as many tangents, as one record, for pictures that are
/// encoded for the network.
///
/// \param inputs, tangents  [N, H, W, C], see encoded()
/// \throws ShapeError if extents differ; DomainError as Detector::tangents()
template <std::floating_point T>
[[nodiscard]] std::pair<std::vector<ArrayVariable<T, 4>>, std::vector<ArrayVariable<T, 4>>> forward_tangents(
    const Detector<T>& detector, const ArrayVariable<T, 4>& inputs, const ArrayVariable<T, 4>& tangents);

/// forward() on a tape of duals, for second order: by forward_tangents().
template <DualNumber D>
[[nodiscard]] std::vector<ArrayVariable<D, 4>> forward(const Detector<typename D::value_type>& detector,
                                                       const ArrayVariable<D, 4>& images) {
  const InputEncoding& encoding = detector.description().encoding;
  const auto encode = [&](const auto& at) { return encoded(at, encoding); };
  return record_tangent(
      [&](const auto& x, const auto& along) { return forward_tangents(detector, x, along); },
      encoding == InputEncoding{} ? images : record_affine(encode, images));
}
}  // namespace tapestry::detect
