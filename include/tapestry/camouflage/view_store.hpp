#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/image/colour.hpp>
#include <tapestry/image/letterbox.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

/// Bytes that a prepared view holds, besides small change.
template <class T>
[[nodiscard]] std::size_t view_bytes(const View<T>& view) {
  const std::size_t mask = view.sight ? view.sight->mask.size() : 0;
  return (view.background.size() + view.interior.size() + mask) * sizeof(T) +
         raster::memory_bytes(view.paint_to_picture);
}

/// Prepares views when they are first asked for and keeps them up to a memory limit, so that an epoch
/// after the first rasterises nothing as long as the frames fit, and 12,500 frames still run. Frames that
/// have the size of the network's input are kept as bytes, a quarter of what they are as numbers.
///
/// What a view holds does not depend on whether it was kept, so neither does any result.
template <class T>
class ViewStore {
 public:
  using Loader = std::function<io::Frame()>;
  using ViewPointer = std::shared_ptr<const View<T>>;

  /// How views are made, and how many are kept.
  struct Settings {
    std::size_t height = 0;  ///< of the network's input
    std::size_t width = 0;
    std::size_t samples_per_axis = 2;
    std::size_t keep_bytes = std::size_t(4) << 30U;  ///< views beyond it are prepared anew each time
    image::Fit fit{};                                ///< of frames in the network's input
    std::optional<PhotoLight> photo_light{};         ///< how light is estimated; none: the frames' own
    bool redrawn = false;                            ///< whether views keep what they are drawn by, see Sight
  };

  /// \param car  must outlive the store
  ViewStore(const raster::PaintedMesh& car, Settings settings, std::vector<Loader> loaders)
      : car_(car), settings_(std::move(settings)), loaders_(std::move(loaders)), kept_(loaders_.size()) {}

  [[nodiscard]] std::size_t size() const { return loaders_.size(); }
  [[nodiscard]] const Settings& settings() const { return settings_; }

  /// View number `index`; throws what its loader throws.
  [[nodiscard]] ViewPointer view(std::size_t index) {
    if (kept_[index].view) return unpacked(kept_[index]);
    auto made = make(index);
    keep(index, made);
    return made;
  }

  /// Views of these numbers, prepared in parallel; throws what the first loader that fails throws.
  [[nodiscard]] std::vector<ViewPointer> views(std::span<const std::size_t> indices) {
    std::vector<ViewPointer> views(indices.size());
    parallel_for(views.size(), [&](std::size_t i) {
      const Kept& kept = kept_[indices[i]];
      views[i] = kept.view ? unpacked(kept) : make(indices[i]);
    });
    for (std::size_t i = 0; i < views.size(); ++i)
      if (!kept_[indices[i]].view) keep(indices[i], views[i]);
    return views;
  }

  /// Calls visit(index, view) for every view in order, preparing some at a time in parallel.
  template <class Visit>
  void for_each(Visit visit) {
    std::vector<std::size_t> indices(size());
    std::iota(indices.begin(), indices.end(), std::size_t{0});
    for (std::size_t block = 0; block < block_count(size(), views_at_a_time); ++block) {
      const auto [begin, end] = block_range(block, size(), views_at_a_time);
      const auto prepared = views(std::span(indices).subspan(begin, end - begin));
      for (std::size_t i = begin; i < end; ++i) visit(i, *prepared[i - begin]);
    }
  }

 private:
  /// A view, without its background where bytes say the same.
  struct Kept {
    ViewPointer view{};
    Array<std::uint8_t, 3> background{};
  };
  static constexpr std::size_t views_at_a_time = 16;

  [[nodiscard]] ViewPointer make(std::size_t index) const {
    const auto& [height, width, samples, keep_bytes, fit, photo_light, redrawn] = settings_;
    const io::Frame frame = loaders_[index]();
    auto view = make_view<T>(frame, car_, height, width, samples, fit, photo_light);
    if (redrawn)
      view.sight =
          std::make_shared<const Sight<T>>(sight_of<T>(frame, car_.space, height, width, samples, fit.kind));
    return std::make_shared<const View<T>>(std::move(view));
  }

  void keep(std::size_t index, const ViewPointer& view) {
    if (kept_bytes_ >= settings_.keep_bytes) return;
    Kept kept = packed(view);
    const std::size_t bytes = view_bytes(*kept.view) + kept.background.size();
    if (kept_bytes_ + bytes > settings_.keep_bytes) {
      kept_bytes_ = settings_.keep_bytes;  // full from now on
      return;
    }
    kept_bytes_ += bytes;
    kept_[index] = std::move(kept);
  }

  [[nodiscard]] static Kept packed(const ViewPointer& view) {
    Kept kept{view, image::to_bytes(view->background)};
    if (image::from_bytes<T>(kept.background) != view->background) return {view};
    auto rest = std::make_shared<View<T>>(*view);
    rest->background = Array<T, 3>();
    kept.view = std::move(rest);
    return kept;
  }
  [[nodiscard]] static ViewPointer unpacked(const Kept& kept) {
    if (kept.background.size() == 0) return kept.view;
    auto view = std::make_shared<View<T>>(*kept.view);
    view->background = image::from_bytes<T>(kept.background);
    return view;
  }

  const raster::PaintedMesh& car_;
  Settings settings_;
  std::vector<Loader> loaders_;
  std::vector<Kept> kept_;
  std::size_t kept_bytes_ = 0;
};

}  // namespace tapestry::camouflage
