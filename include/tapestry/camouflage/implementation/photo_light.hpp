#pragma once
#include <tapestry/camouflage/photo_light.hpp>
#include <tapestry/raster/fragments.hpp>

namespace tapestry::camouflage {
std::optional<std::array<std::int64_t, 6>> place_of(const io::Frame& frame, const PhotoLight& settings) {
  using Place = std::array<std::int64_t, 6>;
  if (frame.camera || !frame.pose)
    return settings.is_one_place && !frame.light ? std::optional(Place{}) : std::nullopt;
  Place place{};
  for (std::size_t k = 0; k < 3; ++k) {
    place[k] = std::llround(4 * frame.pose->vehicle_translation[k]);  // metres
    place[3 + k] = std::llround(frame.pose->vehicle_rotation_deg[k]);
  }
  return place;
}

std::vector<raster::LitPoint> lit_points(const io::Frame& frame, const raster::PaintedMesh& car,
                                         const PhotoLight& settings) {
  const geometry::Camera camera = io::camera_of(frame);
  const std::size_t height = frame.image.shape(0), width = frame.image.shape(1);
  raster::OutdoorLight any;
  any.occlusion = settings.occlusion;
  const auto lighting = raster::prepare(car.mesh, camera, any);
  const geometry::Vector3 eye = geometry::eye_of(camera);
  const raster::FragmentBands bands("lit_points", car.mesh, camera, height, width, 2);
  std::vector<std::vector<raster::LitPoint>> of_band(bands.band_count());
  parallel_for(of_band.size(), [&](std::size_t band) {
    bands.visit_band(band, raster::FragmentGrain::face, [&](const raster::Fragment& fragment) {
      const auto face = static_cast<std::size_t>(fragment.face);
      if (fragment.coverage < 1 || car.painted[face] == 0) return;
      if (frame.mask && frame.mask->data()[fragment.pixel] == 0) return;
      raster::LitPoint point;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint8_t byte = frame.image.data()[3 * fragment.pixel + c];
        point.colour[c] = byte / 255.0;
        if (car.space == image::ColourSpace::linear) point.colour[c] = image::linearised(point.colour[c]);
      }
      point.face = face;
      point.point = lighting.point(face, fragment.barycentric);
      point.normal = lighting.normal(face, fragment.barycentric);
      point.open = lighting.open_share(face, fragment.barycentric);
      point.to_eye = geometry::normalised(geometry::subtract(eye, point.point));
      of_band[band].push_back(point);
    });
  });
  std::vector<raster::LitPoint> points;
  std::size_t count = 0, seen = 0;
  for (const auto& band : of_band) count += band.size();
  const std::size_t stride =
      std::max<std::size_t>(1, block_count(count, std::max<std::size_t>(1, settings.most_points)));
  for (const auto& band : of_band)
    for (const auto& point : band)
      if (seen++ % stride == 0) points.push_back(point);
  return points;
}

std::optional<raster::EstimatedLight> photo_light(std::span<const io::Frame> frames,
                                                  const raster::PaintedMesh& car,
                                                  const PhotoLight& settings) {
  PhotoLight each = settings;
  each.most_points = std::max<std::size_t>(1, settings.most_points / std::max<std::size_t>(1, frames.size()));
  std::vector<raster::LitPoint> points;
  for (std::size_t view = 0; view < frames.size(); ++view)
    for (raster::LitPoint& point : lit_points(frames[view], car, each)) {
      point.view = view;
      points.push_back(point);
    }
  const auto is_bound = [](const raster::LitPoint& point) {
    return *std::min_element(point.colour.begin(), point.colour.end()) >= 1;
  };
  if (std::all_of(points.begin(), points.end(), is_bound)) return std::nullopt;
  auto estimate = raster::estimated_light(car.mesh, points, settings.paint, settings.shadow_pixels);
  estimate.light.occlusion = settings.occlusion;
  return estimate;
}
}  // namespace tapestry::camouflage
