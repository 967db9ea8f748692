#pragma once
#include <concepts>
#include <cstddef>
#include <optional>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/best_candidate.hpp>
#include <tapestry/detect/head.hpp>
#include <vector>

namespace tapestry::detect {

/// Grad-CAM: where in a layer a score comes from. What the layer holds, A, is weighted by what the score asks
/// of it, G = ∂score/∂A: here each channel by the mean of its adjoint.
///
/// \param values   A, [C, H, W]
/// \param adjoint  G, [C, H, W]
/// \returns        [H, W], at least 0
/// Source: Selvaraju et al., "Grad-CAM" (ICCV 2017), eq. 1 and 2.
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] Array<T, 2> grad_cam(const Array<T, 3>& values, const Array<T, 3>& adjoint);

/// Grad-CAM++: each channel by its positive adjoints, weighted so that several instances count as one does.
/// The score is taken as e^s of the s whose adjoint is given.
/// Source: Chattopadhay et al., "Grad-CAM++" (WACV 2018), eq. 18 and 19.
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] Array<T, 2> grad_cam_plus_plus(const Array<T, 3>& values, const Array<T, 3>& adjoint);

/// LayerCAM: each place by its own positive adjoint, which keeps the places of shallow layers.
/// Source: Jiang et al., "LayerCAM" (TIP 2021), eq. 6 and 7.
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] Array<T, 2> layer_cam(const Array<T, 3>& values, const Array<T, 3>& adjoint);

/// How much of a heat map lies where a mask is: Σ heat · mask / Σ heat, in [0, 1]; nothing where there is no
/// heat at all. Heat that is the same everywhere has the share of the mask's area.
///
/// \param heat  [H, W], at least 0
/// \param mask  [H, W], in [0, 1]
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] std::optional<double> share_within(const Array<T, 2>& heat, const Array<T, 2>& mask);

/// The adjoint of one candidate's score: 1 for the logit of the class and for that of objectness, of which
/// the score is the sum; zeros elsewhere.
///
/// \param logits  one [N, channels, H, W] a head, for their extents
/// \param best    of best_candidate()
template <std::floating_point T>
[[nodiscard]] std::vector<Array<T, 4>> score_adjoint(const std::vector<Head>& heads,
                                                     const std::vector<Array<T, 4>>& logits,
                                                     std::size_t image, std::size_t class_index,
                                                     const BestCandidate& best);

}  // namespace tapestry::detect
