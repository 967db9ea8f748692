#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/camouflage/view_store.hpp>
#include <vector>

namespace tapestry::camouflage {

/// Which views of a store show the car.
struct UsableViews {
  std::vector<std::size_t> indices;   ///< ascending
  std::vector<std::string> warnings;  ///< one for each view that does not show it
};

/// Prepares every view of a store once and sorts out those in which the car is hidden; errors as its loaders.
///
/// \param visit  called with each view in order, so that a program can say how far it is, or give up by an
///               exception
template <class T, std::invocable<const View<T>&> Visit>
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
template <class T>
[[nodiscard]] UsableViews usable_views(ViewStore<T>& store) {
  return usable_views(store, [](const View<T>&) {});
}

}  // namespace tapestry::camouflage
