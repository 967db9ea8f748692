// Differentiates a renderer: finds the colours of a painted square from a picture of it.
#include <cstdio>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/raster/texture_operator.hpp>

using tapestry::Array, tapestry::ArrayVariable, tapestry::Variable;
namespace raster = tapestry::raster;

namespace {
tapestry::geometry::Mesh square_mesh() {
  tapestry::geometry::Mesh mesh;
  mesh.positions = {{0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.faces = mesh.face_uvs = {{0, 1, 2}, {0, 2, 3}};
  mesh.face_normals = {{-1, -1, -1}, {-1, -1, -1}};
  mesh.face_groups = mesh.face_materials = {-1, -1};
  return mesh;
}
}  // namespace

int main() {
  const auto mesh = square_mesh();
  const auto camera = tapestry::geometry::orbit_camera(0.5, 0.3, 4, {0, 0, 0}, 0.9);
  const auto layout = raster::atlas_layout(2, 2);
  const raster::Light light{0.4, 0.6, {1, 0.3, 0.5}, {1, 1, 1}};
  const auto view = raster::texture_operator<double>({mesh, {1, 1}, layout}, camera, 32, 32, light);

  const Array<double, 2> painted = {{0.9, 0.1, 0.1}, {0.2, 0.7, 0.3}, {0.1, 0.3, 0.8}, {0.6, 0.6, 0.2}};
  const Array<double, 3> seen = raster::render(view, painted);
  Array<double, 2> texels = tapestry::filled<double, 2>({4, 3}, 0.5);
  double error = 0;
  for (int step = 0; step < 300; ++step) {
    tapestry::Tape<double> tape;
    const auto scope = tape.activate();
    const auto paint = tape.input(texels);
    const Variable<double> loss = sum(square(raster::render(view, paint) - seen));
    tape.reverse(loss);
    texels -= 0.004 * paint.adjoint();
    error = loss.value();
  }
  std::printf("squared error of the picture %s\n", error < 1e-8 ? "below 1e-8" : "not below 1e-8");
  for (std::size_t i = 0; i < 4; ++i)
    std::printf("texel %zu: %.2f %.2f %.2f\n", i, texels(i, 0), texels(i, 1), texels(i, 2));
}
