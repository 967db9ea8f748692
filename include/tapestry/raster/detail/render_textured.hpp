#pragma once
#include <tapestry/raster/detail/fragment_shader.hpp>

namespace tapestry::raster {
/// Colour and coverage of a view.
template <std::floating_point T>
struct TexturedPicture {
  Array<T, 3> colour;                ///< [H, W, 3], lit colour times coverage, row 0 on top
  Array<T, 2> coverage;              ///< [H, W] share of the pixel that shows any face, in [0, 1]
  std::size_t non_finite_faces = 0;  ///< faces left out because a corner is not finite
};

namespace detail {
/// Adds scale · colour to a pixel's three values.
template <std::floating_point T>
void add_scaled(const std::array<T, 3>& scale, const T* colour, T* pixel) {
  for (std::size_t c = 0; c < 3; ++c) pixel[c] += scale[c] * colour[c];
}

/// A queue of lookups that wait until their texels are in the cache: textures are larger than caches.
template <std::floating_point T>
class TexelQueue {
 public:
  explicit TexelQueue(const T* texels) : texels_(texels) {}

  /// Adds scale · Σ weight · texel to a pixel's three values, a few calls later.
  template <class Lighting>
  void add(const FragmentShader<Lighting>& shader, const Fragment& fragment, const std::array<T, 3>& scale,
           T* pixel) {
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

  void finish(const Lookup& lookup) const {
    std::array<T, 3> sum{0, 0, 0};
    for (std::size_t i = 0; i < lookup.tap_count; ++i) {
      const T* const texel = texels_ + 3 * lookup.taps[i].texel;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<T>(lookup.taps[i].weight) * texel[c];
    }
    add_scaled(lookup.scale, sum.data(), lookup.pixel);
  }

  const T* texels_;
  std::size_t count_ = 0;
  std::array<Lookup, 16> lookups_;
};

/// Lookups of a filtered atlas, several at a time. They do not wait: neighbouring pixels read the same
/// levels.
template <class Lighting>
class FilteredQueue {
 public:
  FilteredQueue(const FragmentShader<Lighting>& shader, const float* texels)
      : filter_(*shader.filter), texels_(texels), waiting_(shader) {}

  /// Like TexelQueue::add(), for one pixel and its scale.
  void add(const Fragment& fragment, const std::array<float, 3>& scale, float* pixel) {
    scales_[waiting_.count] = scale;
    pixels_[waiting_.count] = pixel;
    waiting_.add(fragment);
    if (waiting_.is_full()) finish_all();
  }

  void finish_all() {
    AtlasFilter::Colours colours;
    filter_.look_up(waiting_.batch, waiting_.count, texels_, colours);
    for (std::size_t i = 0; i < waiting_.count; ++i) add_scaled(scales_[i], colours[i].data(), pixels_[i]);
    waiting_.count = 0;
  }

 private:
  const AtlasFilter& filter_;
  const float* texels_;
  FilteredFragments<Lighting> waiting_;
  std::array<std::array<float, 3>, LookupBatch::size> scales_;
  std::array<float*, LookupBatch::size> pixels_;
};

/// Draws the fragments of a band; look_up(fragment, scale, pixel) adds the colour of a painted one.
template <std::floating_point T, class Lighting, class LookUp>
void draw_band(const FragmentBands& fragments, std::size_t band, const FragmentShader<Lighting>& shader,
               TexturedPicture<T>& picture, LookUp look_up) {
  fragments.visit_band(band, grain_of(shader.body.layout), [&](const Fragment& fragment) {
    const auto face = static_cast<std::size_t>(fragment.face);
    picture.coverage.data()[fragment.pixel] += static_cast<T>(fragment.coverage);
    T* const pixel = picture.colour.data() + 3 * fragment.pixel;
    if (const float* const shown = shader.photographed(fragment)) {
      for (std::size_t c = 0; c < 3; ++c)
        pixel[c] += static_cast<T>(fragment.coverage * static_cast<double>(shown[c]));
      return;
    }
    if constexpr (ReflectingLighting<Lighting>) {
      const auto reflected = shader.lighting.reflected(face, fragment.barycentric);
      for (std::size_t c = 0; c < 3; ++c) pixel[c] += static_cast<T>(fragment.coverage * reflected[c]);
    }
    std::array<T, 3> scale;
    const double factor = fragment.coverage * shader.light_of(fragment);
    for (std::size_t c = 0; c < 3; ++c) scale[c] = static_cast<T>(factor * shader.lighting.light_colour[c]);
    if (shader.body.painted[face] != 0) {
      look_up(fragment, scale, pixel);
      return;
    }
    const std::array<double, 3> colour = shader.own_colour(fragment);
    for (std::size_t c = 0; c < 3; ++c) pixel[c] += scale[c] * static_cast<T>(colour[c]);
  });
}

template <std::floating_point T, class Lighting>
void draw_band(const FragmentBands& fragments, std::size_t band, const FragmentShader<Lighting>& shader,
               const T* texels, TexturedPicture<T>& picture) {
  if constexpr (std::same_as<T, float>) {
    if (shader.filter) {
      FilteredQueue queue(shader, texels);
      draw_band(fragments, band, shader, picture, [&](const auto& fragment, const auto& scale, float* pixel) {
        queue.add(fragment, scale, pixel);
      });
      queue.finish_all();
      return;
    }
  } else if (shader.filter) {
    draw_band(fragments, band, shader, picture, [&](const auto& fragment, const auto& scale, T* pixel) {
      std::array<T, 3> colour{0, 0, 0};
      shader.visit_taps(fragment, [&](const Tap& tap) {
        for (std::size_t c = 0; c < 3; ++c)
          colour[c] += static_cast<T>(tap.weight) * texels[3 * tap.texel + c];
      });
      add_scaled(scale, colour.data(), pixel);
    });
    return;
  }
  TexelQueue<T> queue(texels);
  draw_band(fragments, band, shader, picture, [&](const auto& fragment, const auto& scale, T* pixel) {
    queue.add(shader, fragment, scale, pixel);
  });
  queue.finish_all();
}
}  // namespace detail

/// Renders a view that is drawn, see drawn_view().
///
/// \param body       of the view's mesh
/// \param fragments  of a layout of the same kind as the body's
/// \param texels     [texel_count, 3]
/// \throws as texture_operator(), ShapeError if texels does not fit the layout, and DomainError if the view
///         is of another mesh, of positions that have moved since, or for another kind of texture
template <std::floating_point T, LightModel Model>
[[nodiscard]] TexturedPicture<T> render_textured(const PaintedMesh& body, const FragmentBands& fragments,
                                                 const Model& light, const Array<T, 2>& texels) {
  detail::require_layout("render_textured", body);
  detail::require_view_of("render_textured", body, fragments);
  require_shape("render_textured", "texels", texels, {stored_texel_count(body.layout, body.mesh), 3});
  const auto lighting = prepare(body.mesh, fragments.camera(), light);
  const auto shader = detail::make_shader(body, lighting, fragments, fragments.camera(), fragments.height(),
                                          fragments.width());
  const std::size_t width = fragments.width();
  TexturedPicture<T> picture{Array<T, 3>(Extents<3>{fragments.height(), width, 3}),
                             Array<T, 2>(Extents<2>{fragments.height(), width}),
                             fragments.non_finite_faces()};
  parallel_for(fragments.band_count(), [&](std::size_t band) {
    const auto [first, end] = block_range(band, fragments.height(), fragments.band_rows());
    std::fill_n(picture.colour.data() + 3 * first * width, 3 * (end - first) * width, T(0));
    std::fill_n(picture.coverage.data() + first * width, (end - first) * width, T(0));
    detail::draw_band(fragments, band, shader, texels.data(), picture);
  });
  return picture;
}

/// Renders a view once: as render() of texture_operator(), without keeping the operator.
///
/// \param texels   [texel_count, 3]
/// \throws as texture_operator(), and ShapeError if texels does not fit the layout
template <std::floating_point T, LightModel Model = Light>
[[nodiscard]] TexturedPicture<T> render_textured(const PaintedMesh& body, const geometry::Camera& camera,
                                                 std::size_t height, std::size_t width, const Model& light,
                                                 const Array<T, 2>& texels,
                                                 std::size_t samples_per_axis = 2) {
  const FragmentBands fragments("render_textured", body.mesh, camera, height, width, samples_per_axis);
  return render_textured(body, fragments, light, texels);
}
}  // namespace tapestry::raster
