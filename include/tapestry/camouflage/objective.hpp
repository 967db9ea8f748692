#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/camouflage/kept_layers.hpp>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/objective_terms.hpp>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/camouflage/profile.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/detect/heat_map_variable.hpp>
#include <tapestry/detect/pass_pool.hpp>
#include <tapestry/image/colour_space_variable.hpp>
#include <tapestry/image/over_variable.hpp>
#include <tapestry/loss/adversarial_variable.hpp>
#include <tapestry/loss/attention_variable.hpp>
#include <tapestry/raster/texture_operator_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

/// The whole pipeline as one function on the tape:
///
///   parameter → colours → render → over the frames → detector → adversarial loss + μ · smoothness
///
/// and, where print_by() says what a printer can make, + its weight · non-printability score.
///
/// A photo session prints the colours before and photographs the pictures after they are laid over the
/// frames. Views in image::ColourSpace::linear are rendered and laid over in light; colours, pictures and the
/// steps that smoothness sums stay encoded.
///
/// Source: FCA (AAAI 2022), eq. 2-7 and Algorithm 1, but that smoothness is summed over steps of the paint
/// within the car (eq. 5: over the composited picture). The network's weights, the frames and the cameras are
/// passive and record nothing. May be called again before the tape is reversed.
template <class T>
class Objective {
 public:
  using Views = std::span<const std::shared_ptr<const View<T>>>;

  /// \param detector     must outlive the objective
  /// \param used_texels  if given, smoothness counts steps over the atlas instead of the pictures, between
  ///                     texels where this, [height, width] of the atlas, is 1
  /// \throws DomainError if the detector has no class of that index, or gives no raw logits
  Objective(const detect::Detector<T>& detector, ObjectiveOptions options,
            std::shared_ptr<const Array<T, 2>> used_texels = nullptr)
      : options_(options), used_texels_(std::move(used_texels)) {
    join(detector, options.class_index);
  }

  /// Lets another detector, in which the car has this class, count as much as those before: an ensemble,
  /// whose adversarial terms are means. It must outlive the objective.
  ///
  /// \throws DomainError as the constructor; ShapeError if it takes pictures of other extents than the first
  void join(const detect::Detector<T>& detector, std::size_t class_index);

  /// Paints by another method than FCA's, of whose rows the parameter then consists. If it is about
  /// attention, each detector must tell a layer; terms() are still those of the adversarial loss, but for
  /// `total`. If it moves the shape, views must keep what they are drawn by, see sight_of(), and the weighted
  /// shape_roughness() counts in `total`.
  void follow(Method<T> method) { method_ = std::move(method); }
  [[nodiscard]] const Method<T>& method() const { return method_; }

  /// Lets the paint's non-printability score count, by its weight in the options.
  ///
  /// \param palette  printable colours, [colour, 3]
  /// \param used     [height, width], whose product is the texels of the paint: 1 for those that are printed
  /// \throws as loss::non_printability(), from the next call on
  void print_by(std::shared_ptr<const Array<double, 2>> palette, std::shared_ptr<const Array<T, 2>> used);

  /// Keeps those parts of the detectors' layers that the car cannot reach from step to step, of views where
  /// that saves at least a share of the products, up to so many bytes for all views and detectors together;
  /// 0, as without a call, keeps nothing. Results are the same bits. Steps with a photo session, or of a
  /// shape that moves, change more and compute everything.
  void keep_layers(std::size_t bytes, double least_share = least_share_kept);
  /// What is kept for a detector, of which the objective's own is 0.
  [[nodiscard]] const KeptLayers<T>& kept_layers(std::size_t member) const {
    return members_.at(member).kept;
  }

  /// Records the loss of a minibatch on the active tape and returns it.
  ///
  /// \param parameter  [texel, 3], or a row for each of the method's
  /// \param views      at least one, all of one car in one colour space
  /// \param session    a shot for each view; if not given, the detectors see the pictures as they are
  [[nodiscard]] Variable<T> operator()(const ArrayVariable<T, 2>& parameter, Views views,
                                       const PhotoSession* session = nullptr);

  /// The terms of the last call.
  [[nodiscard]] const ObjectiveTerms& terms() const { return terms_; }
  /// Seconds of each stage, added up over all calls.
  [[nodiscard]] StepTimes& times() { return *times_; }
  [[nodiscard]] const ObjectiveOptions& options() const { return options_; }

 private:
  /// Of each view what `part` points at, which keeps the view alive.
  template <class Part>
  static auto parts_of(Views views, Part part) {
    std::vector<std::shared_ptr<const std::remove_pointer_t<decltype(part(*views[0]))>>> parts;
    for (const auto& view : views) parts.emplace_back(view, part(*view));
    return parts;
  }
  static image::ColourSpace space_of(Views views);
  static std::shared_ptr<const raster::MipPyramid> pyramid_of(Views views);
  /// Renders as they are seen where the car covers a pixel wholly.
  static auto seen(image::ColourSpace space, std::vector<ArrayVariable<T, 3>> renders) {
    if (space == image::ColourSpace::linear)
      for (auto& render : renders) render = image::encoded(render);
    return renders;
  }
  /// What shows of the car in each view.
  struct Drawn {
    std::vector<ArrayVariable<T, 3>> renders;
    std::vector<std::shared_ptr<const Array<T, 2>>> interiors;
    std::vector<ArrayVariable<T, 3>> pictures{};  ///< laid over their frames, where they were drawn anew
  };
  static Drawn drawn_of(Views views, const ArrayVariable<T, 2>& texels);
  [[nodiscard]] Drawn redrawn_of(Views views, const ArrayVariable<T, 2>& texels,
                                 const ArrayVariable<T, 2>& steps) const;
  /// Pictures of one size as a batch, [N, H, W, C].
  static ArrayVariable<T, 4> in_batch(const std::vector<ArrayVariable<T, 3>>& pictures);
  static auto interiors_of(Views views) {
    return parts_of(views, [](const View<T>& view) { return &view.interior; });
  }
  static std::vector<image::Backdrop<T>> backdrops_of(Views views);
  static ArrayVariable<T, 4> photographed(ArrayVariable<T, 4> pictures, const PhotoSession* session);
  static std::vector<loss::Target> targets_of(Views views, const PhotoSession* session,
                                              std::size_t class_index);
  [[nodiscard]] auto adversarial_of(const ArrayVariable<T, 4>& pictures, Views views,
                                    const PhotoSession* session, StageClock<T>& clock) {
    std::vector<loss::AdversarialTerms<Variable<T>>> of_members;
    for (Member& member : members_) {
      std::optional<Variable<T>> attention;
      const auto logits = method_.attention > 0 ? explained_logits_of(member, pictures, attention)
                                                : logits_of(member, pictures, views, session);
      clock.end_of(&StepTimes::detector_forward, &StepTimes::detector_backward);
      of_members.push_back(loss::adversarial(*member.detector, logits,
                                             targets_of(views, session, member.class_index), options_.kind,
                                             options_.weights));
      if (attention) of_members.back().total = *attention;
      clock.end_of(&StepTimes::losses);
    }
    return loss::mean_of(of_members);
  }
  struct Member {
    const detect::Detector<T>* detector;
    std::size_t class_index;
    detect::PassPool<T> passes{};
    KeptLayers<T> kept{};
  };

  /// Leaves in `attention` the mean over the pictures, weighted.
  [[nodiscard]] auto explained_logits_of(Member& member, const ArrayVariable<T, 4>& pictures,
                                         std::optional<Variable<T>>& attention) {
    auto explained =
        detect::explained_forward(*member.detector, pictures, member.class_index, member.passes.take());
    Variable<T> sum = T(0);
    for (const auto& heat : explained.heat) sum += loss::attention(heat);
    attention = static_cast<T>(method_.attention / static_cast<double>(explained.heat.size())) * sum;
    return std::move(explained.logits);
  }

  [[nodiscard]] auto logits_of(Member& member, const ArrayVariable<T, 4>& pictures, Views views,
                               const PhotoSession* session) {
    std::vector<detect::KeptPicture<T>*> kept;
    if (layer_bytes_ > 0 && session == nullptr && !method_.shape)
      kept = member.kept.of(*member.detector, views, least_share_kept_);
    if (kept.empty()) return detect::forward(*member.detector, pictures, member.passes.take());
    auto logits = detect::forward_within(*member.detector, pictures, kept, member.passes.take());
    member.kept.limit_to(layer_bytes_ / members_.size(), views);
    return logits;
  }

  std::vector<Member> members_;  ///< at least one
  ObjectiveOptions options_;
  Method<T> method_;
  std::size_t layer_bytes_ = 0;
  double least_share_kept_ = least_share_kept;
  std::shared_ptr<const Array<T, 2>> used_texels_;
  std::shared_ptr<const Array<double, 2>> palette_;
  std::shared_ptr<const Array<T, 2>> printed_texels_;
  ObjectiveTerms terms_;
  std::shared_ptr<StepTimes> times_ = std::make_shared<StepTimes>();
};

extern template class Objective<float>;
extern template class Objective<double>;

}  // namespace tapestry::camouflage
