#pragma once
#include <tapestry/camouflage/view.hpp>

namespace tapestry::camouflage {
/// Bytes of a prepared view, without small members.
template <std::floating_point T>
[[nodiscard]] std::size_t view_bytes(const View<T>& view);

/// Prepares views on first use and keeps them up to a memory limit. So an epoch after the first rasterises
/// nothing if the frames fit, and 12,500 frames still run. Frames that have the size of the network's input
/// are kept as bytes, a quarter of their size as numbers.
///
/// A view is the same whether it was kept or not, and so is every result.
template <std::floating_point T>
class ViewStore {
 public:
  using Loader = std::function<io::Frame()>;
  using ViewPointer = std::shared_ptr<const View<T>>;

  /// Settings for making and keeping views.
  struct Settings {
    std::size_t height = 0;  ///< of the network's input
    std::size_t width = 0;
    std::size_t samples_per_axis = 2;
    std::uint64_t keep_bytes = std::uint64_t(4) << 30U;  ///< views beyond it are prepared anew each time
    image::Fit fit{};                                    ///< of frames in the network's input
    std::optional<PhotoLight> photo_light{};  ///< settings of estimated light; none: the frames' own light
    bool redrawn = false;                     ///< whether views keep their Sight
    bool keeps_photograph = true;             ///< see make_view()
  };

  /// \param car  must outlive the store
  ViewStore(const raster::PaintedMesh& car, Settings settings, std::vector<Loader> loaders)
      : car_(car), settings_(std::move(settings)), loaders_(std::move(loaders)), kept_(loaders_.size()) {}

  [[nodiscard]] std::size_t size() const { return loaders_.size(); }
  [[nodiscard]] const Settings& settings() const { return settings_; }

  /// Memory of the views that are kept.
  [[nodiscard]] std::uint64_t kept_bytes() const { return kept_bytes_; }

  /// View number `index`; throws what its loader throws. Several threads may call it at once.
  [[nodiscard]] ViewPointer view(std::size_t index);

  /// Forgets the kept views; they are prepared anew when they are needed again.
  void release() {
    kept_.assign(size(), {});
    kept_bytes_ = 0;
  }

  /// Calls visit(index, view) for every view in order, preparing some at a time in parallel.
  template <class Visit>
  void for_each(Visit visit) {
    for_each_in_order(
        size(), [&](std::size_t index) { return view(index); },
        [&](std::size_t index, const ViewPointer& prepared) { visit(index, *prepared); });
  }

 private:
  /// A view without its interior, and without its background if bytes hold the same one.
  struct Kept {
    ViewPointer view{};
    Array<std::uint8_t, 3> background{};
  };

  /// Frames of one place and hour, and their light; null if it cannot be estimated.
  struct Place {
    std::vector<std::size_t> frames{};
    std::shared_ptr<const raster::EstimatedLight> light{};
    std::once_flag estimated{};
  };

  /// Places by frame, found when the first light is needed.
  struct Places {
    std::once_flag found{};
    std::vector<std::shared_ptr<Place>> of_frame{};
  };

  /// The settings of a frame's light, with that of its place if other frames share it.
  [[nodiscard]] std::optional<PhotoLight> light_rule(std::size_t index) const;

  void find_places() const;
  void estimate(Place& place) const;

  [[nodiscard]] ViewPointer make(std::size_t index) const;

  void keep(std::size_t index, const ViewPointer& view);

  template <class Body>
  decltype(auto) locked(Body body) const {
    const std::lock_guard lock(*keeping_);
    return body();
  }

  [[nodiscard]] static Kept packed(const ViewPointer& view);
  [[nodiscard]] static ViewPointer unpacked(const Kept& kept);

  const raster::PaintedMesh& car_;
  Settings settings_;
  std::vector<Loader> loaders_;
  std::vector<Kept> kept_;
  std::uint64_t kept_bytes_ = 0;
  std::unique_ptr<std::mutex> keeping_ = std::make_unique<std::mutex>();
  std::unique_ptr<Places> places_ = std::make_unique<Places>();
};

extern template class ViewStore<float>;

/// Which views of a store show the car.
struct UsableViews {
  std::vector<std::size_t> indices;   ///< ascending
  std::vector<std::string> warnings;  ///< one for each view without the car
};

/// Prepares every view of a store once and sorts out views with a hidden car; throws as its loaders.
///
/// \param visit  called with each view in order; may report progress, or throw to give up
template <std::floating_point T, std::invocable<const View<T>&> Visit>
[[nodiscard]] UsableViews usable_views(ViewStore<T>& store, Visit visit) {
  UsableViews usable;
  store.for_each([&](std::size_t index, const View<T>& view) {
    visit(view);
    if (view.visible_pixels > 0)
      usable.indices.push_back(index);
    else
      usable.warnings.push_back("frame " + view.name + " does not show the car and is left out");
  });
  return usable;
}

/// The same without a visitor.
template <std::floating_point T>
[[nodiscard]] UsableViews usable_views(ViewStore<T>& store) {
  return usable_views(store, [](const View<T>&) {});
}
}  // namespace tapestry::camouflage
