#pragma once
#include <tapestry/camouflage/objective_terms.hpp>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/camouflage/profile.hpp>
#include <tapestry/detect/kept_picture.hpp>

namespace tapestry::camouflage {
/// Least share of a pass's multiply-adds that a view's window must leave out for its layers to be kept. Below
/// it, keeping costs as much as it saves: copies, and passes over one picture each instead of a batch. With a
/// share of .18, the mean over the bundled views, a run takes the same time and twice the memory.
inline constexpr double least_share_kept = 0.25;

/// Keeps, up to a memory limit, layers of a detector for views while a texture is optimised: the parts of its
/// layers that the car cannot reach, for views where that saves time. Views are known by name; a view that
/// has changed is computed anew. Several threads may call it at once, with different views; which views are
/// kept when memory runs out then depends on their order, results never do.
template <std::floating_point T>
class KeptLayers {
 public:
  using Views = ViewSpan<T>;

  /// Kept layers of each view, for detect::forward_within(). Null for views that save too little or
  /// exceed the memory; empty if all views do.
  ///
  /// \param least_share  of a pass's multiply-adds, see Detector::share_kept(); read when a view is new
  [[nodiscard]] std::vector<detect::KeptPicture<T>*> of(const detect::Detector<T>& detector, Views views,
                                                        double least_share);

  /// Call it after a pass over views: if they need more memory than `bytes`, forgets them and takes no more.
  void limit_to(std::size_t bytes, Views views);

  /// Memory that the views of limit_to() take.
  [[nodiscard]] std::size_t bytes() const;

  /// Views seen so far; views with kept layers.
  [[nodiscard]] std::size_t view_count() const { return views_.size(); }
  [[nodiscard]] std::size_t kept_count() const;
  /// Mean over all views of the saved share of multiply-adds; 0 for a view without kept layers.
  [[nodiscard]] double share() const;

 private:
  struct Kept {
    double share = 0;       ///< share of the work that its window saves
    std::size_t bytes = 0;  ///< of the picture after its last pass
    std::optional<detect::KeptPicture<T>> picture{};
  };

  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  std::map<std::string, Kept> views_;
  bool is_full_ = false;
};

extern template class KeptLayers<float>;

/// Pictures for detectors, on the tape, and where they come from.
template <std::floating_point T>
struct ShownPictures {
  const ArrayVariable<T, 4>& pictures;    ///< [N, H, W, 3]
  ViewSpan<T> views;                      ///< N
  const PhotoSession* session = nullptr;  ///< N shots, if the pictures were photographed
  bool is_redrawn = false;                ///< whether they change beyond the views' windows
};

/// Detectors of the same pictures, and the mean of their adversarial losses. Once all have joined, several
/// threads may call it at once, with different views.
template <std::floating_point T>
class Ensemble {
 public:
  /// Adds a detector; `class_index` is the car's class in it. It counts as much as the earlier ones, and must
  /// outlive this object.
  ///
  /// \throws DomainError if the detector has no class of that index, or no raw logits; ShapeError if it takes
  ///         pictures of other extents than the first
  void join(const detect::Detector<T>& detector, std::size_t class_index);

  /// See Objective::keep_layers().
  void keep_layers(std::size_t bytes, double least_share);
  /// Layers kept for a detector; members are numbered in the order of joining.
  [[nodiscard]] const KeptLayers<T>& kept_layers(std::size_t member) const {
    return members_.at(member).kept;
  }

  /// Weights of all detectors together.
  [[nodiscard]] std::size_t weight_count() const;

  /// \param attention  weight of loss::attention(): `total` is then its mean over the pictures; 0: `total` is
  ///                   the adversarial loss. Each detector must then observe a layer
  [[nodiscard]] loss::AdversarialTerms<Variable<T>> operator()(const ShownPictures<T>& shown,
                                                               const ObjectiveOptions& options,
                                                               double attention, StageClock<T>& clock);

 private:
  struct Member {
    const detect::Detector<T>* detector;
    std::size_t class_index;
    detect::PassPool<T> passes{};
    KeptLayers<T> kept{};
  };
  using Logits = std::vector<ArrayVariable<T, 4>>;

  [[nodiscard]] Logits logits_of(Member& member, const ShownPictures<T>& shown);

  /// Logits, and the mean over the pictures of their attention loss.
  struct Explained {
    Logits logits;
    Variable<T> attention;
  };
  [[nodiscard]] Explained explained(Member& member, const ShownPictures<T>& shown, double weight);

  std::vector<Member> members_{};
  std::size_t layer_bytes_ = 0;
  double least_share_kept_ = least_share_kept;
};

extern template class Ensemble<float>;
}  // namespace tapestry::camouflage
