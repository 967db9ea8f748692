#pragma once
#include <cstddef>
#include <optional>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/camouflage/kept_layers.hpp>
#include <tapestry/camouflage/objective_terms.hpp>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/camouflage/profile.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/pass_pool.hpp>
#include <tapestry/loss/adversarial_variable.hpp>
#include <vector>

namespace tapestry::camouflage {

/// Pictures that detectors look at, on the tape, and where they come from.
template <class T>
struct ShownPictures {
  const ArrayVariable<T, 4>& pictures;    ///< [N, H, W, 3]
  ViewSpan<T> views;                      ///< N
  const PhotoSession* session = nullptr;  ///< of N shots, if the pictures were photographed
  bool is_redrawn = false;                ///< beyond the views' windows, as where a shape moves
};

/// Detectors that look at the same pictures, and the mean of their adversarial losses.
template <class T>
class Ensemble {
 public:
  /// Lets a detector, in which the car has this class, count as much as those before. It must outlive this.
  ///
  /// \throws DomainError if the detector has no class of that index, or gives no raw logits; ShapeError if it
  ///         takes pictures of other extents than the first
  void join(const detect::Detector<T>& detector, std::size_t class_index);

  /// See Objective::keep_layers().
  void keep_layers(std::size_t bytes, double least_share);
  /// Layers kept for a detector; detectors count in the order in which they joined.
  [[nodiscard]] const KeptLayers<T>& kept_layers(std::size_t member) const {
    return members_.at(member).kept;
  }

  /// \param attention  weight of loss::attention(), whose mean over the pictures is then `total`; 0: `total`
  ///                   is that of the adversarial loss. Each detector must then observe a layer
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

  /// Logits, and the mean over the pictures of what their attention costs.
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
extern template class Ensemble<double>;

}  // namespace tapestry::camouflage
