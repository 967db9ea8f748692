#pragma once
#include <tapestry/camouflage/detail/method/method.hpp>
#include <tapestry/camouflage/ensemble.hpp>

/// \file
/// The first header of camouflage/: a paint p, optimised so that a detector loses the car.
///
///   minimise   mean over views of  adversarial(detector(render(p) over the frame)) + μ · smoothness(p)
///
///   ViewStore --> views of a step --> Objective --> gradient --> Adam --> p     (repeated by Training)
///
/// Read next: paint.hpp, view.hpp, ensemble.hpp, view_store.hpp, training.hpp; other designs: method/.

namespace tapestry::camouflage {
/// A part of the loss on the tape, and the values of its terms.
template <std::floating_point T>
struct Evaluated {
  Variable<T> loss;
  ObjectiveTerms terms;

  /// Adds a term to the loss.
  /// \param term  receives the value; null: only the total does
  void add(double ObjectiveTerms::*term, const Variable<T>& value, double weight) {
    if (term != nullptr) terms.*term = static_cast<double>(value.value());
    loss += static_cast<T>(weight) * value;
    terms.total = static_cast<double>(loss.value());
  }
};

/// The paint that all views of a step are drawn by, on the tape.
template <std::floating_point T>
struct DrawnPaint {
  ArrayVariable<T, 2> texels;       ///< printed colours in the views' space, with the levels of a pyramid
  ArrayVariable<T, 2> positions{};  ///< [V, 3] in the world where the method moves the shape, else empty
  bool is_of_view = false;          ///< whether texels holds the raster::own_texels() of the only view alone
};

/// The whole pipeline as one function on the tape:
///
///   parameter → colours → render → over the frames → detector → adversarial loss + μ · smoothness
///
/// and, once print_by() has set a printer, + its weight · non-printability score. Each stage can be used
/// alone: method_colours(), drawn_views(), laid_over(), photographed(), Ensemble, the losses.
///
/// A photo session prints the colours first, and photographs the pictures after they are laid over the
/// frames. Views in image::ColourSpace::linear are rendered and laid over in light; colours, pictures and the
/// steps that smoothness sums stay encoded.
///
/// Source: FCA (AAAI 2022), eq. 2-7 and Algorithm 1. Differs in that smoothness is summed over steps of the
/// paint within the car (eq. 5: over the composited picture). The network's weights, the frames and the
/// cameras are passive and record nothing. May be called again before the tape is reversed.
template <std::floating_point T>
class Objective {
 public:
  using Views = ViewSpan<T>;

  /// \param detector     must outlive the objective
  /// \param used_texels  [height, width] of the atlas; if given, smoothness counts steps between its texels
  ///                     of 1 instead of steps in the pictures
  /// \throws DomainError if the detector has no class of that index, or no raw logits
  Objective(const detect::Detector<T>& detector, ObjectiveOptions options,
            std::shared_ptr<const Array<T, 2>> used_texels = nullptr)
      : options_(options), used_texels_(std::move(used_texels)) {
    ensemble_.join(detector, options.class_index);
  }

  /// Adds a detector that knows the car by this class; it counts as much as the earlier ones. The adversarial
  /// terms of such an ensemble are means. It must outlive the objective.
  ///
  /// \throws DomainError as the constructor; ShapeError if it takes pictures of other extents than the first
  void join(const detect::Detector<T>& detector, std::size_t class_index) {
    ensemble_.join(detector, class_index);
  }

  /// Paints by another method than FCA's; the parameter then has its rows. If the method scatters attention,
  /// each detector must observe a layer; terms() still hold the adversarial loss, except in `total`.
  /// If it moves the shape, views must keep their Sight, see sight_of(), and `total` includes the
  /// weighted shape_roughness().
  void follow(Method<T> method) { method_ = std::move(method); }
  [[nodiscard]] const Method<T>& method() const { return method_; }

  /// Adds the paint's non-printability score to the loss, with its weight in the options.
  ///
  /// \param palette  printable colours, [colour, 3]
  /// \param used     [height, width] of the atlas, 1 for texels that are printed
  /// \throws as loss::non_printability(), from the next call on
  void print_by(std::shared_ptr<const Array<double, 2>> palette, std::shared_ptr<const Array<T, 2>> used) {
    palette_ = std::move(palette);
    printed_texels_ = std::move(used);
  }

  /// Keeps, from step to step, the parts of the detectors' layers that the car cannot reach. This is done for
  /// views where it saves at least a share of the products, up to so many bytes for all views and detectors
  /// together; 0, the default, keeps nothing. Results are the same bits. Steps with a photo session, or with
  /// a moving shape, change more and compute everything.
  void keep_layers(std::size_t bytes, double least_share = least_share_kept) {
    ensemble_.keep_layers(bytes, least_share);
  }
  /// Kept layers of a detector; number 0 is the objective's own.
  [[nodiscard]] const KeptLayers<T>& kept_layers(std::size_t member) const {
    return ensemble_.kept_layers(member);
  }

  /// Records the loss of a minibatch on the active tape and returns it.
  ///
  /// \param parameter  [texel, 3], or a row for each of the method's
  /// \param views      at least one, all of one car in one colour space
  /// \param session    a shot for each view; if not given, the detectors see unchanged pictures
  [[nodiscard]] Variable<T> operator()(const ArrayVariable<T, 2>& parameter, Views views,
                                       const PhotoSession* session = nullptr);

  /// First part of the objective: the paint that the views are drawn with, and the loss of the paint alone.
  /// Smoothness in the atlas, printability and the roughness of a moved shape do not depend on views.
  /// \param views  for their colour space and pyramid
  [[nodiscard]] std::pair<DrawnPaint<T>, Evaluated<T>> paint_of(const ArrayVariable<T, 2>& parameter,
                                                                Views views,
                                                                const PhotoSession* session = nullptr);

  /// Second part: the loss of the views. Threads that share an objective record each on a tape of its own,
  /// with views and a paint of its own.
  [[nodiscard]] Evaluated<T> evaluate(const DrawnPaint<T>& paint, Views views,
                                      const PhotoSession* session = nullptr);

  /// Whether a step is faster with a thread for each view than with all threads on one view after the
  /// other: with few weights in the detectors. Large networks have layers that are long enough to share,
  /// and passes that take much memory.
  [[nodiscard]] bool prefers_views_side_by_side() const { return ensemble_.weight_count() <= lane_weights; }

  /// The terms of the last operator().
  [[nodiscard]] const ObjectiveTerms& terms() const { return terms_; }
  /// Seconds of each stage, added up over all calls and threads.
  [[nodiscard]] StepTimes& times() { return *times_; }
  [[nodiscard]] const ObjectiveOptions& options() const { return options_; }

 private:
  static constexpr std::size_t lane_weights = std::size_t(16) << 20U;

  Ensemble<T> ensemble_{};
  ObjectiveOptions options_;
  Method<T> method_{};
  std::shared_ptr<const Array<T, 2>> used_texels_;
  std::shared_ptr<const Array<double, 2>> palette_{};
  std::shared_ptr<const Array<T, 2>> printed_texels_{};
  ObjectiveTerms terms_{};
  std::shared_ptr<StepTimes> times_ = std::make_shared<StepTimes>();
};

extern template class Objective<float>;
}  // namespace tapestry::camouflage
