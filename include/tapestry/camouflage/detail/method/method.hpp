#pragma once
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>

namespace tapestry::camouflage {
/// The differences between ways of making a camouflage for the same car, detector and budget: which texels
/// are painted, by what, within which colours, whether the car is to be missed or attention scattered, and
/// whether the shape is optimised, too. The default is FCA: each texel for itself, in any colour, to be
/// missed.
template <std::floating_point T>
struct Method {
  static constexpr std::size_t unpainted = std::numeric_limits<std::size_t>::max();

  /// For each texel the row of the parameter that paints it, or `unpainted`; null: texel i has row i.
  std::shared_ptr<const std::vector<std::size_t>> row_of_texel{};
  std::size_t row_count = 0;  ///< rows of the parameter, if row_of_texel is given
  /// Colours of unpainted texels, [texel, 3]; may be empty where there are none.
  Array<T, 2> elsewhere{};
  /// Bounds of the colours of each row, [row, 3], in [0, 1]; empty: 0 and 1.
  Array<T, 2> least{}, greatest{};
  /// Weight of loss::attention(), minimised instead of the adversarial loss; 0: the latter is minimised.
  double attention = 0;
  bool is_optimised = true;  ///< false: the paint stays as it begins
  /// The shape, if it is a parameter, too: its rows follow the texture's. Null: the mesh stays.
  std::shared_ptr<const ShapeParameter> shape{};
};

/// \throws DomainError for a texel whose row does not exist; ShapeError unless bounds have as many rows
template <std::floating_point T>
void require_sound(const Method<T>& method);

/// Which texels a method paints, as Paint::painted.
template <std::floating_point T>
[[nodiscard]] std::vector<std::uint8_t> painted_texels(const Method<T>& method);

/// The first parameter of a method, [row, 3]: each row starts as the first texel it paints, or at 0 if it
/// paints none. Within bounds, the start sets where between them a colour begins, 0 in the middle. If the
/// shape is a parameter, too, it begins as the car's own shape.
///
/// \param start  [texel, 3], a parameter for every texel
/// \throws ShapeError unless the method has as many texels; else as require_sound()
template <std::floating_point T>
[[nodiscard]] Array<T, 2> first_parameter(const Method<T>& method, const Array<T, 2>& start);

/// The rows of a parameter that belong to the texture.
/// \throws ShapeError if there are none
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> texture_rows(const Method<T>& method, const ArrayVariable<T, 2>& parameter);

/// The colours of all texels by a method on the tape, with c = texture_colours(parameter):
///
///   r = least + (greatest − least) · c,   colour of a texel = r of its row, or `elsewhere` if unpainted.
///
/// \param parameter  [row, 3]; rows of a shape behind them are ignored
/// \returns          [texel, 3], in [0, 1]
/// \throws ShapeError unless the parameter has a row for each of the method's; else as require_sound()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> method_colours(const Method<T>& method,
                                                 const ArrayVariable<T, 2>& parameter);

/// The colours on the tape, changed by the printer where the method paints; see printed() of plain numbers.
/// \param colours  as method_colours() returns them
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> printed(const Method<T>& method, const ArrayVariable<T, 2>& colours,
                                          const image::ColourChange& print);

/// method_colours() of plain numbers.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> method_colours(const Method<T>& method, const Array<T, 2>& parameter) {
  return method_colours(method, ArrayVariable<T, 2>(parameter)).value();
}

/// The parts of a car that are nearly flat, large and seen from afar.
enum class Panel : std::uint8_t { roof, hood, left_doors, right_doors };
inline constexpr std::size_t panel_count = 4;

/// A texel of a panel, and where on the car it lies.
struct PanelTexel {
  std::size_t texel = 0;
  Panel panel = Panel::roof;
  /// Place in the panel as an observer sees it, doors upright and the front of the car above roof and hood:
  /// the mesh's units, to the right and up.
  double right = 0, up = 0;
  std::array<double, 3> position{};  ///< in half lengths, half widths and heights of the painted faces
};

/// \throws DomainError naming the method unless the texture is an atlas
void require_atlas(const std::string& method, const raster::PaintedMesh& car);

/// The texels of a car's atlas on its roof, its hood and its doors, each once, in ascending order. The place
/// of a texel is its centre or, for one on the rim of a chart, the nearest point of a face there.
///
/// The panels are found by place and normal in the box around the painted faces, x to the front and z up,
/// since published face lists belong to one mesh only. Roof: nearly level and on top. Hood: nearly level, in
/// front and above the middle. Doors: upright to the side, in the middle of the length and below windows.
///
/// \param method  its name, for the error
/// \throws DomainError unless the texture is an atlas; Error (mismatch) if none of its faces is on a panel
[[nodiscard]] std::vector<PanelTexel> panel_texels(const std::string& method, const raster::PaintedMesh& car);

/// A method that paints these texels, each for itself, by the row of its place in the list; the rest of the
/// car keeps its own colours.
template <std::floating_point T>
[[nodiscard]] Method<T> paint_panels(const raster::PaintedMesh& car, const std::vector<PanelTexel>& texels);
}  // namespace tapestry::camouflage
