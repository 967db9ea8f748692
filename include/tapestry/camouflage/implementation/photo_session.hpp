#pragma once
#include <tapestry/camouflage/detail/drawn_views.hpp>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/image/over.hpp>
#include <tapestry/loss/smoothness.hpp>

namespace tapestry::camouflage {
namespace detail {
/// The box around the covered pixels of a view after a warp; empty if some come to lie behind the camera. A
/// warp keeps lines straight, so that the ends of each row are enough.
template <std::floating_point T>
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
}  // namespace detail

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
  if (conditions.has_print()) session.print = image::draw_print(conditions, random.fork(0));
  for (std::size_t i = 0; i < views.size(); ++i)
    session.shots.push_back(draw_shot(*views[i], conditions, random.fork(i + 1), is_smooth));
  return session;
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

namespace detail {
/// Pictures of one size as a batch, [N, H, W, C].
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> in_batch(const std::vector<ArrayVariable<T, 3>>& pictures) {
  std::vector<ArrayVariable<T, 4>> batch;
  for (const auto& picture : pictures) {
    const auto& [height, width, channels] = picture.shape();
    batch.push_back(reshape(picture, Extents<4>{1, height, width, channels}));
  }
  return concatenate(std::span<const ArrayVariable<T, 4>>(batch), 0);
}
}  // namespace detail

template <std::floating_point T>
ArrayVariable<T, 2> drawn_texels(ViewSpan<T> views, const ArrayVariable<T, 2>& colours) {
  if (views.empty()) throw DomainError("objective: no views");
  for (const auto& view : views) {
    if (view->space != views[0]->space) throw DomainError("objective: views in different colour spaces");
    if (view->pyramid != views[0]->pyramid) throw DomainError("objective: views of different pyramids");
  }
  return raster::stored_texels(views[0]->pyramid, colours, views[0]->space);
}

template <std::floating_point T>
DrawnViews<T> drawn_views(ViewSpan<T> views, const DrawnPaint<T>& paint, const ShapeParameter* shape) {
  DrawnViews<T> drawn;
  if (shape == nullptr) {
    std::vector<std::shared_ptr<const raster::CompactOperator<T>>> operators;
    for (const auto& view : views) {
      operators.push_back(view->paint_to_picture);
      drawn.interiors.push_back(view->interior);
    }
    if (paint.is_of_view)
      drawn.renders = {raster::render(*operators.at(0), paint.texels)};
    else
      drawn.renders = raster::render(operators, paint.texels);
    return drawn;
  }
  for (const auto& view : views) {
    auto anew = redrawn(*view, *shape, paint.texels, paint.positions);
    drawn.renders.push_back(std::move(anew.render));
    drawn.interiors.push_back(std::move(anew.interior));
    drawn.pictures.push_back(std::move(anew.picture));
  }
  return drawn;
}

template <std::floating_point T>
ArrayVariable<T, 4> laid_over(ViewSpan<T> views, const DrawnViews<T>& drawn) {
  if (!drawn.pictures.empty()) return detail::in_batch(drawn.pictures);
  std::vector<image::Backdrop<T>> backdrops;
  for (const auto& view : views)
    backdrops.push_back({{view, &view->background},
                         {view->paint_to_picture, &view->paint_to_picture->coverage},
                         view->window.top,
                         view->window.left});
  return image::over(drawn.renders, backdrops, views[0]->space);
}

template <std::floating_point T>
Variable<T> smoothness_of(ViewSpan<T> views, const DrawnViews<T>& drawn,
                          const ArrayVariable<T, 4>& pictures) {
  std::vector<loss::PlacedMask<T>> masks;
  for (std::size_t n = 0; n < views.size(); ++n) {
    const auto& window = views[n]->window;
    if (drawn.pictures.empty())
      masks.push_back({drawn.interiors[n], window.top, window.left});
    else
      masks.push_back({drawn.interiors[n]});
  }
  return loss::smoothness(pictures, std::move(masks)) / static_cast<T>(views.size());
}
}  // namespace tapestry::camouflage
