#pragma once
#include <tapestry/image/over.hpp>
#include <tapestry/raster/clear_coat.hpp>
#include <tapestry/raster/geometry_picture.hpp>
#include <tapestry/raster/scene.hpp>
#include <tapestry/raster/texture_operator.hpp>

namespace tapestry::shell {
struct PictureSettings {
  std::size_t height = 512;
  std::size_t width = 512;
  std::size_t samples = 4;  ///< along an axis; 0: see automatic_samples_per_axis()
  std::array<double, 3> background{1, 1, 1};
};

struct PaintedScene : raster::PaintedMesh {
  Array<float, 2> texels;  ///< the texture's own texels, without a pyramid
  raster::SmoothLight light;
  std::string lighting = "flat";                        ///< one of lighting_names
  double coat = 0;                                      ///< see raster::ClearCoat; 0: none
  double roughness = 0.1;                               ///< of the coat
  std::optional<raster::OutdoorLight> outdoors{};       ///< for sky and sun, see outdoor_light()
  std::shared_ptr<const raster::GroundShade> ground{};  ///< of the ground below the mesh; null: no ground
};

/// none: colours as they are. flat, smooth: an ambient and a distant light. sky: light from all around that
/// the mesh hides from itself. sun: a distant light with shadows, and the sky.
inline const std::vector<std::string> lighting_names{"none", "flat", "smooth", "sky", "sun"};

inline bool is_outdoors(const std::string& lighting) { return lighting == "sky" || lighting == "sun"; }

inline const std::vector<std::string> mesh_view_names{"colour", "normal",   "uv",      "face",
                                                      "depth",  "position", "coverage"};

/// Sun and sky with the strengths of a scene's light; without a sun the sky has all of it.
inline raster::OutdoorLight outdoor_light(const PaintedScene& scene) {
  constexpr std::size_t shadow_pixels = 2048;
  const bool has_sun = scene.lighting == "sun";
  raster::OutdoorLight light;
  light.sun = has_sun ? scene.light.directional : 0;
  light.direction = scene.light.direction;
  light.sky = raster::uniform_sky(scene.light.ambient + (has_sun ? 0 : scene.light.directional));
  light.occlusion = std::make_shared<const raster::AmbientOcclusion>(raster::ambient_occlusion(scene.mesh));
  if (has_sun)
    light.shadow =
        std::make_shared<const raster::ParallelView>(scene.mesh, scene.light.direction, shadow_pixels);
  return light;
}

namespace detail {
inline Array<float, 3> background_of(const PictureSettings& picture) {
  Array<float, 3> background(Extents<3>{picture.height, picture.width, 3});
  for (std::size_t i = 0; i < background.size(); ++i)
    background.data()[i] = static_cast<float>(picture.background[i % 3]);
  return background;
}

/// A view before it is laid over a background.
struct Layer {
  Array<float, 3> colours;  ///< [H, W, 3], times coverage
  Array<float, 2> coverage;
  image::ColourSpace space = image::ColourSpace::encoded;
};

/// Draws colour_of(fragment), [H, W, 3].
template <class ColourOf>
Layer drawn_fragments(const geometry::Mesh& mesh, const geometry::Camera& camera,
                      const PictureSettings& picture, ColourOf colour_of) {
  const auto buffer = raster::visibility(mesh, camera, picture.height, picture.width, picture.samples);
  Layer layer{zeros<float, 3>({picture.height, picture.width, 3}), raster::coverage_of(buffer)};
  for (const auto& fragment : raster::fragments(buffer, mesh, camera)) {
    const std::array<double, 3> colour = colour_of(fragment);
    for (std::size_t c = 0; c < 3; ++c)
      layer.colours.data()[3 * fragment.pixel + c] += static_cast<float>(fragment.coverage * colour[c]);
  }
  return layer;
}

/// Share of its light that the background keeps below the mesh, [H, W]; empty without a ground.
inline Array<float, 2> kept_light(const PaintedScene& scene, const geometry::Camera& camera,
                                  const PictureSettings& picture) {
  if (!scene.ground) return {};
  return (*scene.ground)(*scene.outdoors, camera, picture.height, picture.width, picture.samples);
}

inline Layer colour_view(const PaintedScene& scene, const geometry::Camera& camera,
                         const PictureSettings& picture) {
  const auto draw = [&](const auto& light) {
    const auto view =
        raster::texture_operator<float>(scene, camera, picture.height, picture.width, light, picture.samples);
    return Layer{raster::render(view, raster::stored_texels(scene.pyramid, scene.texels, scene.space)),
                 view.coverage, scene.space};
  };
  const auto draw_coated = [&]<class Light>(const Light& light) {
    if (scene.coat == 0) return draw(light);
    return draw(raster::ClearCoat<Light>{light, scene.coat, scene.roughness});
  };
  if (scene.lighting == "none") return draw(raster::Unlit{});
  if (scene.outdoors) return draw_coated(*scene.outdoors);
  if (scene.lighting == "smooth") return draw_coated(scene.light);
  return draw_coated(static_cast<const raster::Light&>(scene.light));
}

/// The mean geometry of the mesh's visible part in each pixel; 0 where none is visible.
template <raster::GeometryOutput Output>
Array<float, raster::geometry_rank<Output>> seen_geometry(const geometry::Mesh& mesh,
                                                          const geometry::Camera& camera,
                                                          const PictureSettings& picture) {
  auto seen =
      raster::geometry_picture<Output, float>(mesh, camera, picture.height, picture.width, picture.samples);
  const auto coverage =
      raster::coverage_of(raster::visibility(mesh, camera, picture.height, picture.width, picture.samples));
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (const float share = coverage.data()[i / Output::channel_count]; share > 0) seen.data()[i] /= share;
  return seen;
}

/// Each channel of seen_geometry(), scaled to its range of values. Depths are inverted, so that near points
/// are light.
template <raster::GeometryOutput Output>
Layer stretched_view(const geometry::Mesh& mesh, const geometry::Camera& camera,
                     const PictureSettings& picture) {
  const auto seen = seen_geometry<Output>(mesh, camera, picture);
  const auto coverage =
      raster::coverage_of(raster::visibility(mesh, camera, picture.height, picture.width, picture.samples));
  constexpr std::size_t channels = Output::channel_count;
  auto image = zeros<float, 3>({picture.height, picture.width, 3});
  for (std::size_t c = 0; c < 3; ++c) {
    const auto value = [&](std::size_t pixel) { return seen.data()[channels * pixel + c % channels]; };
    float least = std::numeric_limits<float>::infinity(), greatest = -least;
    for (std::size_t i = 0; i < coverage.size(); ++i) {
      if (coverage.data()[i] == 0) continue;
      least = std::min(least, value(i));
      greatest = std::max(greatest, value(i));
    }
    for (std::size_t i = 0; i < coverage.size(); ++i) {
      if (coverage.data()[i] == 0) continue;
      const float share = greatest > least ? (value(i) - least) / (greatest - least) : 0.5F;
      image.data()[3 * i + c] = coverage.data()[i] * (channels == 1 ? 1 - share : share);
    }
  }
  return {std::move(image), coverage};
}

/// The unit normal of each face on its visible side, −1 … 1 shown as 0 … 1.
inline Layer normal_view(const geometry::Mesh& mesh, const geometry::Camera& camera,
                         const PictureSettings& picture) {
  const geometry::Vector3 eye = geometry::eye_of(camera);
  return drawn_fragments(mesh, camera, picture, [&](const raster::Fragment& fragment) {
    const auto& face = mesh.faces[static_cast<std::size_t>(fragment.face)];
    const geometry::Vector3 normal = geometry::normalised(raster::face_normal(mesh, face));
    const auto to_eye = geometry::subtract(eye, mesh.positions[static_cast<std::size_t>(face[0])]);
    const double half = geometry::dot(normal, to_eye) < 0 ? -0.5 : 0.5;
    return std::array<double, 3>{0.5 + half * normal[0], 0.5 + half * normal[1], 0.5 + half * normal[2]};
  });
}

/// Red and green are u and v, wrapped into the texture, in squares of 1/16 light and dark; grey for faces
/// without uv.
inline Layer uv_view(const geometry::Mesh& mesh, double u_extent, const geometry::Camera& camera,
                     const PictureSettings& picture) {
  return drawn_fragments(mesh, camera, picture, [&](const raster::Fragment& fragment) {
    const auto face = static_cast<std::size_t>(fragment.face);
    std::array<double, 2> uv{0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t index = face < mesh.face_uvs.size() ? mesh.face_uvs[face][k] : -1;
      if (index < 0) return std::array<double, 3>{0.5, 0.5, 0.5};
      const auto& corner = mesh.uvs[static_cast<std::size_t>(index)];
      for (std::size_t axis = 0; axis < 2; ++axis) uv[axis] += fragment.barycentric[k] * corner[axis];
    }
    const double u = raster::detail::wrapped(uv[0], u_extent), v = raster::detail::wrapped(uv[1], 1);
    const bool is_dark = (static_cast<long>(16 * u) + static_cast<long>(16 * v)) % 2 != 0;
    return std::array<double, 3>{u / u_extent, v, is_dark ? 0.25 : 0.75};
  });
}

/// A different colour for every face up to 2²⁴, from the pixel's first sample: multiplying by an odd factor
/// permutes the numbers of 24 bits.
inline Layer face_view(const geometry::Mesh& mesh, const geometry::Camera& camera, PictureSettings picture) {
  picture.samples = 1;
  return drawn_fragments(mesh, camera, picture, [](const raster::Fragment& fragment) {
    const std::uint32_t mixed = (static_cast<std::uint32_t>(fragment.face) + 1) * 0x9E3779B1U;
    std::array<double, 3> colour{};
    for (unsigned c = 0; c < 3; ++c) colour[c] = static_cast<double>((mixed >> (8 * c)) & 0xFFU) / 255;
    return colour;
  });
}

inline Layer layer_of(const std::string& view, const PaintedScene& scene, const geometry::Camera& camera,
                      const PictureSettings& picture) {
  if (view == "normal") return normal_view(scene.mesh, camera, picture);
  if (view == "uv") return uv_view(scene.mesh, scene.layout.u_extent, camera, picture);
  if (view == "face") return face_view(scene.mesh, camera, picture);
  if (view == "depth") return stretched_view<raster::Depth>(scene.mesh, camera, picture);
  if (view == "position") return stretched_view<raster::SurfacePosition>(scene.mesh, camera, picture);
  if (view == "colour") return colour_view(scene, camera, picture);
  return drawn_fragments(scene.mesh, camera, picture, [](const auto&) { return std::array{1.0, 1.0, 1.0}; });
}

inline PictureSettings with_rate(PictureSettings picture, const PaintedScene& scene,
                                 const geometry::Camera& camera) {
  if (picture.samples == 0)
    picture.samples = raster::automatic_samples_per_axis(scene.mesh, camera, picture.height, picture.width);
  return picture;
}
}  // namespace detail

/// One picture of a scene, [H, W, 3] in [0, 1]; `view` is one of mesh_view_names. The coverage has no
/// background.
inline Array<float, 3> mesh_view(const std::string& view, const PaintedScene& scene,
                                 const geometry::Camera& camera, PictureSettings picture) {
  picture = detail::with_rate(picture, scene, camera);
  const auto layer = detail::layer_of(view, scene, camera, picture);
  if (view == "coverage") return layer.colours;
  auto background = detail::background_of(picture);
  if (view == "colour")
    if (const auto kept = detail::kept_light(scene, camera, picture); kept.size() > 0)
      for (std::size_t i = 0; i < background.size(); ++i) {
        float& value = background.data()[i];
        value = image::encoded(image::linearised(value) * kept.data()[i / 3]);
      }
  return image::over(layer.colours, layer.coverage, background, 0, 0, layer.space);
}

/// The same without a background, [H, W, 4]: RGB, and the mesh's coverage as straight opacity. A shadow on
/// the ground is black, as opaque as the encoded light that it takes from white.
inline Array<std::uint8_t, 3> transparent_view(const std::string& view, const PaintedScene& scene,
                                               const geometry::Camera& camera, PictureSettings picture) {
  picture = detail::with_rate(picture, scene, camera);
  const auto layer = detail::layer_of(view, scene, camera, picture);
  const auto kept = view == "colour" ? detail::kept_light(scene, camera, picture) : Array<float, 2>();
  auto image = zeros<float, 3>({picture.height, picture.width, 4});
  for (std::size_t i = 0; i < layer.coverage.size(); ++i) {
    const float share = layer.coverage.data()[i];
    const float shadow = kept.size() > 0 ? 1 - image::encoded(kept.data()[i]) : 0;
    const float opacity = share + (1 - share) * shadow;
    image.data()[4 * i + 3] = opacity;
    for (std::size_t c = 0; c < 3 && share > 0; ++c) {
      const float colour = layer.colours.data()[3 * i + c] / share;
      const bool is_linear = layer.space == image::ColourSpace::linear;
      image.data()[4 * i + c] = (is_linear ? image::encoded(colour) : colour) * share / opacity;
    }
  }
  return image::to_bytes(image);
}

/// Views that show physical quantities, see measured_view().
inline const std::vector<std::string> measured_view_names{"depth", "position", "normal"};

/// Values of a picture, row-major.
struct Measurements {
  std::vector<std::size_t> shape;  ///< [H, W] of a depth, else [H, W, 3]
  std::vector<float> values;
};

/// A view of measured_view_names in physical units: the mean over the mesh's visible part in a pixel; 0
/// where none is visible.
inline Measurements measured_view(const std::string& view, const PaintedScene& scene,
                                  const geometry::Camera& camera, PictureSettings picture) {
  picture = detail::with_rate(picture, scene, camera);
  const auto measured = [](const auto& seen) {
    return Measurements{{seen.shape().begin(), seen.shape().end()}, {seen.begin(), seen.end()}};
  };
  if (view == "depth") return measured(detail::seen_geometry<raster::Depth>(scene.mesh, camera, picture));
  if (view == "position")
    return measured(detail::seen_geometry<raster::SurfacePosition>(scene.mesh, camera, picture));
  return measured(detail::seen_geometry<raster::Normal>(scene.mesh, camera, picture));
}
}  // namespace tapestry::shell
