#include "vehicle.hpp"

#include "dark_parts.hpp"

namespace tapestry::scenes {
Vehicle stand_on_ground(geometry::Mesh mesh, std::vector<std::uint8_t> painted, double length,
                        double least_m) {
  std::vector<Point> corners;  // the mesh may have positions that no face uses
  for (const geometry::Corners& face : mesh.faces)
    for (const std::int32_t corner : face)
      corners.push_back(mesh.positions[static_cast<std::size_t>(corner)]);
  const auto [low, high] = geometry::bounds_of(corners);
  const double longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  Vehicle vehicle;
  vehicle.metres_per_unit = length > 0 ? length / longest : 1;
  const double metres = longest * vehicle.metres_per_unit;
  if (!(longest > 0 && metres >= least_m && metres <= 20))
    throw DomainError("the mesh is " + std::to_string(longest > 0 ? metres : 0) + " m long, expected " +
                      (least_m == 1 ? "1" : std::to_string(least_m)) + " to 20; --length sets its metres");
  vehicle.origin = {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]};
  for (Point& position : mesh.positions)
    position = geometry::scale(geometry::subtract(position, vehicle.origin), vehicle.metres_per_unit);
  vehicle.mesh = with_dark_parts(std::move(mesh), painted);
  vehicle.painted = std::move(painted);
  return vehicle;
}

void add_texture(Vehicle& vehicle, const Array<std::uint8_t, 3>& picture,
                 const std::vector<std::uint8_t>& faces) {
  if (!vehicle.pictures) vehicle.pictures = std::make_shared<raster::MeshPictures>();
  raster::add_picture(*vehicle.pictures, vehicle.mesh, picture, faces, raster::TextureFilter::anisotropic,
                      image::ColourSpace::encoded);
}

geometry::Camera camera_of_mesh(const Vehicle& vehicle, geometry::Camera camera) {
  const Point moved = geometry::multiply(camera.rotation, vehicle.origin);
  camera.translation =
      geometry::subtract(geometry::scale(camera.translation, 1 / vehicle.metres_per_unit), moved);
  camera.near /= vehicle.metres_per_unit;
  camera.far /= vehicle.metres_per_unit;
  return camera;
}
}  // namespace tapestry::scenes
