#include <tapestry/io/obj_file.hpp>

#include <clocale>

#include "../support/bad_file.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Corners;

namespace {
const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

io::LoadedMesh parse(const std::string& text) { return io::parse_obj(text, "a.obj"); }
}  // namespace

TEST_CASE("an OBJ is read by hand", "[io][obj]") {
  const auto loaded = parse(
      "# a comment\nv 0 0 0\nv 1.5 0 0 1\nv 0 1e1 0 .5 .5 .5\nv +0.25 1 -1\nvt 0.5\nvt .25 2 0\nvn 0 0 2\n"
      "g left door\nusemtl body paint\nf 1/1/1 2/-1/1 3/1/1\ns off\ng\nf -3 3 4 # end\n");
  const auto& mesh = loaded.mesh;
  CHECK(mesh.positions ==
        std::vector<std::array<double, 3>>{{0, 0, 0}, {1.5, 0, 0}, {0, 10, 0}, {0.25, 1, -1}});
  CHECK(mesh.uvs == std::vector<std::array<double, 2>>{{0.5, 0}, {0.25, 2}});
  CHECK(mesh.normals == std::vector<std::array<double, 3>>{{0, 0, 1}});
  CHECK(mesh.faces == std::vector<Corners>{{0, 1, 2}, {1, 2, 3}});
  CHECK(mesh.face_uvs == std::vector<Corners>{{0, 1, 0}, {-1, -1, -1}});
  CHECK(mesh.face_normals == std::vector<Corners>{{0, 0, 0}, {-1, -1, -1}});
  CHECK(mesh.groups == std::vector<std::string>{"left door", "default"});
  CHECK(mesh.face_groups == std::vector<std::int32_t>{0, 1});
  REQUIRE(mesh.materials.size() == 1);
  CHECK(mesh.materials[0].name == "body paint");
  CHECK(mesh.face_materials == std::vector<std::int32_t>{0, 0});
  CHECK(mesh.vertex_colours.at(2) == std::array<float, 3>{0.5F, 0.5F, 0.5F});
  CHECK(loaded.without_uv_count == 1);  // O22
  CHECK(loaded.highest == std::array<double, 3>{1.5, 10, 0});
  CHECK(loaded.lowest == std::array<double, 3>{0, 0, -1});
}

TEST_CASE("harmless oddities of OBJ files are accepted", "[io][obj]") {
  struct Row {
    const char* id;
    std::string text;
    std::size_t faces;
  };
  const Row rows[] = {
      {"O07", triangle + "f -3 -2 -1", 1},
      {"O10", "f 1 2 3\n" + triangle, 1},
      {"O12", triangle + "f 1 1 1\nf 1 2 3\n", 2},
      {"O13 concave", triangle + "v .1 .1 0\nf 1 2 4 3\n", 2},
      {"O16", "\xEF\xBB\xBF" + triangle + "f 1 2 3", 1},
      {"O17", "v 0 0 0\r\nv\t1 0 0  \r\n  v 0 1 0\r\n\r\nf 1 2 3 \t", 1},
      {"O23", triangle + "vt -3 1.5\nf 1/1 2/1 3/1", 1},
      {"O27", triangle + "usemtl Lack größe 2\nf 1 2 3", 1},
      {"O32", triangle + "f 1 2 3\nf 1 2 3\nf 3 2 1", 3},
      {"O18", triangle + "f 1 \\\n2\\\r\n 3\n# C:\\\nf 3 2 1", 2},
      {"mixed kinds", triangle + "vt 0 0\nvn 0 0 1\nf 1//1 2//1 3\nf 1/1 2 3/1", 2},
      {"no normals", triangle + "f 1//1 2//2 3//1\nf 1 2 3", 2},
      {"unnamed material", triangle + "usemtl\nf 1 2 3", 1},
      {"underflow", triangle + "v 1e-400 0 0\nf 1 2 3", 1},
      {"O05 no uv", triangle + "f 1/1 2/2 3/3", 1},
      {"O08 no normals", triangle + "f 1//-1 2//-1 3//-1", 1},
      {"O11", triangle + "f 1\nf\nf 1 2\nf 1 2 3", 1},
      {"O14 eight", triangle + "v 1 2 3 4 5 6 7 8\nf 1 2 3", 1},
      {"O14 five", triangle + "v 1 2 3 4 5\nf 1 2 3", 1},
      {"O17 CR", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r", 1},
      {"O21 slash", triangle + "vt 0 0\nf 1/1 2/ 3", 1},
      {"O21 slashes", triangle + "vt 0 0\nvn 0 0 1\nf 1/1/ 2/1/ 3/1/\nf 1// 2// 3//", 2},
      {"O36 glued comment", triangle + "vt 0 0#u\nf 1 2 3#4", 1},
      {"O36 words", triangle + "vt 0 0 x\nvn 0 0 1 1\nvn nan nan nan\nf 1 2 3", 1},
      {"O36 case", "V 0 0 0\nV 1 0 0\nv 0 1 0\nF 1 2 3\nUseMtl a", 1},
      {"O36 mtllib", triangle + "mtllib\nf 1 2 3", 1},
  };
  for (const Row& row : rows) {
    INFO(row.id);
    CHECK(parse(row.text).mesh.faces.size() == row.faces);
  }
  CHECK(parse(rows[2].text).degenerate_count == 1);
  CHECK(parse(rows[3].text).polygon_count == 1);
  std::string polygon = triangle + "f";
  for (int corner = 0; corner < 5000; ++corner) polygon += " " + std::to_string(corner % 3 + 1);
  CHECK(parse(polygon).mesh.faces.size() == 4998);  // O13
}

TEST_CASE("what a face has at some corners only, or the file not at all, counts as absent, with a word",
          "[io][obj]") {
  const auto mixed = parse(triangle + "vt 0 0\nvn 0 0 1\nf 1//1 2//1 3\nf 1/1 2/1 3\nf 1/1/1 2/1/1 3/1/1\n");
  CHECK(mixed.mesh.face_normals == std::vector<Corners>{{-1, -1, -1}, {-1, -1, -1}, {0, 0, 0}});
  CHECK(mixed.mesh.face_uvs == std::vector<Corners>{{-1, -1, -1}, {-1, -1, -1}, {0, 0, 0}});
  CHECK(mixed.warnings ==
        std::vector<std::string>{
            "a.obj: 1 faces have texture coordinates at some corners only; they count as without",
            "a.obj: 1 faces have normals at some corners only; they count as without"});
  const auto none = parse(triangle + "f 1//1 2//1 3//7\nf 1 2 3\n");
  CHECK(none.mesh.face_normals == std::vector<Corners>{{-1, -1, -1}, {-1, -1, -1}});
  CHECK(none.warnings == std::vector<std::string>{
                             "a.obj:4: normals are named, but there are none (vn); faces count as without"});
}

TEST_CASE("vertex colours are read, and vertices without one are as faces without material", "[io][obj]") {
  CHECK(parse(triangle + "f 1 2 3").mesh.vertex_colours.empty());
  const auto coloured = parse("v 0 0 0\nv 1 0 0 .25 .5 1\nv 0 1 0 1 1 0 .125\nv 1 1 0 2\nf 1 2 3\n");
  CHECK(coloured.warnings.empty());
  CHECK(
      coloured.mesh.vertex_colours ==
      std::vector<std::array<float, 3>>{{0.8F, 0.8F, 0.8F}, {0.25F, 0.5F, 1}, {1, 1, 0}, {0.8F, 0.8F, 0.8F}});
  CHECK(parse("v 0 0 0 1 .5 0 .25\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").mesh.vertex_colours[0] ==
        std::array<float, 3>{1, 0.5F, 0});  // the seventh number is alpha
  const auto wide = parse("v 0 0 0 255 0 -1\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  CHECK(wide.mesh.vertex_colours[0] == std::array<float, 3>{1, 0, 0});
  CHECK_THAT(wide.warnings.at(0), contains("outside 0 to 1"));
}

TEST_CASE("a concave polygon covers its own area, with all that belongs to its corners",
          "[io][obj]") {  // O13
  const std::string vertices = "v 0 0 5\nv 3 0 5\nv 3 1 5\nv 1 1 5\nv 1 2 5\nv 3 2 5\nv 3 3 5\nv 0 3 5\n";
  std::string attributes, face = "f";
  for (int i = 1; i <= 8; ++i) {
    attributes += "vt 0." + std::to_string(i) + " 0\nvn 0 0 1\n";
    face += " " + std::to_string(i) + "/" + std::to_string(9 - i) + "/" + std::to_string(i);
  }
  const std::string before = "usemtl a\ng c\nf 1 2 3\n", after = "\nusemtl b\nf 3 2 1\n";
  for (const bool vertices_last : {false, true}) {
    CAPTURE(vertices_last);
    const auto loaded = parse(vertices_last ? before + face + after + vertices + attributes
                                            : vertices + attributes + before + face + after);
    const auto& mesh = loaded.mesh;
    REQUIRE(mesh.faces.size() == 8);
    CHECK(loaded.polygon_count == 1);
    CHECK(loaded.crossing_count == 0);
    CHECK(loaded.degenerate_count == 0);
    double area = 0;
    for (std::size_t i = 1; i < 7; ++i) {
      const auto at = [&](std::size_t k) {
        return mesh.positions[static_cast<std::size_t>(mesh.faces[i][k])];
      };
      const double part =
          (at(1)[0] - at(0)[0]) * (at(2)[1] - at(0)[1]) - (at(1)[1] - at(0)[1]) * (at(2)[0] - at(0)[0]);
      CHECK(part > 0);
      area += part / 2;
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(mesh.face_uvs[i][k] == 7 - mesh.faces[i][k]);
        CHECK(mesh.face_normals[i][k] == mesh.faces[i][k]);
      }
    }
    CHECK(area == 7);
    CHECK(mesh.face_materials == std::vector<std::int32_t>{0, 0, 0, 0, 0, 0, 0, 1});
    CHECK(mesh.faces[0] == Corners{0, 1, 2});
    CHECK(mesh.faces[7] == Corners{2, 1, 0});
  }
}

TEST_CASE("a polygon that crosses itself is said to, and one of too much work refused",
          "[io][obj][bad_input]") {
  const auto tie = parse("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3 4\nf 4 3 2 1\n");
  CHECK(tie.crossing_count == 2);
  CHECK(tie.mesh.faces.size() == 5);
  CHECK(tie.warnings ==
        std::vector<std::string>{
            "a.obj: 2 polygons are split into triangles; face lists count the triangles",
            "a.obj: 2 polygons cross themselves; they became fans around their first corners, "
            "the first on line 6"});
  check_refused(ErrorKind::limit, "a.obj:5: concave polygons take too long", [&] {
    (void)io::parse_obj("v 0 0 0\nv 2 2 0\nv 1 .5 0\nv 3 0 0\nf 2 3 4 1\n", "a.obj",
                        {.triangulation_work = 1});
  });
}

TEST_CASE("bad OBJ files are refused with their line", "[io][obj][bad_input]") {
  const auto malformed = ErrorKind::malformed;
  const std::string face = "f 1 2 3\n";
  const auto vertex = [&](const std::string& record) { return triangle + record + "\n" + face; };
  const std::vector<BadFile> rows{
      {"O01 empty", "", malformed, "", "no vertices; expected v records, found 0 bytes"},
      {"O01 text", "hello\nworld\n", malformed, "", "no vertices"},
      {"O01 PNG", "\x89PNG\r\n\x1a\n", malformed, "", "found a PNG image"},
      {"O01 page", "<html></html>", malformed, "", "HTML"},
      {"O02", triangle, malformed, "", "no faces"},
      {"O03 nan", vertex("v nan 0 0"), malformed, "4", "'nan'"},
      {"O03 inf", vertex("v 0 -inf 0"), malformed, "4", "'-inf'"},
      {"O03 1e400", vertex("v 0 0 1e400"), malformed, "4", "'1e400'"},
      {"O03 1e39", vertex("v 0 0 1e39"), malformed, "4", "'1e39'"},
      {"O04", triangle + "f 1 2 4\n" + face, malformed, "4", "expected 1 to 3, found 4"},
      {"O05 uv", triangle + "vt 0 0\nf 1/1 2/2 3/1", malformed, "5", "texture coordinate index beyond"},
      {"O05 normal", triangle + "vn 0 0 1\nf 1//1 2//2 3//1", malformed, "5", "normal index beyond"},
      {"O06", triangle + "f 0 1 2", malformed, "4", "index 0"},
      {"O08", triangle + "f -9 1 2", malformed, "4", "reaches back"},
      {"O08 normals later", triangle + "f 1//-1 2//-1 3//-1\nvn 0 0 1", malformed, "4", "reaches back"},
      {"O09 2^31", triangle + "f 2147483648 1 2", malformed, "4", "whole number"},
      {"O09 -2^31", triangle + "f -2147483648 1 2", malformed, "4", "reaches back"},
      {"O09 wide", triangle + "f 99999999999 1 2", malformed, "4", "whole number"},
      {"O10 absent", "f 1 2 3\nv 0 0 0\nv 1 0 0\n", malformed, "1", "beyond the last"},
      {"O11 two", triangle + "f 1 2", malformed, "4", "too few corners"},
      {"O11 one", triangle + "f 1", malformed, "4", "too few corners"},
      {"O11 none", triangle + "f", malformed, "4", "ends within a face"},
      {"O11 alone", triangle + "f 1 2\n", malformed, "", "no faces"},
      {"O14 two", vertex("v 1 2"), malformed, "4", "found 2 numbers"},
      {"O14 none", vertex("v"), malformed, "4", "found 0 numbers"},
      {"O15 words", vertex("v a b c"), malformed, "4", "'a'"},
      {"O15 comma", vertex("v 1,0 0 0"), malformed, "4", "'1,0'"},
      {"O15 hex", vertex("v 0x10 0 0"), malformed, "4", "'0x10'"},
      {"O15 tail", vertex("v 1.0f 0 0"), malformed, "4", "'1.0f'"},
      {"O15 index", triangle + "f 1.5 2 3", malformed, "4", "whole number"},
      {"O18", triangle + "f 1 2 \\\n", malformed, "", "no faces"},
      {"O18 later line", triangle + "f 1 2 \\\n 3\nf 1 2", malformed, "6", "too few corners"},
      {"O18 zero byte", triangle + std::string("f 1 2 \\\n3\0\n", 11), malformed, "5", "zero byte"},
      {"O18 long",
       triangle + "f" +
           [] {
             std::string text;
             for (int i = 0; i < 600'000; ++i) text += "\\\n1";
             return text;
           }(),
       ErrorKind::limit, "524292", "too long"},
      {"O19", triangle + std::string("f 1 2\0 3", 8), malformed, "4", "zero byte"},
      {"O20", triangle + "# " + std::string(2 << 20, 'x'), ErrorKind::limit, "4", "too long"},
      {"O21", triangle + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/", malformed, "6", "ends within a face"},
      {"O21 no vertex", triangle + "f 1 2 /3", malformed, "4", "vertex index is not a whole number"},
      {"O21 slashes", triangle + "vt 0 0\nf 1/1/1/1 2 3", malformed, "5", "three indices"},
      {"O23", triangle + "vt nan 0\n" + face, malformed, "4", "'nan'"},
      {"O23 none", triangle + "vt\n" + face, malformed, "4", "without numbers"},
      {"normal", triangle + "vn 0 1\n" + face, malformed, "4", "three numbers"},
      {"O28", "v 1 1 1\nv 1 1 1\nv 1 1 1\n" + face, ErrorKind::mismatch, "", "no usable size"},
      {"O28 tiny", "v 0 0 0\nv 1e-30 0 0\nv 0 1e-30 0\n" + face, ErrorKind::mismatch, "", "no usable size"},
      {"O28 huge", "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\n" + face, ErrorKind::mismatch, "", "no usable size"},
  };
  test::check_bad_files(rows, "a.obj", [](const std::string& text) { (void)parse(text); });
  const io::ObjLimits few{.records = 2};
  check_refused(ErrorKind::limit, "a.obj:3: mesh is too large",
                [&] { (void)io::parse_obj(triangle, "a.obj", few); });
  const std::string groups = triangle + "g a\ng b\ng c\ng d\n" + face;
  check_refused(ErrorKind::limit,
                "a.obj:7:", [&] { (void)io::parse_obj(groups, "a.obj", {.records = 3}); });  // O20
}

TEST_CASE("every cut of an OBJ is refused or a shorter mesh", "[io][obj][bad_input]") {
  const std::string whole = triangle + "vt .5 .25\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 3//1 2//1 1//1\n";
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    INFO(length);
    try {
      const auto loaded = parse(whole.substr(0, length));
      CHECK(loaded.mesh.faces.size() <= 2);
      CHECK(loaded.mesh.faces[0] == Corners{0, 1, 2});
    } catch (const FileError& error) {
      CHECK(error.kind() == ErrorKind::malformed);
    }
  }
}

TEST_CASE("material files are found beside the OBJ only", "[io][obj][posix]") {
  const test::TemporaryFolder folder;
  const auto read_with = [&](const std::string& library) {
    return io::read_obj(
        folder.write("a.obj", "mtllib " + library + "\n" + triangle + "usemtl body\nf 1 2 3\n"));
  };
  folder.write("a.mtl", "newmtl body\nKd .1 .2 .3\nnewmtl glass\nKd 1 1 1\n");
  folder.write("b c.mtl", "newmtl body\nKd 1 0 0\n");
  const auto loaded = read_with("a.mtl");
  CHECK(loaded.warnings.empty());
  CHECK(loaded.material_files == std::vector<std::string>{folder.path("a.mtl")});
  CHECK(loaded.mesh.materials.size() == 2);
  CHECK(loaded.mesh.materials[0].colour == std::array<float, 3>{0.1F, 0.2F, 0.3F});
  CHECK(read_with("b c.mtl").mesh.materials[0].colour == std::array<float, 3>{1, 0, 0});
  CHECK(read_with("a.mtl absent.mtl").mesh.materials.size() == 2);
  CHECK(read_with("deep/../a.mtl").mesh.materials.size() == 2);
  std::filesystem::create_directory(folder.path("deep"));
  const std::string below = folder.write("deep/a.obj", "mtllib ../a.mtl\n" + triangle + "f 1 2 3\n");
  CHECK_THAT(io::read_obj(below).warnings.at(0), contains("outside the folder"));              // O25
  CHECK_THAT(read_with(folder.path("a.mtl")).warnings.at(0), contains("outside the folder"));  // O25
  CHECK_THAT(read_with("absent.mtl").warnings.at(0), contains("a.obj:1:"));                    // O24
  CHECK_THAT(read_with("absent.mtl").warnings.at(1), contains("'body' is not defined"));       // O27
  CHECK_THAT(read_with("deep").warnings.at(0), contains("not there"));                         // O24
  CHECK_THAT(read_with(std::string(300, 'n')).warnings.at(0), contains("longer than a path"));
  CHECK(read_with("a.mtl" + std::string(300, ' ') + "a.mtl").mesh.materials.size() == 2);
  std::filesystem::create_symlink("ring.mtl", folder.path("ring.mtl"));
  check_refused(ErrorKind::malformed, "ring.mtl: cannot inspect", [&] { (void)read_with("ring.mtl"); });
  CHECK_THAT(read_with(std::string(5000, '/')).warnings.at(0), contains("longer than a path"));  // O24
  check_refused(ErrorKind::malformed, "folder", [&] { (void)io::read_obj(folder.path()); });     // O01
}

TEST_CASE("oddities of an OBJ become one warning a kind, with the line of the first and their count",
          "[io][obj]") {
  std::string text = triangle + "vn nan nan nan\nusemtl a\nf 1//1 2//1 3//1\n";
  for (int i = 0; i < 20; ++i) text += "usemtl " + std::to_string(i) + "\nf 1 2 3\nf 1 2\n";
  const auto loaded = parse(text);
  CHECK(loaded.mesh.face_normals[0] == Corners{-1, -1, -1});
  CHECK(loaded.mesh.materials.size() == 21);
  CHECK(loaded.warnings ==
        std::vector<std::string>{
            "a.obj:4: normal has no direction; faces with it count as without",
            "a.obj:9: face of fewer than three corners is left out (and 19 more of this kind)",
            "a.obj:5: material 'a' is not defined; it gets a default colour (and 20 more of this kind)"});
}

TEST_CASE("materials may be defined after their use, and what hides a colour or texture is told",
          "[io][obj]") {
  const test::TemporaryFolder folder;
  folder.write("a.mtl", "newmtl body\nKd 1 0 0\nMap_KD x.png\n");
  const auto read = [&](const std::string& faces) {
    return io::read_obj(folder.write("a.obj", triangle + "vt 0 0\n" + faces));
  };
  const auto late = read("usemtl body # paint\nf 1/1 2/1 3/1\nusemtl body\nf 1/1 2/1 3/1\nmtllib a.mtl\n");
  CHECK(late.mesh.materials.at(1).colour == std::array<float, 3>{1, 0, 0});
  CHECK(late.warnings.size() == 1);  // the comment comes before the definition
  const auto commented = read("mtllib a.mtl\nusemtl body # paint\nf 1/1 2/1 3/1\n");
  CHECK(commented.warnings.empty());
  CHECK(commented.mesh.materials.at(0).texture == folder.path("x.png"));
  CHECK(
      read("mtllib a.mtl\nf 1/1 2/1 3/1\n").warnings ==
      std::vector<std::string>{folder.path("a.obj") +
                               ":5: no face uses a material (usemtl) of the file; all get a default colour"});
  CHECK_THAT(read("mtllib a.mtl\nusemtl body\nf 1 2 3\n").warnings.at(0),
             contains("1 faces of a material with a texture (map_Kd) have no texture coordinates"));
}

TEST_CASE("opacity and light of a material are named where they are not drawn", "[io][mtl][bad_input]") {
  const test::TemporaryFolder folder;
  const auto warnings_of = [&](const std::string& records) {
    std::vector<std::string> warnings;
    (void)io::read_mtl(folder.write("a.mtl", "newmtl a\n" + records), warnings);
    return warnings;
  };
  CHECK(warnings_of("d 1\nd -halo 1.0\nTr 0\nKe 0 0 0 # none\nKe\n").empty());
  for (const char* record : {"d .5", "d 0", "d -halo 0.2", "Tr 0.3", "map_d holes.png"})
    CHECK_THAT(warnings_of(record).at(0), contains("a.mtl:2: '") && contains("the material is opaque"));
  for (const char* record : {"Ke 0 0 2", "map_Ke lamps.png"})
    CHECK_THAT(warnings_of(record).at(0), contains("is not drawn") && contains("emits no light"));
  CHECK(warnings_of("d .5\nnewmtl b\nd .7\nnewmtl c\nTr .2\n").size() == 1);  // once for a file
}

TEST_CASE("material files with odd colours are read with a warning", "[io][mtl][bad_input]") {  // O26
  const test::TemporaryFolder folder;
  std::vector<std::string> warnings;
  const auto read = [&](const std::string& text) {
    return io::read_mtl(folder.write("a.mtl", text), warnings);
  };
  for (const char* colour :
       {"nan 0 0", "0 0", "1,0 0 0", "1e999 0 0", "spectral file.rfl", "xyz 1 1 1", ""}) {
    warnings.clear();
    CHECK(read("newmtl a\nKd 1 0 0\nKd " + std::string(colour)).at(0).colour ==
          std::array<float, 3>{1, 0, 0});
    CHECK_THAT(warnings.at(0), contains("a.mtl:3: Kd '" + std::string(colour) + "' is not red"));
  }
  warnings.clear();
  CHECK(read("newmtl a\nKd .5\nnewmtl b\nkD .25#r\n").at(1).colour ==
        std::array<float, 3>{0.25F, 0.25F, 0.25F});
  CHECK(warnings.empty());
  CHECK(read("Kd 1 1 1\nmap_Kd x.png\nnewmtl a\n").at(0).texture.empty());
  CHECK(warnings.size() == 2);
  warnings.clear();
  CHECK(read("newmtl\nKd 1 0 0\n").at(0).name.empty());
  const auto cut = read("\xEF\xBB\xBFnewmtl a b\r\nKd 2 -1 .5\r\nmap_Kd x.png\nd 7\nnewmtl a b\nKd 0 0 0\n");
  REQUIRE(cut.size() == 1);
  CHECK(cut[0].name == "a b");
  CHECK(cut[0].colour == std::array<float, 3>{1, 0, 0.5F});
  CHECK(cut[0].texture == folder.path("x.png"));
  CHECK(warnings.size() == 2);
}

TEST_CASE("textures are found beside their material file or below it", "[io][mtl]") {  // O34
  const test::TemporaryFolder folder;
  std::vector<std::string> warnings;
  const auto texture = [&](const std::string& record) {
    warnings.clear();
    return io::read_mtl(folder.write("a.mtl", "newmtl a\nmap_Kd" + record + "\n"), warnings).at(0).texture;
  };
  CHECK(texture(" red paint.png ") == folder.path("red paint.png"));
  CHECK(texture(" maps\\red.png") == folder.path("maps/red.png"));
  CHECK(texture(" ./deep/../red.png") == folder.path("red.png"));
  CHECK(warnings.empty());
  CHECK(texture(" -s 1 1 1 -o .5 -clamp on -type sphere red.png") == folder.path("red.png"));
  CHECK_THAT(warnings.at(0), contains("option '-s' of a texture is ignored (and 3 more"));
  CHECK(texture(" -red.png") == folder.path("-red.png"));
  for (const char* outside : {" ../red.png", " /red.png", " ..", " deep/../../red.png"}) {
    CHECK(texture(outside).empty());
    CHECK_THAT(warnings.at(0), contains("a.mtl:2:") && contains("outside the folder"));
  }
  for (const char* nothing : {"", " ", " -clamp on", " -clamp", " -s 1 2"}) {
    CHECK(texture(nothing).empty());
    CHECK_THAT(warnings.back(), contains("without a file name"));
  }
}

TEST_CASE("material files are read once, and neither they nor their warnings fill memory",
          "[io][mtl][bad_input]") {
  const test::TemporaryFolder folder;
  std::string again, odd;
  for (int i = 0; i < 500; ++i) again += "newmtl a\nKd 2 0 0\n";
  for (int i = 0; i < 500; ++i) odd += "mtllib " + std::string(i % 2 == 0 ? "" : "./") + "a.mtl\n";
  folder.write("a.mtl", again);
  const std::string path = folder.write("a.obj", odd + triangle + "usemtl a\nf 1 2 3\n");
  const auto loaded = io::read_obj(path);
  CHECK(loaded.warnings.size() == 2);
  REQUIRE(loaded.mesh.materials.size() == 1);
  CHECK(loaded.mesh.materials[0].colour == std::array<float, 3>{1, 0, 0});
  (void)io::read_obj(path, {.material_bytes = again.size()});  // enough, though it is named 500 times
  check_refused(ErrorKind::limit, "a.mtl: file too large",
                [&] { (void)io::read_obj(path, {.material_bytes = again.size() - 1}); });
  std::string many = "newmtl 0\n";
  for (int i = 1; i < 5; ++i) many += "newmtl " + std::to_string(i) + "\n";
  folder.write("a.mtl", many);
  check_refused(ErrorKind::limit, "a.obj:1: mesh is too large; expected at most 4 materials",
                [&] { (void)io::read_obj(path, {.records = 4}); });
}

TEST_CASE("numbers do not depend on the locale", "[io][obj]") {  // O33
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8"}) std::setlocale(LC_ALL, name);
  CHECK(parse("v 0.5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").mesh.positions[0][0] == 0.5);
  std::setlocale(LC_ALL, before.c_str());
}
