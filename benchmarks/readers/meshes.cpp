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

/// A record repeated behind a square.
std::function<std::string(std::size_t)> repeated(const std::string& record) {
  return [=](std::size_t bytes) {
    return filled(bytes, square + "f 1 2 3\n", [&](std::size_t) { return record; });
  };
}
/// A record with a number that is another each time.
std::function<std::string(std::size_t)> numbered(const std::string& record) {
  return [=](std::size_t bytes) {
    return filled(bytes, square + "f 1 2 3\n",
                  [&](std::size_t i) { return record + std::to_string(i) + "\n"; });
  };
}

/// Convex faces of many corners, which become many triangles.
std::string fans(std::size_t bytes) {
  std::string face = "f";
  for (int i = 0; i < 4096; ++i) face += " 1 2 3";
  return filled(bytes, square, [&](std::size_t) { return face + "\n"; });
}

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

/// A long way to a material file that is not there.
std::string long_ways(std::size_t bytes) {
  std::string way;
  for (int i = 0; i < 250000; ++i) way += "a/";
  return filled(bytes, square + "f 1 2 3\n",
                [&](std::size_t i) { return "mtllib " + way + std::to_string(i) + "\n"; });
}
}  // namespace

std::vector<Kind> mesh_kinds() {
  return {
      {"obj: vertices", repeated("v 0 0 0\n"), read_mesh, times_file(40)},
      {"obj: triangles", repeated("f 1 2 3\n"), read_mesh, times_file(40)},
      {"obj: fans", fans, read_mesh, times_file(40)},
      {"obj: concave polygons", skylines, read_mesh, times_file(40)},
      {"obj: groups", numbered("g "), read_mesh, times_file(40)},
      {"obj: materials", numbered("usemtl "), read_mesh, times_file(40)},
      {"obj: material files", numbered("mtllib "), read_mesh, times_file(40)},
      {"obj: long ways", long_ways, read_mesh, times_file(40)},
      {"mtl",
       [](std::size_t bytes) {
         return filled(bytes, "", [](std::size_t i) { return "newmtl " + std::to_string(i) + "\n"; });
       },
       read_materials, times_file(24)},
      {"faces",
       [](std::size_t bytes) { return filled(bytes, "", [](std::size_t) { return std::string("1\n"); }); },
       read_faces, times_file(12)}};
}

}  // namespace tapestry::benchmarks
