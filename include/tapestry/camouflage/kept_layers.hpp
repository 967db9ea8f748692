#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <vector>

namespace tapestry::camouflage {

/// What a detector keeps of views while a texture is optimised, up to a memory limit: of its layers what the
/// car cannot reach. Views go by their names; of one that has changed everything is computed anew.
template <class T>
class KeptLayers {
 public:
  using Views = std::span<const std::shared_ptr<const View<T>>>;

  /// What is kept of each view, to hand to detect::forward_within(); null for views beyond the memory.
  [[nodiscard]] std::vector<detect::KeptPicture<T>*> of(Views views) {
    std::vector<detect::KeptPicture<T>*> pictures;
    for (const auto& view : views) {
      auto found = kept_.find(view->name);
      if (found == kept_.end() && !is_full_) found = kept_.emplace(view->name, view->window).first;
      const bool is_kept = found != kept_.end() && found->second.window() == view->window;
      pictures.push_back(is_kept ? &found->second : nullptr);
    }
    return pictures;
  }

  /// To be called after a pass over views: forgets them, and takes no more, if they need more memory than
  /// there is.
  void limit_to(std::size_t bytes, Views views) {
    if (is_full_ || this->bytes() <= bytes) return;
    for (const auto& view : views) kept_.erase(view->name);
    is_full_ = true;
  }

  [[nodiscard]] std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& [name, picture] : kept_) sum += picture.bytes();
    return sum;
  }

 private:
  std::map<std::string, detect::KeptPicture<T>> kept_;
  bool is_full_ = false;
};

}  // namespace tapestry::camouflage
