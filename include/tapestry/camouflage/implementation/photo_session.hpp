#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/camouflage/photo_session_variable.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/image/transform/chain_variable.hpp>
#include <tapestry/image/transform/conditions.hpp>
#include <utility>
#include <variant>
#include <vector>

namespace tapestry::camouflage::detail {

/// The box around the covered pixels of a view after a warp, an empty one if some come to lie behind the
/// camera. A warp keeps lines straight, so that the ends of each row say how far it reaches.
template <class T>
detect::Box warped_target(const View<T>& view, const image::Warp& warp) {
  const std::size_t height = view.background.shape(0), width = view.background.shape(1);
  const auto& coverage = view.paint_to_picture->coverage;
  const image::WarpedPoint at(warp, height, width);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double left = infinity, right = -infinity, top = infinity, bottom = -infinity;
  for (std::size_t y = 0; y < coverage.shape(0); ++y) {
    const T* const row = coverage.data() + y * coverage.shape(1);
    const T* const end = row + coverage.shape(1);
    const auto is_covered = [](T share) { return share > T(0); };
    const T* const first = std::find_if(row, end, is_covered);
    if (first == end) continue;
    const T* const last =
        std::find_if(std::reverse_iterator(end), std::reverse_iterator(row), is_covered).base();
    for (const T* const edge : {first, last})
      for (const std::size_t below : {y, y + 1}) {
        const auto warped = at(static_cast<double>(view.window.left) + static_cast<double>(edge - row),
                               static_cast<double>(view.window.top + below));
        if (!warped) return {};
        const auto [warped_x, warped_y] = *warped;
        left = std::min(left, warped_x), right = std::max(right, warped_x);
        top = std::min(top, warped_y), bottom = std::max(bottom, warped_y);
      }
  }
  return detect::box_from_corners(left, top, right, bottom);
}

/// The part of a box within a picture.
inline detect::Box cut_to(const detect::Box& box, double height, double width) {
  const double left = std::clamp(box.left(), 0.0, width), right = std::clamp(box.right(), 0.0, width);
  const double top = std::clamp(box.top(), 0.0, height), bottom = std::clamp(box.bottom(), 0.0, height);
  return detect::box_from_corners(left, top, right, bottom);
}

}  // namespace tapestry::camouflage::detail

namespace tapestry::camouflage {

template <std::floating_point T>
Shot draw_shot(const View<T>& view, const image::Conditions& conditions, Random random, bool is_smooth) {
  Shot shot{image::draw_chain(conditions, random, is_smooth), view.target};
  const auto* const warp = shot.chain.empty() ? nullptr : std::get_if<image::Warp>(&shot.chain.front());
  if (warp == nullptr || view.visible_pixels == 0) return shot;
  const auto whole = detail::warped_target(view, *warp);
  const auto cut = detail::cut_to(whole, static_cast<double>(view.background.shape(0)),
                                  static_cast<double>(view.background.shape(1)));
  if (cut.area() > whole.area() / 2)
    shot.target = cut;
  else
    shot.chain.erase(shot.chain.begin());
  return shot;
}

template <std::floating_point T>
PhotoSession draw_session(ViewSpan<T> views, const image::Conditions& conditions, Random random,
                          bool is_smooth) {
  PhotoSession session;
  if (conditions.printed_range > 0 || conditions.printed_error > 0)
    session.print = image::draw_print(conditions, random.fork(0));
  for (std::size_t i = 0; i < views.size(); ++i)
    session.shots.push_back(draw_shot(*views[i], conditions, random.fork(i + 1), is_smooth));
  return session;
}

void require_shots(const PhotoSession* session, std::size_t views) {
  if (session != nullptr && session->shots.size() != views)
    throw ShapeError("objective: a photo session of " + std::to_string(session->shots.size()) +
                     " shots for " + std::to_string(views) + " views");
}

template <std::floating_point T>
std::vector<loss::Target> targets_of(ViewSpan<T> views, const PhotoSession* session,
                                     std::size_t class_index) {
  std::vector<loss::Target> targets;
  for (std::size_t i = 0; i < views.size(); ++i)
    targets.push_back({class_index, session == nullptr ? views[i]->target : session->shots[i].target});
  return targets;
}

template <std::floating_point T>
ArrayVariable<T, 4> photographed(const ArrayVariable<T, 4>& pictures, const PhotoSession* session) {
  if (session == nullptr) return pictures;
  std::vector<image::TransformationChain> chains;
  for (const Shot& shot : session->shots) chains.push_back(shot.chain);
  return image::transformed(pictures, chains);
}

template decltype(targets_of<float>) targets_of<float>;
template decltype(targets_of<double>) targets_of<double>;
template decltype(photographed<float>) photographed<float>;
template decltype(photographed<double>) photographed<double>;
template decltype(draw_shot<float>) draw_shot<float>;
template decltype(draw_shot<double>) draw_shot<double>;
template decltype(draw_session<float>) draw_session<float>;
template decltype(draw_session<double>) draw_session<double>;

}  // namespace tapestry::camouflage
