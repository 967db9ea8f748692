#pragma once
#include <array>
#include <string>

namespace tapestry::loss {
/// The loss that is minimised to hide the target from a YOLO detector.
///
/// paper      Wang et al., FCA (AAAI 2022), eq. 2 to 5: per scale the IoU of the predicted box with the
///            target, the objectness probability and the class probability, each summed over the scales.
///            The paper does not state which prediction of a scale is meant. Here it is the one that finds
///            the target best, see responsible(): lowering the best of each scale
///            until none is left hides the target. A scale without a box on the
///            target adds nothing.
/// as_coded   what FCA's published program minimises, with its defects: per scale the mean CIoU over the
///            matched candidates (if any), the objectness entropy with target 1 at the matched candidates,
///            which RAISES objectness there, weighted 4, 1, 0.4 by scale, and the mean raw class logit, cut
///            at 0. Matching is that of box_assignment.hpp; boxes are decoded as the head does it; in the
///            program that is the ultralytics family of detect::DecodeFamily.
/// max_score  −log(1 − max σ(obj) · p(class) · IoU) over all candidates, see max_score().
/// vanish     a soft maximum of max_score over all classes, see vanish(); its value is the term max_score.
/// The others only hide the target's own class: a box with
/// another name satisfies them.
///
/// Heads without objectness (decode families distance and decoded) use the score of the target's class in its
/// place. paper and as_coded use it in their objectness term, too; in the candidate's score, by which paper
/// and max_score choose, it counts once. For exclusive classes (YOLOv2) paper and max_score take the softmax
/// as the probability of a class; as_coded takes the raw logit.
enum class AdversarialLoss { paper, as_coded, max_score, vanish };

/// A kind of loss, and how programs name and explain it.
struct NamedLoss {
  AdversarialLoss kind;
  const char* name;
  const char* sentence;
};
/// All kinds, in the order of AdversarialLoss.
inline constexpr std::array<NamedLoss, 4> adversarial_losses{
    {{AdversarialLoss::paper, "paper", "terms of FCA's paper"},
     {AdversarialLoss::as_coded, "as_coded", "those of its program"},
     {AdversarialLoss::max_score, "max_score", "the surest box over the car"},
     {AdversarialLoss::vanish, "vanish", "no box of any class over the car"}}};

/// \throws DomainError for a name that adversarial_losses lacks
[[nodiscard]] AdversarialLoss adversarial_loss_by_name(const std::string& name);

/// The name that adversarial_loss_by_name() takes.
[[nodiscard]] std::string name_of(AdversarialLoss kind);

/// Weights of the terms; the defaults are the paper's α, β and γ.
struct AdversarialWeights {
  double iou = 0.05;
  double objectness = 1.0;
  double classification = 0.5;
  double max_score = 1.0;
};

/// The terms before weighting, and their weighted sum; terms that the kind of loss does not have are 0.
template <class Term>
struct AdversarialTerms {
  Term iou = 0, objectness = 0, classification = 0, max_score = 0;
  Term total = 0;
};
}  // namespace tapestry::loss
