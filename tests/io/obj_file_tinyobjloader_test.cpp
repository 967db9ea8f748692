#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/tinyobj.hpp>

#include <tiny_obj_loader.h>

#include <cstdlib>
#include <random>
#include <set>
#include <sstream>

#include "../support/catch.hpp"
#include "../support/paths.hpp"
#include "../support/temporary_folder.hpp"

namespace io = tapestry::io;

TEST_CASE("the real car is read as tinyobjloader reads it", "[io][obj]") {
  const std::string path = tapestry::test::in_shared("data/mesh/audi_et_te.obj");
  if (tapestry::test::is_absent(path)) return;
  const auto mesh = io::read_obj(path).mesh;
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  REQUIRE(tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, path.c_str()));
  REQUIRE(mesh.faces.size() == 23145);
  CHECK(mesh.positions.size() * 3 == attributes.vertices.size());
  CHECK(mesh.uvs.size() * 2 == attributes.texcoords.size());
  CHECK(mesh.materials.size() == 6);
  std::size_t differences = 0, face = 0;
  for (const auto& shape : shapes) {
    for (std::size_t corner = 0; corner < shape.mesh.indices.size(); ++corner) {
      const auto& index = shape.mesh.indices[corner];
      const std::size_t at = face + corner / 3;
      differences += mesh.faces[at][corner % 3] != index.vertex_index ? 1 : 0;
      differences += mesh.face_uvs[at][corner % 3] != index.texcoord_index ? 1 : 0;
      differences += mesh.face_normals[at][corner % 3] != index.normal_index ? 1 : 0;
    }
    face += shape.mesh.indices.size() / 3;
  }
  for (std::size_t i = 0; i < attributes.vertices.size(); ++i)
    differences += static_cast<float>(mesh.positions[i / 3][i % 3]) != attributes.vertices[i] ? 1 : 0;
  CHECK(face == mesh.faces.size());
  CHECK(differences == 0);
}

namespace {
/// Reads an OBJ with tinyobjloader.
struct TinyObj {
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;

  explicit TinyObj(const std::string& text, bool triangulate = true,
                   const std::string& materials_text = "newmtl body\nKd 0.25 0.5 0.75\nmap_Kd paint.png\n") {
    std::istringstream obj(text), mtl(materials_text);
    tinyobj::MaterialStreamReader reader(mtl);
    std::string warning, error;
    REQUIRE(tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &obj, &reader, triangulate));
  }
  [[nodiscard]] tapestry::geometry::Mesh mesh() const {
    return io::mesh_of(attributes, shapes, materials, "cars/");
  }
};

const std::string two_shapes =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 0.25\nvt 1 1\nvn 0 0 2\n"
    "o hood\nusemtl body\nf 1/1/1 2/2/1 3/3/1\no roof\nf 1/1 3 4\n";
}  // namespace

TEST_CASE("what tinyobjloader has read becomes the mesh that our reader makes", "[io][obj]") {
  const auto mesh = TinyObj(two_shapes).mesh();
  auto ours = io::parse_obj(two_shapes, "a.obj").mesh;
  CHECK(mesh.positions == ours.positions);
  CHECK(mesh.uvs == ours.uvs);
  CHECK(mesh.normals == ours.normals);
  CHECK(mesh.faces == ours.faces);
  CHECK(mesh.face_uvs == ours.face_uvs);
  CHECK(mesh.face_normals == ours.face_normals);
  CHECK(mesh.groups == ours.groups);
  CHECK(mesh.face_groups == ours.face_groups);
  CHECK(mesh.vertex_colours.empty());
  REQUIRE(mesh.materials.size() == 1);
  CHECK(mesh.materials[0].name == "body");
  CHECK(mesh.materials[0].colour == std::array{0.25F, 0.5F, 0.75F});
  CHECK(mesh.materials[0].texture == "cars/paint.png");
  CHECK(mesh.face_materials == std::vector<std::int32_t>{0, 0});
  CHECK(TinyObj("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 1 1 1\nf 1 2 3\n").mesh().vertex_colours[1] ==
        std::array{0.0F, 1.0F, 0.0F});
}

TEST_CASE("mesh_of refuses polygons, indices outside their lists and no faces", "[io][obj]") {
  const TinyObj square("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no lid\nf 1 2 3 4\n", false);
  CHECK_THROWS_WITH(square.mesh(), contains("face 0 of shape 'lid' has 4 corners, expected 3"));
  TinyObj broken(two_shapes);
  broken.shapes[1].mesh.indices[2].vertex_index = 4;
  CHECK_THROWS_WITH(broken.mesh(), contains("face 0 of shape 'roof' refers to position 4 of 4"));
  broken.shapes[1].mesh.indices[2].vertex_index = -1;
  CHECK_THROWS_WITH(broken.mesh(), contains("refers to position -1 of 4"));
  broken.shapes[1].mesh.indices[2] = {3, -1, 7};
  CHECK_THROWS_WITH(broken.mesh(), contains("refers to texture coordinate 7 of 3"));
  CHECK_THROWS_WITH(TinyObj("v 0 0 0\n").mesh(), contains("mesh_of: no faces"));
}

namespace {
/// A corner of a polygon: position, texture coordinate and normal, -1 for none.
using PolygonCorner = std::array<int, 3>;

struct OddPolygon {
  std::vector<PolygonCorner> corners;
  std::string material;  ///< empty for one that is not defined
  std::string group;
  bool operator==(const OddPolygon&) const = default;
};

/// An OBJ with oddities, and its meaning by the format's definition.
struct OddObj {
  std::string text;
  std::vector<std::array<double, 3>> positions{};
  std::vector<std::array<double, 2>> uvs{};
  std::vector<std::array<double, 3>> normals{};
  std::vector<std::optional<std::array<float, 3>>> colours{};  ///< of the positions
  std::vector<OddPolygon> polygons{};
  std::string reason{};     ///< for refusing it; empty if it must be read
  bool is_for_peer = true;  ///< whether tinyobjloader is known to read it as defined
};

/// Writes OBJ files with oddities, at random.
class OddObjWriter {
 public:
  explicit OddObjWriter(std::uint64_t seed) : random_(seed) {}

  OddObj write() {
    odd_ = {};
    const std::size_t faults = one_in(4) ? 1 : 0;
    has_uvs_ = !one_in(4);
    has_normals_ = !one_in(3);
    add_lists();
    add("mtllib " + std::string(one_in(8) ? "absent.mtl" : "a.mtl"));
    is_defined_ = !lines_.back().ends_with("absent.mtl");
    for (std::size_t count = 1 + below(4), i = 0; i < count; ++i) {
      if (one_in(3)) change_group();
      if (one_in(3)) change_material();
      if (one_in(6)) add_harmless();
      add_face();
    }
    for (std::size_t i = 0; i < faults; ++i) add_fault();
    finish();
    return std::move(odd_);
  }

 private:
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
  bool one_in(std::size_t count) { return below(count) == 0; }
  std::string one_of(const std::vector<std::string>& texts) { return texts[below(texts.size())]; }
  void add(const std::string& line) { lines_.push_back(line); }

  /// An exact multiple of 1/8 in one of many spellings.
  std::string number(double& value) {
    const int eighths = static_cast<int>(below(81)) - 40;
    value = eighths / 8.0;
    std::string digits = std::to_string(std::abs(eighths) / 8);
    const std::string fraction = std::to_string(std::abs(eighths) % 8 * 125);
    digits += "." + std::string(3 - fraction.size(), '0') + fraction;
    if (digits[0] == '0' && one_in(3)) digits.erase(0, 1);
    if (one_in(4)) digits += one_of({"e0", "E+0", "00", "e-0"});
    return (eighths < 0 ? "-" : one_in(6) ? "+" : "") + digits;
  }

  template <std::size_t N>
  std::string numbers(const std::string& keyword, std::array<double, N>& values) {
    std::string line = one_in(10) ? " \t" + keyword : keyword;
    for (double& value : values) line += one_of({" ", " ", "  ", "\t"}) + number(value);
    return line;
  }

  /// Text that may follow the numbers of a record.
  std::string tail() { return one_in(8) ? one_of({"#c", " # c", " ", "\t", " #"}) : ""; }

  void add_lists() {
    const bool has_colours = one_in(3);
    for (std::size_t i = 0, count = 4 + below(6); i < count; ++i) {
      std::string line = numbers("v", odd_.positions.emplace_back());
      odd_.colours.emplace_back();
      if (has_colours && !one_in(4)) {
        odd_.colours.back() = std::array{0.25F, 0.5F, static_cast<float>(i % 2)};
        line += " .25 0.5 " + std::to_string(i % 2) + (one_in(3) ? " 1" : one_in(3) ? " 1 2 3" : "");
      } else if (one_in(6)) {
        line += one_of({" 1", " 1 1", " 1 x 1", " x"});
      }
      add(line + tail());
    }
    for (std::size_t i = 0; has_uvs_ && i < 5; ++i)
      add(numbers("vt", odd_.uvs.emplace_back()) + (one_in(4) ? one_of({" 0", " 0 0 0", " x"}) : "") +
          tail());
    for (std::size_t i = 0; has_normals_ && i < 4; ++i) {
      auto& normal = odd_.normals.emplace_back();
      std::string line = numbers("vn", normal) + (one_in(4) ? " 1" : "") + tail();
      if (one_in(8)) {
        normal = {};
        line = "vn nan nan nan";
      }
      add(line);
    }
  }

  /// The index as written, from the front or from the back.
  std::string index(std::size_t at, std::size_t count) {
    return one_in(4) ? "-" + std::to_string(count - at) : std::to_string(at + 1);
  }

  [[nodiscard]] bool has_zero_normal() const {
    return std::ranges::find(odd_.normals, std::array<double, 3>{}) != odd_.normals.end();
  }

  void add_face() {
    const bool names_uvs = !one_in(3), names_normals = one_in(2);
    OddPolygon polygon{{}, material_, group_};
    std::string line = "f";
    const std::size_t first = below(odd_.positions.size()), corners = has_zero_normal() ? 3 : 3 + below(2);
    for (std::size_t i = 0; i < corners; ++i) {
      const std::size_t at = (first + i) % odd_.positions.size();
      const std::size_t uv = below(5), normal = below(4);
      polygon.corners.push_back({static_cast<int>(at), names_uvs && has_uvs_ ? static_cast<int>(uv) : -1,
                                 names_normals && has_normals_ ? static_cast<int>(normal) : -1});
      line += " " + index(at, odd_.positions.size());
      if (names_uvs) line += "/" + (has_uvs_ ? index(uv, 5) : std::to_string(uv + 1));
      if (names_normals) line += (names_uvs ? "/" : "//") + (has_normals_ ? index(normal, 4) : "3");
      if (!names_normals && one_in(12)) {
        line += names_uvs ? "/" : "//";
        odd_.is_for_peer = false;  // tinyobj takes the next corner's index for the missing one
      }
    }
    if (one_in(12)) {
      line.insert(line.rfind(' '), " \\\n");
      odd_.is_for_peer = false;  // tinyobj takes the backslash for an index
    }
    const bool is_zero = std::ranges::any_of(polygon.corners, [&](const PolygonCorner& corner) {
      return corner[2] >= 0 && odd_.normals[static_cast<std::size_t>(corner[2])] == std::array<double, 3>{};
    });
    for (PolygonCorner& corner : polygon.corners) corner[2] = is_zero ? -1 : corner[2];
    odd_.polygons.push_back(polygon);
    if (one_in(20)) {
      line[0] = 'F';
      odd_.is_for_peer = false;  // it skips the record
    }
    add(line + (one_in(8) ? one_of({"#c", " ", "\t"}) : ""));
  }

  void change_group() {
    group_ = one_of({"door", "left door", ""});
    add(one_of({"g", "g"}) + (group_.empty() ? " " : " " + group_));
  }

  void change_material() {
    const std::string name = one_of({"body", "glass", "Paint#2", "absent", "two words"});
    material_ = is_defined_ && name != "absent" && name != "two words" ? name : "";
    add("usemtl " + name + (one_in(4) && name == "body" ? " # paint" : ""));
  }

  void add_harmless() {
    add(one_of({"", "  ", "# f 1 2 3", "s 1", "s off", "cstype bezier", "lod 3", "f 1 2", "f 1", "l 1 2",
                "p 1", "mg 1 2", "o", "#"}));
    if (lines_.back() == "o") lines_.back() = "o " + (group_ = "roof");
  }

  void add_fault() {
    const std::vector<std::array<std::string, 2>> faults{{"v 1 2", "does not have its coordinates"},
                                                         {"v 1,5 0 0", "not a finite number"},
                                                         {"v 1.0f 0 0", "not a finite number"},
                                                         {"v 0 nan 0", "not a finite number"},
                                                         {"v 0 0 1e39", "not a finite number"},
                                                         {"vt", "without numbers"},
                                                         {"vt 0 nan", "not a finite number"},
                                                         {"vn 0 1", "three numbers"},
                                                         {"f 1 2 99", "beyond the last"},
                                                         {"f 1 2 0", "index 0"},
                                                         {"f 1.5 2 3", "not a whole number"},
                                                         {"f 1 2 -99", "reaches back"},
                                                         {"f 1 2 99999999999", "not a whole number"},
                                                         {"f 1/1/1/1 2 3", "three indices"},
                                                         {std::string("f 1 2\0 3", 8), "zero byte"}};
    const auto& [line, reason] = faults[below(faults.size())];
    lines_.insert(lines_.begin() + static_cast<std::ptrdiff_t>(below(lines_.size() + 1)), line);
    odd_.reason = reason;
  }

  void finish() {
    if (one_in(20)) {
      odd_.text = "\xEF\xBB\xBF";
      odd_.is_for_peer = false;  // it loses the first record
    }
    const std::string end = one_of({"\n", "\n", "\r\n", "\r"});
    for (std::string& line : lines_) {
      if (const auto at = line.find('\n'); at != std::string::npos) line.replace(at, 1, end);
      odd_.text += line + end;
    }
    lines_.clear();
    group_ = material_ = "";
  }

  std::mt19937_64 random_;
  OddObj odd_;
  std::vector<std::string> lines_;
  std::string group_, material_;
  bool has_uvs_ = true, has_normals_ = true, is_defined_ = true;
};

const std::string odd_materials = "Kd 1 1 1\nnewmtl body\nKd 1 0 0\nnewmtl glass\nnewmtl Paint#2\nKd 0 1 0\n";

/// The polygons of our mesh, which holds polygons of n corners as n - 2 triangles.
std::vector<OddPolygon> polygons_of(const tapestry::geometry::Mesh& mesh,
                                    const std::vector<OddPolygon>& like) {
  std::vector<OddPolygon> polygons;
  std::size_t face = 0;
  for (const OddPolygon& wanted : like) {
    OddPolygon& polygon = polygons.emplace_back();
    std::set<PolygonCorner> corners;
    for (std::size_t i = 0; i + 2 < wanted.corners.size(); ++i, ++face) {
      if (face == mesh.faces.size()) return polygons;
      for (std::size_t k = 0; k < 3; ++k)
        corners.insert({mesh.faces[face][k], mesh.face_uvs[face][k], mesh.face_normals[face][k]});
      const auto material = static_cast<std::size_t>(mesh.face_materials[face]);
      const auto group = static_cast<std::size_t>(mesh.face_groups[face]);
      polygon.material = mesh.face_materials[face] < 0 ? "" : mesh.materials[material].name;
      polygon.group = mesh.face_groups[face] < 0 || mesh.groups[group] == "default" ? "" : mesh.groups[group];
    }
    for (const PolygonCorner& corner : wanted.corners)
      if (corners.contains(corner)) polygon.corners.push_back(corner);
  }
  return polygons;
}

/// The polygons that tinyobjloader has read; indices into lists that are empty, or of normals without
/// length, count as none, and its faces of two corners not at all.
std::vector<OddPolygon> polygons_of(const TinyObj& peer) {
  std::vector<OddPolygon> polygons;
  for (const auto& shape : peer.shapes) {
    std::size_t at = 0;
    for (std::size_t f = 0; f < shape.mesh.num_face_vertices.size(); ++f) {
      const int material = shape.mesh.material_ids[f];
      OddPolygon& polygon = polygons.emplace_back();
      polygon.material = material < 0 ? "" : peer.materials[static_cast<std::size_t>(material)].name;
      polygon.group = shape.name;
      bool has_normals = !peer.attributes.normals.empty();
      for (std::size_t i = 0; i < shape.mesh.num_face_vertices[f]; ++i, ++at) {
        const auto& index = shape.mesh.indices[at];
        polygon.corners.push_back({index.vertex_index,
                                   peer.attributes.texcoords.empty() ? -1 : index.texcoord_index,
                                   index.normal_index});
        for (std::size_t c = 0; has_normals && index.normal_index >= 0 && c < 3; ++c) {
          const auto* const normal =
              &peer.attributes.normals[static_cast<std::size_t>(index.normal_index) * 3];
          has_normals = normal[0] != 0 || normal[1] != 0 || normal[2] != 0;
        }
      }
      for (PolygonCorner& corner : polygon.corners) corner[2] = has_normals ? corner[2] : -1;
    }
  }
  return polygons;
}

/// Materials that no file defines have names in our reader, and none in tinyobjloader.
std::vector<OddPolygon> without_undefined(std::vector<OddPolygon> polygons) {
  for (OddPolygon& polygon : polygons)
    if (polygon.material == "absent" || polygon.material == "two words") polygon.material.clear();
  return polygons;
}
}  // namespace

TEST_CASE("odd OBJ files are read as defined, and as tinyobjloader reads them, or refused for a reason",
          "[io][obj][bad_input]") {
  const tapestry::test::TemporaryFolder folder;
  folder.write("a.mtl", odd_materials);
  std::size_t read = 0, refused = 0, compared = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const OddObj odd = OddObjWriter(seed).write();
    INFO("seed " << seed << "\n" << odd.text);
    if (!odd.reason.empty()) {
      CHECK_THROWS_WITH(io::parse_obj(odd.text, folder.path("a.obj")), contains(odd.reason));
      ++refused;
      continue;
    }
    io::LoadedMesh loaded;
    REQUIRE_NOTHROW(loaded = io::parse_obj(odd.text, folder.path("a.obj")));
    ++read;
    const auto& mesh = loaded.mesh;
    const bool is_defined = odd.text.find("absent.mtl") == std::string::npos;
    CHECK(mesh.positions == odd.positions);
    CHECK(mesh.uvs == odd.uvs);
    auto found = without_undefined(polygons_of(mesh, odd.polygons));
    if (!is_defined)
      for (OddPolygon& polygon : found) polygon.material.clear();
    CHECK(found == odd.polygons);
    for (std::size_t i = 0; i < odd.colours.size(); ++i)
      if (odd.colours[i]) CHECK(mesh.vertex_colours.at(i) == *odd.colours[i]);
    if (!odd.is_for_peer) continue;
    const TinyObj peer(odd.text, false, is_defined ? odd_materials : "");
    ++compared;
    CHECK(polygons_of(peer) == odd.polygons);
    REQUIRE(peer.attributes.vertices.size() == 3 * odd.positions.size());
    for (std::size_t i = 0; i < odd.positions.size() * 3; ++i)
      CHECK(peer.attributes.vertices[i] == static_cast<float>(odd.positions[i / 3][i % 3]));
    for (std::size_t i = 0; i < odd.colours.size() * 3; ++i)
      if (odd.colours[i / 3]) CHECK(peer.attributes.colors[i] == (*odd.colours[i / 3])[i % 3]);
  }
  CHECK(read > 600);
  CHECK(refused > 200);
  CHECK(compared > 300);
}
