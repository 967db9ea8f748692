#pragma once
#include <tapestry/detect/box_decode.hpp>  // Detection
#include <tapestry/loss/prediction.hpp>    // Target

namespace tapestry::evaluate {
/// Best confidence of a detector in a target: the largest confidence among all candidates whose box has an
/// IoU with the target's of at least `iou_threshold`; 0 if there is none. The confidence is objectness times
/// the probability of the target's class, or that probability alone for heads without objectness. Candidates
/// count however low it is, and before suppression: a candidate that makes is_found() true counts, but one
/// that counts may be suppressed by a surer box elsewhere.
///
/// \param predictions    of the picture, by heads of any decode family
/// \param target         the box in pixels of the network's input
/// \param iou_threshold  0.5 as for P@0.5; met exactly counts
/// \returns  in [0, 1]; candidates whose box, objectness or probability is NaN do not count
/// \throws ShapeError if the logits do not fit the heads; DomainError if there is no such image or class, or
///         as detect::require_layout()
[[nodiscard]] double best_confidence(const loss::Predictions<float>& predictions, const loss::Target& target,
                                     double iou_threshold = 0.5);

/// Whether a detector found a target: some detection has the target's class and an IoU with its box of at
/// least `iou_threshold`.
///
/// \param detections     after suppression, so above the confidence threshold (0.25 and a suppression IoU of
///                       0.45 in the reports)
/// \param iou_threshold  0.5 for P@0.5; met exactly counts as found
[[nodiscard]] bool is_found(const std::vector<detect::Detection>& detections, const loss::Target& target,
                            double iou_threshold = 0.5);

/// The 95 % interval of a share, from `hits` of `trials`; {0, 1} for no trials.
///
/// Source: Wilson, "Probable inference" (1927), with z = 1.959964. Unlike the normal approximation it never
/// leaves [0, 1] and is right for 0 of n and n of n, too.
///
/// \param pictures_a_trial  pictures of one trial, which counts once: hits and trials then count pictures,
///                          and their share stands for the share of trials
[[nodiscard]] std::array<double, 2> wilson_interval(std::size_t hits, std::size_t trials,
                                                    std::size_t pictures_a_trial = 1);

/// Order of the pictures of one texture: by seed, then by view, then by photograph, then by draw. A seed is
/// one optimisation, a draw is one noise.
struct PictureOrder {
  std::size_t photographs = 1;  ///< of one view
  std::size_t draws = 1;
  std::size_t seeds = 1;

  [[nodiscard]] std::size_t pictures_a_view() const { return photographs * draws * seeds; }
};

/// P@0.5: share of the pictures with a found target.
struct DetectionRate {
  std::size_t views = 0;                     ///< pictures
  std::size_t detected = 0;                  ///< pictures
  double p_at_50 = 0;                        ///< detected / views, 0 without views; a share, not per cent
  std::array<double, 2> interval{0.0, 1.0};  ///< 95 %; all of [0, 1] without views
};

/// Where seeds differ, or the draws of one seed, the interval is for other views and other seeds or
/// draws: Wilson's of p·(1 − p) / V views with t(ν) for z. p is the share; V and ν are the variance of a
/// mean over both levels and its degrees of freedom, as in two_level_difference(). Else it is
/// wilson_interval() of the views.
///
/// Sources: Korn and Graubard, "Confidence intervals for proportions with small expected number of positive
/// counts estimated from survey data" (Survey Methodology 24, 1998); Dean and Pagano, "Evaluating confidence
/// interval methods for binomial proportions in clustered surveys" (Journal of Survey Statistics and
/// Methodology 3, 2015). In 4000 simulations each of 6, 20 and 80 views, whose logits have a mean of 0, 2 or
/// 4 and a standard deviation of 1, with seeds that differ by 0, ½ or 1 logit, it holds the true share of two
/// seeds in 91 to 99.8 %, of three in 93 to 99.7 %, of five in 93 to 99.4 %; and in those of
/// two_level_rate_difference() a share of .998 of one picture of each of 80 views in 86 %. wilson_interval()
/// of the views holds three seeds' share in 38 to 100 %.
///
/// \param found  one entry a picture
/// \throws ShapeError where seeds or draws are several and the pictures are not as many of each view
[[nodiscard]] DetectionRate detection_rate(const std::vector<bool>& found, const PictureOrder& order = {});

/// P@0.5 at each threshold of confidence.
/// \param found_confidence  of each picture, see ViewResult
/// \throws ShapeError as detection_rate()
[[nodiscard]] std::vector<DetectionRate> rates_above(const std::vector<double>& thresholds,
                                                     const std::vector<double>& found_confidence,
                                                     const PictureOrder& order);

/// ASR: of the pictures with a found clean target, the share where the painted one was missed.
struct AttackSuccess {
  std::size_t views = 0;                     ///< pictures found in clean; 0: there is no rate to report
  std::size_t hidden = 0;                    ///< number of these not found with the adversarial paint
  double rate = 0;                           ///< hidden / views, 0 without views; a share, not per cent
  std::array<double, 2> interval{0.0, 1.0};  ///< 95 %; all of [0, 1] without views
};

/// The interval is detection_rate()'s, of the views that were found in clean at all. The share is a ratio of
/// two sums: its variance is the variance of hidden − rate · found, over the mean of found.
///
/// \param clean_found        one entry a picture, the car in its own colours
/// \param adversarial_found  the same pictures with the adversarial paint
/// \throws ShapeError if the two do not have as many pictures; as detection_rate()
[[nodiscard]] AttackSuccess attack_success_rate(const std::vector<bool>& clean_found,
                                                const std::vector<bool>& adversarial_found,
                                                const PictureOrder& order = {});
}  // namespace tapestry::evaluate
