#pragma once
#include "survey_watch.hpp"

namespace tapestry::shell {
class ReshapedViews {
 public:
  /// \param settings  of the views of the original car; here unpainted faces show their materials, since a
  ///                  photograph shows the car in its own shape
  /// \param loaders   of these views
  ReshapedViews(const raster::PaintedMesh& car, const Array<float, 2>& offsets,
                camouflage::ViewStore<float>::Settings settings,
                std::vector<camouflage::ViewStore<float>::Loader> loaders)
      : car_(std::make_unique<const raster::PaintedMesh>(camouflage::reshaped(car, offsets))),
        store_(std::make_unique<camouflage::ViewStore<float>>(*car_, in_materials(std::move(settings)),
                                                              std::move(loaders))) {}

  [[nodiscard]] const raster::PaintedMesh& car() const { return *car_; }
  [[nodiscard]] camouflage::ViewStore<float>& store() { return *store_; }

  /// The views among `views`, in ascending order, that show the car in this shape, too.
  /// \throws Stopped when a signal arrives
  [[nodiscard]] std::vector<std::size_t> also_with_car(const std::vector<std::size_t>& views) {
    const auto own = camouflage::usable_views(*store_, [](const camouflage::View<float>&) {
                       StopSignal::throw_if_arrived();
                     }).indices;
    std::vector<std::size_t> both;
    std::ranges::set_intersection(views, own, std::back_inserter(both));
    return both;
  }

 private:
  static camouflage::ViewStore<float>::Settings in_materials(
      camouflage::ViewStore<float>::Settings settings) {
    settings.keeps_photograph = false;
    return settings;
  }

  std::unique_ptr<const raster::PaintedMesh> car_;  // which the store refers to
  std::unique_ptr<camouflage::ViewStore<float>> store_;
};
}  // namespace tapestry::shell
