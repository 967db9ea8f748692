#pragma once
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <span>
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
  using Views = std::span<const std::shared_ptr<const View<T>>>;

  /// Kept layers of each view, for detect::forward_within(); null for views that are not worth it or
  /// beyond the memory, nothing if all are.
  ///
  /// \param least_share  of a pass's multiply-adds, see Detector::share_kept(); asked when a view comes first
  [[nodiscard]] std::vector<detect::KeptPicture<T>*> of(const detect::Detector<T>& detector, Views views,
                                                        double least_share) {
    std::vector<detect::KeptPicture<T>*> pictures;
    for (const auto& view : views) {
      const auto [found, is_new] = views_.try_emplace(view->name);
      Kept& kept = found->second;
      if (is_new) kept.share = detector.share_kept(view->window);
      if (is_new && !is_full_ && kept.share >= least_share) kept.picture.emplace(view->window);
      pictures.push_back(kept.picture && kept.picture->window() == view->window ? &*kept.picture : nullptr);
    }
    if (std::ranges::count(pictures, nullptr) == std::ssize(pictures)) pictures.clear();
    return pictures;
  }

  /// To be called after a pass over views: forgets them, and takes no more, if they need more memory than
  /// there is.
  void limit_to(std::size_t bytes, Views views) {
    if (is_full_ || this->bytes() <= bytes) return;
    for (const auto& view : views) views_[view->name].picture.reset();
    is_full_ = true;
  }

  [[nodiscard]] std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& [name, kept] : views_) sum += kept.picture ? kept.picture->bytes() : 0;
    return sum;
  }

  /// Views that have been seen, and those of them of which layers are kept.
  [[nodiscard]] std::size_t view_count() const { return views_.size(); }
  [[nodiscard]] std::size_t kept_count() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(views_, [](const auto& entry) { return entry.second.picture.has_value(); }));
  }
  /// Mean over all views of the share of multiply-adds that is left out, 0 where nothing is kept.
  [[nodiscard]] double share() const {
    double sum = 0;
    for (const auto& [name, kept] : views_) sum += kept.picture ? kept.share : 0;
    return views_.empty() ? 0 : sum / static_cast<double>(views_.size());
  }

 private:
  struct Kept {
    double share = 0;  ///< that its window leaves out
    std::optional<detect::KeptPicture<T>> picture{};
  };

  std::map<std::string, Kept> views_;
  bool is_full_ = false;
};

}  // namespace tapestry::camouflage
