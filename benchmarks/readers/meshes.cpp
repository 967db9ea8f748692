// Wavefront's meshes, their materials, and lists of faces.
#include <random>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/text_lists.hpp>

#include "kind.hpp"

namespace tapestry::benchmarks {
namespace {
const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

void read_mesh(const std::string& path) { (void)io::read_obj(path); }
void read_materials(const std::string& path) {
  std::vector<std::string> warnings;
  (void)io::read_mtl(path, warnings);
}
void read_faces(const std::string& path) { (void)io::read_face_list(path, 1); }

const std::string beginning = square + "f 1 2 3\n";

/// One face below a random skyline, as long as a line may be, or several.
std::string skylines(std::size_t bytes) {
  constexpr std::size_t corners = 100000;
  std::mt19937_64 random(1);
  std::string text;
  text.reserve(bytes + 100);
  while (text.size() < bytes) {
    // A corner takes about 17 bytes as a vertex and 8 of its face.
    const std::size_t count = std::min(corners, (bytes - text.size()) / 25 + 3);
    text += std::string("v ") + std::to_string(count) + " -1 0\nv -1 -1 0\n";
    for (std::size_t i = 0; i < count; ++i)
      text +=
          std::string("v ") + std::to_string(i) + " ." + std::to_string(random() % 900000 + 100000) + " 0\n";
    text += "f";  // backwards: from the right end of the base along the skyline to its left one
    for (std::size_t i = 0; i < count; ++i) text += std::string(" -") + std::to_string(i + 1);
    text += std::string(" -") + std::to_string(count + 1) + " -" + std::to_string(count + 2) + "\n";
  }
  return text;
}
}  // namespace

std::vector<Kind> mesh_kinds() {
  return {
      {"obj: vertices", filled(beginning, "v 0 0 0\n"), read_mesh, times_file(40)},
      {"obj: triangles", filled(beginning, "f 1 2 3\n"), read_mesh, times_file(40)},
      // Convex faces of many corners, which become many triangles.
      {"obj: fans", filled(square, std::string("f") + repeated(" 1 2 3", 4096) + "\n"), read_mesh,
       times_file(40)},
      {"obj: concave polygons", skylines, read_mesh, times_file(40)},
      {"obj: groups", filled(beginning, numbered("g ", "\n")), read_mesh, times_file(40)},
      {"obj: materials", filled(beginning, numbered("usemtl ", "\n")), read_mesh, times_file(40)},
      {"obj: material files", filled(beginning, numbered("mtllib ", "\n")), read_mesh, times_file(40)},
      // A long way to a material file that is not there.
      {"obj: long ways",
       filled(beginning, [](std::size_t i) { return numbered("mtllib " + repeated("a/", 250000), "\n")(i); }),
       read_mesh, times_file(40)},
      {"mtl", filled("", numbered("newmtl ", "\n")), read_materials, times_file(24)},
      {"faces", filled("", "1\n"), read_faces, times_file(12)}};
}
}  // namespace tapestry::benchmarks
