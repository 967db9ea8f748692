// Wavefront's meshes, their materials, and lists of faces.
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/text_lists.hpp>

#include "target.hpp"

namespace {
using namespace tapestry;

const std::string materials =
    "# two materials\nnewmtl body\nKd 0.5 0.25 1\nmap_Kd skin.png\nnewmtl glass\nKd 0 0 0\nKd 1 1 1\n";

void read_obj(const std::string& bytes) {
  (void)fuzz::folder().write("a.mtl", materials);
  const auto mesh = io::read_obj(fuzz::folder().write("a.obj", bytes)).mesh;
  for (const auto& face : mesh.faces)
    for (const auto vertex : face)
      if (static_cast<std::size_t>(vertex) >= mesh.positions.size())
        throw std::logic_error("a corner too many");
}

std::vector<std::string> obj_seeds() {
  const std::string square = "mtllib a.mtl\no box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5 1 0.5 0\n";
  return {
      square + "g side\nusemtl body\nf 1 2 3 4\n",
      square +
          "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\ns off\nf 1/1/1 2/2/1 3/3/1\nusemtl glass\nf -4//1 -2//1 -1//1\n",
      "v 0 0 0\r\nv 4 0 0\r\nv 4 4 0\r\nv 1 1 0\r\nv 0 4 0\r\nf 1 2 3 4 5\r\nf 1 \\\n 2 3\n"};
}

void read_mtl(const std::string& bytes) {
  std::vector<std::string> warnings;
  (void)io::parse_mtl(bytes, "a.mtl", warnings);
}

void read_faces(const std::string& bytes) {
  const auto list = io::read_face_list(fuzz::folder().write("faces.txt", bytes), 1000);
  for (const auto id : list.ids)
    if (id < 1 || id > 1000) throw std::logic_error("a face that does not exist");
}

const fuzz::Registered obj({"obj", read_obj, obj_seeds});
const fuzz::Registered mtl({"mtl", read_mtl, [] { return std::vector{materials, std::string()}; }});
const fuzz::Registered faces({"faces", read_faces, [] {
                                return std::vector<std::string>{"1\n2\n1000\n", "3\r\n 3\r\n\r\n4"};
                              }});
}  // namespace
