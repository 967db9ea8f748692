#pragma once
#include <tapestry/geometry/shapes.hpp>
#include <tapestry/raster/scene.hpp>

namespace tapestry::raster {
GroundShade::GroundShade(const geometry::Mesh& bodies, const Ground& ground)
    : shadow_pixels_(ground.shadow_pixels) {
  const auto bounds = geometry::bounds_of(bodies.positions);
  const double half = ground.reach * 2 * bounds.half_length();
  if (!(half > 0) || !std::isfinite(half) || !std::isfinite(ground.height))
    throw DomainError("ground shade: expected bodies with an extent, a reach above 0 and a finite height");
  if (ground.cells < 2 || ground.cells > 1024)
    throw DomainError({"ground shade: cells is ", ground.cells, ", expected 2 to 1024"});
  ground_ = geometry::plane(ground.cells, ground.cells, half);
  const auto middle = bounds.middle();
  for (auto& position : ground_.positions)
    position = {position[0] + middle[0], position[1] + middle[1], ground.height};
  whole_ = ground_;
  geometry::append(whole_, bodies);
  occlusion_ = std::make_shared<const AmbientOcclusion>(
      ambient_occlusion(whole_, ground.directions, std::min<std::size_t>(ground.shadow_pixels, 512)));
}

Array<float, 2> GroundShade::operator()(const OutdoorLight& light, const geometry::Camera& camera,
                                        std::size_t height, std::size_t width,
                                        std::size_t samples_per_axis) const {
  OutdoorLight shaded = light;
  shaded.occlusion = occlusion_;
  shaded.shadow = nullptr;
  const auto towards = geometry::normalised(light.direction);
  if (light.sun > 0 && towards[2] > 0)
    shaded.shadow = std::make_shared<const ParallelView>(whole_, towards, shadow_pixels_);
  const auto lighting = prepare(whole_, camera, shaded);
  const double open =
      light.sun * std::max(0.0, towards[2]) + std::max(0.0, dot(sky_transfer({0, 0, 1}), light.sky));
  auto kept = filled<float, 2>({height, width}, 1.0F);
  const FragmentBands bands("ground shade", ground_, camera, height, width, samples_per_axis);
  if (!(open > 0)) return kept;
  parallel_for(bands.band_count(), [&](std::size_t band) {
    bands.visit_band(band, FragmentGrain::face, [&](const Fragment& fragment) {
      const auto face = static_cast<std::size_t>(fragment.face);
      if (lighting.faces[face].side != 0) return;  // seen from below
      const double share = lighting.at(face, fragment.barycentric) / open;
      kept.data()[fragment.pixel] += static_cast<float>(fragment.coverage * (std::min(1.0, share) - 1));
    });
  });
  return kept;
}
}  // namespace tapestry::raster
