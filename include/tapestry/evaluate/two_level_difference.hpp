#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/evaluate/paired_bootstrap.hpp>

namespace tapestry::evaluate {
namespace detail {
/// Means of the views' values over draws. \param values  [draw, view]
[[nodiscard]] std::vector<double> means_over_draws(const Array<double, 2>& values);
}  // namespace detail

/// The mean difference over draws and views, with an interval for other draws and other views. A draw is one
/// noise of a control, or one seed of an optimisation; each is measured in the same views.
///
///     [m − c·√(f·a/s·(m − l)² + z²·b), m + c·√(f·a/s·(u − m)² + z²·b)],   c = t(ν) / z,   f = R / (R − 1),
///     s = MS_views / (R·D),   a = (max(0, MS_views − MS_interaction) + MS_interaction / 10) / (R·D),
///     b = MS_draws / (R·D),   w = b / (a + b),   1/ν = w / (D − 1) + (1 − w) / (R − 1)
///
/// for the mean m of D draws in R views. [l, u] is the BCa interval of paired_bootstrap() of the views' means
/// over draws, with its skewness; s is the variance there. a is the variance by views; b is the variance
/// by draws, with the interaction, by the mean squares of two crossed levels (Searle, Casella,
/// McCulloch, "Variance components", Wiley 1992). A tenth of the interaction is left in a, and a + b is at
/// least the variance of the mean of R·D values without levels, since levels only add to it: two seeds that
/// miss one view of 80 each would else know a share better than one. Distances from the mean add in
/// quadrature, each end with its own, as by Zou and Donner ("Construction of confidence limits about
/// effect measures", Statistics in Medicine 27, 2008). z and t(ν) are quantiles of the normal and of
/// Student's distribution; with f they correct a bootstrap of few views (Hesterberg, "What teachers
/// should know about the bootstrap", The American Statistician 69, 2015). If an end of the bootstrap lies on
/// the other side of m, it counts as m.
///
/// ν differs from Satterthwaite's (Biometrics Bulletin 2, 1946), which has w² and (1 − w)²: w is as uncertain
/// as b, and where three draws make most of the variance, that interval holds the truth in 92 % only.
///
/// Coverage of 95 % intervals in 4000 simulations each: 3 draws, 20, 80 and 400 views, confidences whose
/// draws differ by 0 to 10 standard errors of the views: 94 to 97 %. 6 views: 93 to 97 %. Two draws have 87
/// to 97 %. With the whole interaction in a, and only the rest in b, draws that agree had 98 to 99 %.
///
/// \param differences  [draw, view]
/// \param most  largest possible difference, such as 1 for shares: the interval stays within ± most, as
///              the mean does
/// \returns  pairs counts views; with one draw paired_bootstrap()'s result; with
///           fewer than two views an interval from −∞ to ∞
/// \throws ShapeError without a draw; NumericError for a number that is not finite, or whose square is not;
///         DomainError for no resamples or a level not in (0, 1)
[[nodiscard]] PairedDifference two_level_difference(const Array<double, 2>& differences,
                                                    const BootstrapSettings& settings = {},
                                                    double most = std::numeric_limits<double>::infinity());

/// Share of pictures with a found car under a control minus the share under a camouflage, with an interval
/// for the difference of both means over all views and draws. One draw stands for itself: the interval is
/// then for other views of the same paint and noise.
///
/// The logarithm of each share's odds, log p/q with q = 1 − p, has the interval ± h,
///
///     h² = (2·asinh(√v / (2·p·q)))² + t(D − 1)²·c / (p·q)²,
///     v = t(R − 1)²·a + t(D − 1)²·(b − c),   c = max(0, b − i),   i = MS_interaction / (R·D),
///
/// with a, b and t of two_level_difference(), each part of the variance with its own quantile. c is the
/// draws' difference beyond chance. Where c is 0 this is Wilson's interval, which is symmetric in log
/// odds (Newcombe, "Logit confidence intervals and the inverse sinh transformation", The American
/// Statistician 55, 2001). Two draws agree often by chance: a quarter of i is added to a. A share of 0 or
/// 1 has Wilson's interval of its views. The ends of both shares are put together as by Zou and Donner,
/// see two_level_difference(), with their distances from the shares and with the correlation (V₁ + V₂ −
/// V₁₂) / (2·√(V₁·V₂)), V = a + b; V₁₂ is V of the difference. So the sample's own difference lies
/// inside, and the ends within ± 1.
///
/// Coverage of 95 % intervals in 500 simulations of each of 135 populations a layout: shares of .5 to 1,
/// views whose logits have standard deviations of 0.5 to 3, seeds of paint, and of noise, that differ by 0 to
/// 1 logit. With 3 or 5 seeds and 20 to 400 views differences have at least 92 %, odds 91 %, and medians are
/// 95 to 98 %. Those below 93 % have a noise whose seeds differ by a logit; those above 97 % few misses,
/// whose counts are coarse, or seeds that do not differ. Of 6 views, two seeds, or one seed with several
/// draws most have 97 % and more; differences about .5 have 86 % where two seeds of noise differ by a logit.
///
/// \param control, camouflage  share of each view's pictures with a found car, [draw, view]
/// \param of_views  rate_difference() of all pictures: the result if the draws of both agree
/// \throws ShapeError unless both have the same extents
[[nodiscard]] PairedDifference two_level_rate_difference(const Array<double, 2>& control,
                                                         const Array<double, 2>& camouflage,
                                                         const PairedDifference& of_views);

/// Σ first / Σ second over draws and views. Its interval is two_level_difference()'s for the linear terms
/// (first − ratio · second) / mean of second; if draws do not differ it is paired_ratio()'s.
///
/// \param first, second  [draw, view], the sum of the second above 0
/// \throws ShapeError unless both have the same extents; as two_level_difference() and paired_ratio()
[[nodiscard]] PairedRatio two_level_ratio(const Array<double, 2>& first, const Array<double, 2>& second);

/// Odds of finding the car under a control over those under a camouflage, of the sample's own shares,
///
///     OR = (p₁ / q₁) / (p₂ / q₂),   q = 1 − p.
///
/// A share of 0 or 1 counts as half a picture away from it. Unlike a difference of shares it does not shrink
/// because a detector finds nearly all or nearly none. Its logarithm has the interval ± √(h₁² + h₂² −
/// 2·r·h₁·h₂), with h and the correlation r of two_level_rate_difference(). The design effect (V·N / (p·q))
/// of a share whose misses are in k views is uncertain for small k: with M pictures a view it is taken as at
/// least (k·effect + 0.3·M) / (k + 0.3), since M is its maximum. The interval has no upper end, ∞, if fewer
/// than three views miss the car under the control, or find it under the camouflage. It has no lower end, 0,
/// if fewer than three find it under the control, or miss it under the camouflage.
///
/// Source of the intervals: as two_level_rate_difference(). With half a view in place of half a picture, and
/// normal intervals of linear terms, intervals held the truth in 70 to 90 % where shares are near 1.
///
/// \param control, camouflage   share of each view's pictures with a found car, [draw, view]
/// \param pictures_of_control, pictures_of_camouflage  that an entry is the mean over
/// \returns  with fewer than two views an interval from 0 to ∞
/// \throws ShapeError unless both have the same extents, or there are no draws
[[nodiscard]] PairedRatio odds_ratio(const Array<double, 2>& control, const Array<double, 2>& camouflage,
                                     std::size_t pictures_of_control = 1,
                                     std::size_t pictures_of_camouflage = 1);
}  // namespace tapestry::evaluate
