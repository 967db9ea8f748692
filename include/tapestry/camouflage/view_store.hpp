#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <tapestry/camouflage/view.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

/// Bytes that a prepared view holds, besides small change.
template <class T>
[[nodiscard]] std::size_t view_bytes(const View<T>& view) {
  return (view.background.size() + view.mask.size()) * sizeof(T) + raster::memory_bytes(view.picture);
}

/// Prepares views when they are first asked for and keeps them up to a memory limit, so that an epoch
/// after the first rasterises nothing as long as the frames fit, and 12,500 frames still run.
///
/// What a view holds does not depend on whether it was kept, so neither does any result.
template <class T>
class ViewStore {
 public:
  using Loader = std::function<Frame()>;

  struct Settings {
    std::size_t height = 0;  ///< of the network's input
    std::size_t width = 0;
    std::size_t samples_per_axis = 2;
    std::size_t keep_bytes = std::size_t(4) << 30U;  ///< views beyond it are prepared anew each time
  };

  /// \param car  must outlive the store
  ViewStore(const PaintedMesh& car, Settings settings, std::vector<Loader> loaders)
      : car_(car), settings_(settings), loaders_(std::move(loaders)), kept_(loaders_.size()) {}

  [[nodiscard]] std::size_t size() const { return loaders_.size(); }
  [[nodiscard]] const Settings& settings() const { return settings_; }

  /// View number `index`; throws what its loader throws.
  [[nodiscard]] std::shared_ptr<const View<T>> view(std::size_t index) {
    if (kept_[index]) return kept_[index];
    auto made = std::make_shared<const View<T>>(
        make_view<T>(loaders_[index](), car_, settings_.height, settings_.width, settings_.samples_per_axis));
    if (kept_bytes_ + view_bytes(*made) <= settings_.keep_bytes) {
      kept_bytes_ += view_bytes(*made);
      kept_[index] = made;
    }
    return made;
  }

 private:
  const PaintedMesh& car_;
  Settings settings_;
  std::vector<Loader> loaders_;
  std::vector<std::shared_ptr<const View<T>>> kept_;
  std::size_t kept_bytes_ = 0;
};

}  // namespace tapestry::camouflage
