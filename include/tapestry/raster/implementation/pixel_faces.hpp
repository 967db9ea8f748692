#pragma once
#include <tapestry/raster/deferred.hpp>
#include <tapestry/raster/render_variable.hpp>

namespace tapestry::raster {

PixelFaces pixel_faces(std::shared_ptr<const geometry::Mesh> mesh, const geometry::Camera& camera,
                       std::size_t height, std::size_t width, std::shared_ptr<const MeshEdges> edges) {
  PixelFaces pixels{std::move(mesh), camera, height, width, {}, {}};
  pixels.face = visibility(*pixels.mesh, camera, height, width, 1).face;
  pixels.edges = detail::edges_of("pixel_faces", *pixels.mesh, std::move(edges));
  return pixels;
}

}  // namespace tapestry::raster
