#pragma once
#include <tapestry/camouflage/detail/method/method.hpp>
#include <tapestry/image/transform/chain.hpp>
#include <tapestry/raster/bake.hpp>

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

template void require_sound<float>(const Method<float>& method);
template void require_sound<double>(const Method<double>& method);
template decltype(painted_texels<float>) painted_texels<float>;
template decltype(painted_texels<double>) painted_texels<double>;
template decltype(first_parameter<float>) first_parameter<float>;
template decltype(first_parameter<double>) first_parameter<double>;
template decltype(texture_rows<float>) texture_rows<float>;
template decltype(texture_rows<double>) texture_rows<double>;
template ArrayVariable<float, 2> method_colours<float>(const Method<float>& method,
                                                       const ArrayVariable<float, 2>& parameter);
template ArrayVariable<double, 2> method_colours<double>(const Method<double>& method,
                                                         const ArrayVariable<double, 2>& parameter);
template ArrayVariable<float, 2> printed<float>(const Method<float>& method,
                                                const ArrayVariable<float, 2>& colours,
                                                const image::ColourChange& print);
template ArrayVariable<double, 2> printed<double>(const Method<double>& method,
                                                  const ArrayVariable<double, 2>& colours,
                                                  const image::ColourChange& print);

}  // namespace tapestry::camouflage

namespace tapestry::camouflage::detail {

/// The box around the painted faces. A place in it is (a, b, h): a from −1 at the rear to 1 at the front, b
/// from −1 on the right to 1 on the left, h from 0 below to 1 on top.
class PaintedBox {
 public:
  explicit PaintedBox(const raster::PaintedMesh& car) {
    for (std::size_t face = 0; face < car.painted.size(); ++face) {
      if (car.painted[face] == 0) continue;
      for (const std::int32_t corner : car.mesh.faces[face])
        for (std::size_t k = 0; k < 3; ++k) {
          const double x = car.mesh.positions[static_cast<std::size_t>(corner)][k];
          low_[k] = std::min(low_[k], x);
          high_[k] = std::max(high_[k], x);
        }
    }
  }
  [[nodiscard]] std::array<double, 3> operator()(const std::array<double, 3>& x) const {
    std::array<double, 3> place{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double share = high_[k] > low_[k] ? (x[k] - low_[k]) / (high_[k] - low_[k]) : 0.5;
      place[k] = k == 2 ? share : 2 * share - 1;
    }
    return place;
  }

 private:
  static constexpr double most = std::numeric_limits<double>::max();
  std::array<double, 3> low_{most, most, most}, high_{-most, -most, -most};
};

/// The panel at a place of the box with this normal, of any length and side.
[[nodiscard]] inline std::optional<Panel> panel_at(const std::array<double, 3>& place,
                                                   const std::array<double, 3>& normal) {
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  const auto faces = [&](std::size_t axis) { return std::abs(normal[axis]) > std::sqrt(0.5) * length; };
  const auto [a, b, h] = place;
  if (faces(2) && h > 0.85 && std::abs(a) < 0.6) return Panel::roof;
  if (faces(2) && h > 0.35 && h < 0.85 && a > 0.35 && a < 0.95) return Panel::hood;
  if (faces(1) && h > 0.1 && h < 0.65 && std::abs(a) < 0.45 && std::abs(b) > 0.6)
    return b > 0 ? Panel::left_doors : Panel::right_doors;
  return {};
}

/// Where a point of the mesh lies in a panel, to the right and up; see PanelTexel.
[[nodiscard]] inline std::array<double, 2> within_panel(Panel panel, const std::array<double, 3>& x) {
  if (panel == Panel::left_doors) return {-x[0], x[2]};
  if (panel == Panel::right_doors) return {x[0], x[2]};
  return {-x[1], x[0]};
}

}  // namespace tapestry::camouflage::detail

namespace tapestry::camouflage {

void require_atlas(const std::string& method, const raster::PaintedMesh& car) {
  if (car.layout.kind != raster::TextureKind::atlas)
    throw DomainError({"the method ", method, " paints parts of an atlas, found a texture of another kind"});
}

std::vector<PanelTexel> panel_texels(const std::string& method, const raster::PaintedMesh& car) {
  require_atlas(method, car);
  const detail::PaintedBox box(car);
  std::vector<std::optional<PanelTexel>> found(car.layout.texel_count(car.mesh));
  for (const bool is_rim : {true, false})
    for (std::size_t face = 0; face < car.painted.size(); ++face) {
      if (car.painted[face] == 0) continue;
      std::array<std::array<double, 3>, 3> corner{};
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c)
          corner[k][c] = car.mesh.positions[static_cast<std::size_t>(car.mesh.faces[face][k])][c];
      const auto normal =
          geometry::cross(geometry::subtract(corner[1], corner[0]), geometry::subtract(corner[2], corner[0]));
      raster::for_each_atlas_texel(
          car.mesh, car.layout, face,
          [&](std::size_t row, std::size_t column, const std::array<double, 3>& weights) {
            if ((std::min({weights[0], weights[1], weights[2]}) < 0) != is_rim) return;
            const auto inside = raster::detail::clamped_barycentric(weights);
            std::array<double, 3> point{};
            for (std::size_t k = 0; k < 3; ++k)
              for (std::size_t c = 0; c < 3; ++c) point[c] += inside[k] * corner[k][c];
            const std::size_t texel = row * car.layout.width + column;
            const auto place = box(point);
            const auto panel = detail::panel_at(place, normal);
            found[texel].reset();
            if (!panel) return;
            const auto [right, up] = detail::within_panel(*panel, point);
            found[texel] = PanelTexel{texel, *panel, right, up, place};
          });
    }
  std::vector<PanelTexel> texels;
  for (const auto& texel : found)
    if (texel) texels.push_back(*texel);
  if (texels.empty())
    throw Error(ErrorKind::mismatch,
                {"the method ", method, " paints roof, hood and doors, of which no painted face is one"});
  return texels;
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

template decltype(paint_panels<float>) paint_panels<float>;
template decltype(paint_panels<double>) paint_panels<double>;

}  // namespace tapestry::camouflage
