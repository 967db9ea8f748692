#pragma once
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/image/transform/colour_change.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {
/// Colours for a car, and which of them are paint; the others are the car's own and are not printed.
template <std::floating_point T>
struct Paint {
  Array<T, 2> colours{};                ///< [texel, 3], in [0, 1]
  std::vector<std::uint8_t> painted{};  ///< [texel], 1 for paint and 0 for the car's own; empty: all paint

  [[nodiscard]] bool operator==(const Paint&) const = default;
};

/// A car that is not painted.
template <std::floating_point T>
[[nodiscard]] Paint<T> without_paint(Array<T, 2> colours);

/// \throws ShapeError, naming the operation, unless `painted` is empty or has an entry a texel
template <std::floating_point T>
void require_sound(const char* operation, const Paint<T>& paint);

/// The colours, with those that are paint as a printer reproduces them, [texel, 3].
/// \throws ShapeError as require_sound(); else as image::transformed()
template <std::floating_point T>
[[nodiscard]] Array<T, 2> printed(const Paint<T>& paint, const image::ColourChange& print);

/// Reads the paint that a run ended with from its texture.npz: colours, [texel, 3], and painted, [texel], 0
/// or 1; if the latter is missing, all is paint.
/// \throws FileError: mismatch (of another car or layout), malformed (other values)
[[nodiscard]] Paint<float> read_paint(const std::string& path, std::size_t texel_count);

/// Reads the offsets of the car's positions that a run ended with from its texture.npz, see shape_offsets();
/// of extent 0 if the run kept the shape.
/// \throws FileError: mismatch (of another mesh), malformed (offsets farther than the car is long)
[[nodiscard]] Array<float, 2> read_offsets(const std::string& path, std::size_t position_count);

/// Writes a file for read_paint() and read_offsets(), with the method's parameter, [row, 3].
/// \param offsets  [V, 3], or of extent 0 where the shape stays
/// \param layout   a program's text on how the texels lie on the car, for read_layout(); empty: none
/// \throws ShapeError as require_sound(); FileError (write)
void write_paint(const std::string& path, const Array<float, 2>& parameter, const Paint<float>& paint,
                 const Array<float, 2>& offsets = {}, const std::string& layout = {});

/// Reads the text of write_paint() on how the texels of a texture.npz lie; empty if the file holds none.
/// \throws FileError: malformed (damaged file), mismatch (no text)
[[nodiscard]] std::string read_layout(const std::string& path);

/// The painted faces' own colours as a texture, [texel, 3]: the means of their pictures over each texel, or
/// their materials' colours. Texels that no painted face uses, and the
/// one of a solid texture, take the mean over painted faces.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> own_colours(const raster::PaintedMesh& car);

/// A texture as an atlas picture for a viewer, [H, W, 3] in [0, 1] with row 0 at v = 1, in the layout of
/// raster::with_atlas(). Texels that no painted face refers to take colours of those around them. Texels of
/// other kinds are interpolated in the car's colour space, as when it is drawn.
template <std::floating_point T>
[[nodiscard]] Array<T, 3> atlas_of(const raster::PaintedMesh& car, const Array<T, 2>& colours);

/// parameter_of_colours() keeps colours exactly that are farther than this from 0 and 1.
inline constexpr double colour_margin = 1e-3;

/// The colours of a texture parameter on the tape: c = ½ (tanh p + 1) = σ(2p), so that no step leaves
/// (0, 1). Value and slope keep their relative accuracy towards black, the slope also towards white. Runs on
/// all threads, unlike that formula of arrays. Others write sigmoid(p) or clamp(p, 0, 1) here.
///
/// \param parameter  p, [texel, 3], any real value
/// \returns          c, [texel, 3], in [0, 1]; exactly 0 or 1 where tanh saturates
/// Source: the texture parametrisation of Wang et al.'s published FCA program.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> texture_colours(const ArrayVariable<T, 2>& parameter) {
  Array<T, 2> colours(parameter.shape());
  parallel_for_vectors(
      colours.size(),
      [ p = parameter.value().data(), to = colours.data() ](std::size_t i)
          __attribute__((always_inline)) { to[i] = tapestry::detail::vector_sigmoid(2 * p[i]); });
  const auto pullback = [kept = parameter.shared_value()](const Array<T, 2>& colours_adjoint,
                                                          Array<T, 2>* parameter_adjoint) {
    parallel_for_vectors(
        kept->size(), [ p = kept->data(), from = colours_adjoint.data(),
                        to = parameter_adjoint->data() ](std::size_t i) __attribute__((always_inline)) {
          to[i] += from[i] * 2 * tapestry::detail::vector_sigmoid_slope(2 * p[i]);
        });
  };
  return record_array(std::move(colours), pullback, parameter);
}

/// The same of plain numbers.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> texture_colours(const Array<T, 2>& parameter) {
  return texture_colours(ArrayVariable<T, 2>(parameter)).value();
}

/// The parameter of given colours: p = atanh(2c − 1), with c first moved into [colour_margin, 1 −
/// colour_margin], since a full white or black would need an infinite p.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> parameter_of_colours(const Array<T, 2>& colours);

/// Every texel an independent colour, uniform in [0.02, 0.98]³: the random start and the noise control.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> random_colours(std::size_t texel_count, Random& random);

/// Every texel the same colour.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> solid_colours(std::size_t texel_count, const std::array<double, 3>& colour);
}  // namespace tapestry::camouflage
