#include <tapestry/camouflage/paint.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/painted.hpp>

#include "bindings.hpp"

namespace tapestry::python {
namespace {
/// \throws DomainError for a name of no kind
raster::TextureKind kind_by_name(const std::string& name) {
  const auto kind = std::ranges::find(raster::texture_traits, name, &raster::TextureTraits::name);
  if (kind != raster::texture_traits.end()) return kind->kind;
  throw DomainError({"no kind of texture is called ", name, "; expected atlas, cube, vertex or solid"});
}

std::shared_ptr<Mesh> mesh_of(const std::string& path, const std::string& material, const std::string& kind,
                              std::size_t rows, const std::string& filter, const std::string& space,
                              bool normalised) {
  io::LoadedMesh loaded;
  auto mesh = released([&] {
    loaded = io::read_obj(path);
    if (normalised) loaded.mesh = geometry::normalise_mesh(std::move(loaded.mesh));
    const raster::PaintChoice choice{material, kind_by_name(kind), rows,
                                     raster::texture_filter_by_name(filter),
                                     image::colour_space_by_name(space)};
    return std::make_shared<Mesh>(Mesh{raster::painted(std::move(loaded.mesh), choice), normalised});
  });
  warn(loaded.warnings);
  return mesh;
}

/// Corners of a mesh's lists, without a copy.
template <class Number>
py::array_t<Number> rows_of(const std::vector<std::array<Number, 3>>& rows, const py::object& owner) {
  return shown(rows.empty() ? nullptr : rows.front().data(), {rows.size(), 3}, owner);
}

std::vector<std::string> materials_of(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const auto& material : mesh.mesh.materials) names.push_back(material.name);
  return names;
}

template <auto member>
auto shown_rows() {
  return [](const py::object& self) { return rows_of(self.cast<const Mesh&>().mesh.*member, self); };
}
}  // namespace

void add_mesh(py::module_& module) {
  using py::arg;
  py::class_<Mesh, std::shared_ptr<Mesh>>(
      module, "Mesh",
      "The mesh of an OBJ file with a texture over the faces of one material; empty: over all.\n\n"
      "kind: atlas (rows texels high), cube (rows texels an edge), vertex or solid. filter of an atlas: "
      "anisotropic, trilinear or bilinear. space in which it is lit and laid over photographs: linear, as "
      "light, or encoded, as numbers. normalised: to length 2, as frames of poses without cameras see it.")
      .def(py::init(&mesh_of), arg("path"), arg("material") = "", arg("kind") = "atlas", arg("rows") = 64,
           arg("filter") = "anisotropic", arg("space") = "linear", arg("normalised") = false)
      .def_property_readonly("positions", shown_rows<&geometry::Mesh::positions>(),
                             "Corners, [V, 3], right-handed, z up; read-only.")
      .def_property_readonly("faces", shown_rows<&geometry::Mesh::faces>(),
                             "Triangles, [F, 3], of indices into positions; read-only.")
      .def_property_readonly("materials", &materials_of, "Names of the materials.")
      .def_property_readonly("texel_count", &Mesh::texel_count, "Texels T of the texture.")
      .def(
          "own_colours", [](const Mesh& mesh) { return handed_over(camouflage::own_colours<float>(mesh)); },
          "The painted faces' own colours as a texture, [T, 3].")
      .def(
          "atlas",
          [](const Mesh& mesh, const py::object& colours) {
            return handed_over(camouflage::atlas_of<float>(mesh, colours_of<2>("colours", colours)));
          },
          arg("colours"), "A texture [T, 3] as a picture for viewers, [H, W, 3] in [0, 1].");
}
}  // namespace tapestry::python
