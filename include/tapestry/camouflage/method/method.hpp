#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/camouflage/texture_parameter.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/chain_variable.hpp>
#include <vector>

namespace tapestry::camouflage {

/// What sets one way of making a camouflage apart from others on the same car, detector and budget: which
/// texels are painted, by what, within which colours, whether to be missed or to scatter attention, and
/// whether the shape is optimised, too. As it stands, that of FCA: each texel for itself, in any colour, to
/// be missed.
template <std::floating_point T>
struct Method {
  static constexpr std::size_t unpainted = std::numeric_limits<std::size_t>::max();

  /// Of each texel the row of the parameter that paints it, or `unpainted`; null: texel i has row i.
  std::shared_ptr<const std::vector<std::size_t>> row_of_texel{};
  std::size_t row_count = 0;  ///< of the parameter, if row_of_texel is given
  /// What unpainted texels have, [texel, 3]; may be empty where there are none.
  Array<T, 2> elsewhere{};
  /// Bounds of the colours of each row, [row, 3], in [0, 1]; empty: 0 and 1.
  Array<T, 2> least{}, greatest{};
  /// Weight of loss::attention(), which is then minimised instead of the adversarial loss; 0: the latter is.
  double attention = 0;
  bool is_optimised = true;  ///< or stays as it begins
  /// Where the shape is a parameter, too: its rows follow those of the texture. Null: the mesh stays.
  std::shared_ptr<const ShapeParameter> shape{};
};

/// \throws DomainError for a texel whose row is not there; ShapeError unless bounds are of the same rows
template <class T>
void require_sound(const Method<T>& method) {
  if (method.greatest.shape() != method.least.shape())
    throw ShapeError("a method has " + std::to_string(method.least.shape(0)) + " least colours and " +
                     std::to_string(method.greatest.shape(0)) + " greatest ones");
  if (!method.row_of_texel) return;
  const auto& rows = *method.row_of_texel;
  for (std::size_t texel = 0; texel < rows.size(); ++texel)
    if (rows[texel] != Method<T>::unpainted && rows[texel] >= method.row_count)
      throw DomainError("a method paints texel " + std::to_string(texel) + " by row " +
                        std::to_string(rows[texel]) + " of " + std::to_string(method.row_count));
}

/// Which texels a method paints, as Paint::painted.
template <class T>
[[nodiscard]] std::vector<std::uint8_t> painted_texels(const Method<T>& method) {
  std::vector<std::uint8_t> painted;
  if (!method.row_of_texel) return painted;
  for (const std::size_t row : *method.row_of_texel)
    painted.push_back(row == Method<T>::unpainted ? std::uint8_t{0} : std::uint8_t{1});
  return painted;
}

/// The first parameter of a method, [row, 3]: each row has that of the first texel it paints, 0 if it paints
/// none. So within bounds the start says where in them a colour begins, 0 in the middle. A shape that is a
/// parameter, too, begins as it is.
///
/// \param start  [texel, 3], a parameter for every texel
/// \throws ShapeError unless the method is for as many texels; else as require_sound()
template <class T>
[[nodiscard]] Array<T, 2> first_parameter(const Method<T>& method, const Array<T, 2>& start) {
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

/// The rows of a parameter that are of the texture.
/// \throws ShapeError if there are none
template <class T>
[[nodiscard]] ArrayVariable<T, 2> texture_rows(const Method<T>& method,
                                               const ArrayVariable<T, 2>& parameter) {
  if (!method.shape) return parameter;
  const std::size_t rows = parameter.shape()[0], below = method.shape->row_count();
  if (rows <= below)
    throw ShapeError("texture_rows: " + std::to_string(rows) + " rows, of which the shape has " +
                     std::to_string(below));
  return ArrayVariable<T, 2>(slice(parameter, {Range{0, rows - below}, Range{}}));
}

/// The colours of all texels by a method on the tape, with c = texture_colours(parameter):
///
///   r = least + (greatest − least) · c,   colour of a texel = r of its row, or what it has elsewhere.
///
/// \param parameter  [row, 3]; rows of a shape below them have no part in it
/// \returns          [texel, 3], in [0, 1]
/// \throws ShapeError unless there is a row of the parameter for each of the method's; else as
/// require_sound()
template <class T>
[[nodiscard]] ArrayVariable<T, 2> method_colours(const Method<T>& method,
                                                 const ArrayVariable<T, 2>& parameter) {
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

/// The colours on the tape as a printer makes those that a method paints; printed() of plain numbers.
/// \param colours  as method_colours() returns them
template <class T>
[[nodiscard]] ArrayVariable<T, 2> printed(const Method<T>& method, const ArrayVariable<T, 2>& colours,
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

/// method_colours() of plain numbers.
template <class T>
[[nodiscard]] Array<T, 2> method_colours(const Method<T>& method, const Array<T, 2>& parameter) {
  return method_colours(method, ArrayVariable<T, 2>(parameter)).value();
}

}  // namespace tapestry::camouflage
