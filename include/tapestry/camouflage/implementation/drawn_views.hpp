#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/camouflage/drawn_views.hpp>
#include <tapestry/camouflage/redrawn_view.hpp>
#include <tapestry/image/colour_space_variable.hpp>
#include <tapestry/image/over_variable.hpp>
#include <tapestry/loss/smoothness_variable.hpp>
#include <tapestry/raster/mip_pyramid_variable.hpp>
#include <tapestry/raster/texture_operator_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage::detail {

/// The texels that views are drawn from, in their colour space.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> texels_of(ViewSpan<T> views, const ArrayVariable<T, 2>& colours) {
  if (views.empty()) throw DomainError("objective: no views");
  for (const auto& view : views) {
    if (view->space != views[0]->space) throw DomainError("objective: views in different colour spaces");
    if (view->pyramid != views[0]->pyramid) throw DomainError("objective: views of different pyramids");
  }
  return raster::stored_texels(views[0]->pyramid, image::in_space(views[0]->space, colours));
}

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

}  // namespace tapestry::camouflage::detail

namespace tapestry::camouflage {

template <std::floating_point T>
DrawnViews<T> drawn_views(ViewSpan<T> views, const ArrayVariable<T, 2>& colours) {
  const auto texels = detail::texels_of(views, colours);
  std::vector<std::shared_ptr<const raster::TextureOperator<T>>> operators;
  DrawnViews<T> drawn;
  for (const auto& view : views) {
    operators.push_back(view->paint_to_picture);
    drawn.interiors.push_back(view->interior);
  }
  drawn.renders = raster::render(operators, texels);
  return drawn;
}

template <std::floating_point T>
DrawnViews<T> drawn_views(ViewSpan<T> views, const ArrayVariable<T, 2>& colours, const ShapeParameter& shape,
                          const ArrayVariable<T, 2>& steps) {
  const auto texels = detail::texels_of(views, colours);
  const auto positions = shape_positions(shape, steps);
  DrawnViews<T> drawn;
  for (const auto& view : views) {
    auto anew = redrawn(*view, shape, texels, positions);
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
Variable<T> smoothness_of(ViewSpan<T> views, const DrawnViews<T>& drawn) {
  auto seen = drawn.renders;  // interiors are covered wholly, where a render is the colour itself
  if (views[0]->space == image::ColourSpace::linear)
    for (auto& render : seen) render = image::encoded(render);
  return loss::smoothness(seen, drawn.interiors) / static_cast<T>(views.size());
}

template DrawnViews<float> drawn_views<float>(ViewSpan<float>, const ArrayVariable<float, 2>&);
template DrawnViews<double> drawn_views<double>(ViewSpan<double>, const ArrayVariable<double, 2>&);
template DrawnViews<float> drawn_views<float>(ViewSpan<float>, const ArrayVariable<float, 2>&,
                                              const ShapeParameter&, const ArrayVariable<float, 2>&);
template DrawnViews<double> drawn_views<double>(ViewSpan<double>, const ArrayVariable<double, 2>&,
                                                const ShapeParameter&, const ArrayVariable<double, 2>&);
template decltype(laid_over<float>) laid_over<float>;
template decltype(laid_over<double>) laid_over<double>;
template decltype(smoothness_of<float>) smoothness_of<float>;
template decltype(smoothness_of<double>) smoothness_of<double>;

}  // namespace tapestry::camouflage
