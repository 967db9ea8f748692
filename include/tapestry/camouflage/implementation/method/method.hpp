#pragma once
#include <tapestry/camouflage/detail/method/method.hpp>
#include <tapestry/image/transform/chain.hpp>

namespace tapestry::camouflage {
template <std::floating_point T>
void require_sound(const Method<T>& method) {
  if (method.greatest.shape() != method.least.shape())
    throw ShapeError({"a method has ", method.least.shape(0), " least colours and ", method.greatest.shape(0),
                      " greatest ones"});
  if (!method.row_of_texel) return;
  const auto& rows = *method.row_of_texel;
  for (std::size_t texel = 0; texel < rows.size(); ++texel)
    if (rows[texel] != Method<T>::unpainted && rows[texel] >= method.row_count)
      throw DomainError({"a method paints texel ", texel, " by row ", rows[texel], " of ", method.row_count});
}

template <std::floating_point T>
std::vector<std::uint8_t> painted_texels(const Method<T>& method) {
  std::vector<std::uint8_t> painted;
  if (!method.row_of_texel) return painted;
  for (const std::size_t row : *method.row_of_texel)
    painted.push_back(row == Method<T>::unpainted ? std::uint8_t{0} : std::uint8_t{1});
  return painted;
}

template <std::floating_point T>
Array<T, 2> first_parameter(const Method<T>& method, const Array<T, 2>& start) {
  const std::size_t below = method.shape ? method.shape->row_count() : 0;
  if (!method.row_of_texel) {
    auto first = zeros<T, 2>({start.shape(0) + below, 3});
    std::copy(start.begin(), start.end(), first.begin());
    return first;
  }
  const auto& rows = *method.row_of_texel;
  require_shape("first_parameter", "start", start, {rows.size(), 3});
  require_sound(method);
  auto first = zeros<T, 2>({method.row_count + below, 3});
  for (std::size_t texel = rows.size(); texel-- > 0;)
    if (rows[texel] != Method<T>::unpainted)
      std::copy_n(start.data() + 3 * texel, 3, first.data() + 3 * rows[texel]);
  return first;
}

template <std::floating_point T>
ArrayVariable<T, 2> texture_rows(const Method<T>& method, const ArrayVariable<T, 2>& parameter) {
  if (!method.shape) return parameter;
  const std::size_t rows = parameter.shape()[0], below = method.shape->row_count();
  if (rows <= below) throw ShapeError({"texture_rows: ", rows, " rows, of which the shape has ", below});
  return ArrayVariable<T, 2>(slice(parameter, {Range{0, rows - below}, Range{}}));
}

template <std::floating_point T>
ArrayVariable<T, 2> method_colours(const Method<T>& method, const ArrayVariable<T, 2>& parameter) {
  require_sound(method);
  const ArrayVariable<T, 2> of_texture = texture_rows(method, parameter);
  if (method.row_of_texel)
    require_shape("method_colours", "parameter", of_texture.value(), {method.row_count, 3});
  ArrayVariable<T, 2> colours = texture_colours(of_texture);
  if (method.least.size() > 0) {
    require_shape("method_colours", "parameter", of_texture.value(), method.least.shape());
    const Array<T, 2> width = method.greatest - method.least;
    colours = ArrayVariable<T, 2>(method.least) + ArrayVariable<T, 2>(width) * colours;
  }
  if (!method.row_of_texel) return colours;
  const auto& rows = *method.row_of_texel;
  Array<T, 2> of_texels = method.elsewhere;
  if (of_texels.size() == 0) of_texels = zeros<T, 2>({rows.size(), 3});
  require_shape("method_colours", "elsewhere", of_texels, {rows.size(), 3});
  for (std::size_t texel = 0; texel < rows.size(); ++texel)
    if (rows[texel] != Method<T>::unpainted)
      std::copy_n(colours.value().data() + 3 * rows[texel], 3, of_texels.data() + 3 * texel);
  const auto pullback = [kept = method.row_of_texel](const Array<T, 2>& of_texels_adjoint,
                                                     Array<T, 2>* colours_adjoint) {
    for (std::size_t texel = 0; texel < kept->size(); ++texel)
      if ((*kept)[texel] != Method<T>::unpainted)
        for (std::size_t c = 0; c < 3; ++c)
          (*colours_adjoint)((*kept)[texel], c) += of_texels_adjoint(texel, c);
  };
  return record_array(std::move(of_texels), pullback, colours);
}

template <std::floating_point T>
ArrayVariable<T, 2> printed(const Method<T>& method, const ArrayVariable<T, 2>& colours,
                            const image::ColourChange& print) {
  const ArrayVariable<T, 2> all = image::transformed(colours, print);
  if (!method.row_of_texel) return all;
  const auto pullback = [rows = method.row_of_texel](const Array<T, 2>& result_adjoint,
                                                     Array<T, 2>* all_adjoint, Array<T, 2>* colours_adjoint) {
    for (std::size_t texel = 0; texel < rows->size(); ++texel) {
      Array<T, 2>* const adjoint = (*rows)[texel] == Method<T>::unpainted ? colours_adjoint : all_adjoint;
      for (std::size_t c = 0; adjoint != nullptr && c < 3; ++c)
        (*adjoint)(texel, c) += result_adjoint(texel, c);
    }
  };
  return record_array(printed(Paint<T>{colours.value(), painted_texels(method)}, print), pullback, all,
                      colours);
}

template <std::floating_point T>
Method<T> paint_panels(const raster::PaintedMesh& car, const std::vector<PanelTexel>& texels) {
  std::vector<std::size_t> rows(car.layout.texel_count(car.mesh), Method<T>::unpainted);
  for (std::size_t row = 0; row < texels.size(); ++row) rows[texels[row].texel] = row;
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(std::move(rows));
  method.row_count = texels.size();
  method.elsewhere = own_colours<T>(car);
  return method;
}
}  // namespace tapestry::camouflage
