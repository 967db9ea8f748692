#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/fragment_shader.hpp>
#include <tapestry/raster/fragments.hpp>
#include <tapestry/raster/lighting.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <vector>

namespace tapestry::raster {

/// A picture of a mesh with a texture.
template <std::floating_point T>
struct TexturedPicture {
  Array<T, 3> colour;                ///< [H, W, 3], lit colour times coverage, row 0 on top
  Array<T, 2> coverage;              ///< [H, W] share of the pixel that shows any face, in [0, 1]
  std::size_t non_finite_faces = 0;  ///< faces left out since a corner is not finite
};

namespace detail {

/// Lookups that wait until their texels have come: textures are larger than caches.
template <class T>
class TexelQueue {
 public:
  explicit TexelQueue(const T* texels) : texels_(texels) {}

  /// Adds scale · Σ weight · texel to a pixel's three values, a few calls later.
  template <class Lighting>
  void add(const FragmentShader<Lighting>& shader, const Fragment& fragment, const std::array<T, 3>& scale,
           T* pixel) {
    if (shader.filter) return add_now(shader, fragment, scale, pixel);
    Lookup& lookup = lookups_[count_ % lookups_.size()];
    if (count_ >= lookups_.size()) finish(lookup);
    ++count_;
    lookup.pixel = pixel;
    lookup.scale = scale;
    lookup.tap_count = 0;
    shader.visit_taps(fragment, [&](const Tap& tap) {
      __builtin_prefetch(texels_ + 3 * tap.texel);
      lookup.taps[lookup.tap_count++] = tap;
    });
  }

  void finish_all() {
    const std::size_t first = count_ > lookups_.size() ? count_ - lookups_.size() : 0;
    for (std::size_t i = first; i < count_; ++i) finish(lookups_[i % lookups_.size()]);
    count_ = 0;
  }

 private:
  struct Lookup {
    T* pixel;
    std::array<T, 3> scale;
    std::size_t tap_count;
    std::array<Tap, 8> taps;
  };

  /// Levels of a pyramid are read where neighbouring pixels read them too.
  template <class Lighting>
  void add_now(const FragmentShader<Lighting>& shader, const Fragment& fragment,
               const std::array<T, 3>& scale, T* pixel) const {
    T red = 0, green = 0, blue = 0;
    shader.visit_taps(fragment, [&](const Tap& tap) {
      const T* const texel = texels_ + 3 * tap.texel;
      const T weight = static_cast<T>(tap.weight);
      red += weight * texel[0];
      green += weight * texel[1];
      blue += weight * texel[2];
    });
    pixel[0] += scale[0] * red;
    pixel[1] += scale[1] * green;
    pixel[2] += scale[2] * blue;
  }

  void finish(const Lookup& lookup) const {
    std::array<T, 3> sum{0, 0, 0};
    for (std::size_t i = 0; i < lookup.tap_count; ++i) {
      const T* const texel = texels_ + 3 * lookup.taps[i].texel;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<T>(lookup.taps[i].weight) * texel[c];
    }
    for (std::size_t c = 0; c < 3; ++c) lookup.pixel[c] += lookup.scale[c] * sum[c];
  }

  const T* texels_;
  std::size_t count_ = 0;
  std::array<Lookup, 16> lookups_;
};

}  // namespace detail

/// Renders a view that is drawn, see drawn_view().
///
/// \param body       of the view's mesh
/// \param fragments  of a layout of the same kind as the body's
/// \param texels     [texel_count, 3]
/// \throws as texture_operator(), ShapeError if texels does not fit the layout, and DomainError if the view
/// is
///         of another mesh, of positions that have moved since, or for another kind of texture
template <std::floating_point T, LightModel Model>
[[nodiscard]] TexturedPicture<T> render_textured(const PaintedMesh& body, const FragmentBands& fragments,
                                                 const Model& light, const Array<T, 2>& texels) {
  detail::require_layout("render_textured", body);
  detail::require_view_of("render_textured", body, fragments);
  require_shape("render_textured", "texels", texels, {stored_texel_count(body.layout, body.mesh), 3});
  const auto lighting = prepare(body.mesh, fragments.camera(), light);
  const auto shader = detail::make_shader(body, lighting, fragments, fragments.camera(), fragments.height(),
                                          fragments.width());
  TexturedPicture<T> picture{zeros<T, 3>({fragments.height(), fragments.width(), 3}),
                             zeros<T, 2>({fragments.height(), fragments.width()}),
                             fragments.non_finite_faces()};
  parallel_for(fragments.band_count(), [&](std::size_t band) {
    detail::TexelQueue<T> queue(texels.data());
    fragments.visit_band(band, detail::grain_of(body.layout), [&](const Fragment& fragment) {
      const auto face = static_cast<std::size_t>(fragment.face);
      picture.coverage.data()[fragment.pixel] += static_cast<T>(fragment.coverage);
      T* const pixel = picture.colour.data() + 3 * fragment.pixel;
      if constexpr (ReflectingLighting<decltype(lighting)>) {
        const auto reflected = lighting.reflected(face, fragment.barycentric);
        for (std::size_t c = 0; c < 3; ++c) pixel[c] += static_cast<T>(fragment.coverage * reflected[c]);
      }
      std::array<T, 3> scale;
      const double factor = fragment.coverage * shader.light_of(fragment);
      for (std::size_t c = 0; c < 3; ++c) scale[c] = static_cast<T>(factor * lighting.light_colour[c]);
      if (body.painted[face] != 0) {
        queue.add(shader, fragment, scale, pixel);
        return;
      }
      const std::array<float, 3> colour = shader.own_colours[face];
      for (std::size_t c = 0; c < 3; ++c) pixel[c] += scale[c] * static_cast<T>(colour[c]);
    });
    queue.finish_all();
  });
  return picture;
}

/// Renders a view once: what render() makes of texture_operator(), without keeping the operator.
///
/// \param texels   [texel_count, 3]
/// \throws as texture_operator(), and ShapeError if texels does not fit the layout
template <std::floating_point T, LightModel Model = Light>
[[nodiscard]] TexturedPicture<T> render_textured(const PaintedMesh& body, const geometry::Camera& camera,
                                                 std::size_t height, std::size_t width, const Model& light,
                                                 const Array<T, 2>& texels,
                                                 std::size_t samples_per_axis = 2) {
  detail::require_layout("render_textured", body);
  const FragmentBands fragments("render_textured", body.mesh, camera, height, width, samples_per_axis);
  return render_textured(body, fragments, light, texels);
}

}  // namespace tapestry::raster
