#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <vector>

namespace tapestry::camouflage {

/// Least share of a pass's multiply-adds that a view's window must leave out for its layers to be kept.
/// Below it copies of what is kept and passes over one picture each, not a batch, cost what they save: with
/// a share of .18, the mean over the bundled views, a run takes the same time and twice the memory.
inline constexpr double least_share_kept = 0.25;

/// What a detector keeps of views while a texture is optimised, up to a memory limit: of its layers what the
/// car cannot reach, for views where that is worth it. Views go by their names; of one that has changed
/// everything is computed anew.
template <class T>
class KeptLayers {
 public:
  using Views = ViewSpan<T>;

  /// Kept layers of each view, for detect::forward_within(); null for views that are not worth it or
  /// beyond the memory, nothing if all are.
  ///
  /// \param least_share  of a pass's multiply-adds, see Detector::share_kept(); asked when a view comes first
  [[nodiscard]] std::vector<detect::KeptPicture<T>*> of(const detect::Detector<T>& detector, Views views,
                                                        double least_share);

  /// To be called after a pass over views: forgets them, and takes no more, if they need more memory than
  /// there is.
  void limit_to(std::size_t bytes, Views views);

  [[nodiscard]] std::size_t bytes() const;

  /// Views that have been seen, and those of them of which layers are kept.
  [[nodiscard]] std::size_t view_count() const { return views_.size(); }
  [[nodiscard]] std::size_t kept_count() const;
  /// Mean over all views of the share of multiply-adds that is left out, 0 where nothing is kept.
  [[nodiscard]] double share() const;

 private:
  struct Kept {
    double share = 0;  ///< that its window leaves out
    std::optional<detect::KeptPicture<T>> picture{};
  };

  std::map<std::string, Kept> views_;
  bool is_full_ = false;
};

extern template class KeptLayers<float>;
extern template class KeptLayers<double>;

}  // namespace tapestry::camouflage
