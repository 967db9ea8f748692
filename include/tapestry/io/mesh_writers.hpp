#pragma once
#include <filesystem>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::io {
/// `name`, followed by as many _ as are needed to differ from all materials of the mesh.
[[nodiscard]] std::string unused_material_name(const geometry::Mesh& mesh, std::string name);

namespace detail {
/// Shortest text that reads back as the same number, in any locale.
template <class Number>
void append_number(std::string& text, Number value);

/// Appends each number behind a blank, and the line's end.
template <class Numbers>
void append_numbers(std::string& text, const Numbers& values) {
  for (const auto value : values) {
    text += ' ';
    append_number(text, value);
  }
  text += '\n';
}
template <std::size_t N>
void append_record(std::string& text, std::string_view keyword, const std::array<double, N>& values) {
  append_numbers(text += keyword, values);
}

inline std::string paint_name(const geometry::Mesh& mesh) { return unused_material_name(mesh, "paint"); }

void require_writable_mesh(const geometry::Mesh& mesh);

/// The body with the atlas that it is written with.
/// \throws ShapeError unless body.painted has an entry a face and the texture fits the atlas; DomainError for
///         an atlas without extent in u
raster::PaintedMesh writable_body(const char* operation, const raster::PaintedMesh& body,
                                  const std::array<std::size_t, 3>& texture);

/// Writes the pictures of unpainted faces as `car-1.png` and so on, by the number of the first material that
/// has them. \param stem  of the written mesh, `car` \param painted  empty: none
/// \returns  their names, one a material, empty for none and for pictures that cannot be read
std::vector<std::string> write_pictures(const std::filesystem::path& stem, const geometry::Mesh& mesh,
                                        const std::vector<std::uint8_t>& painted);

/// The same pictures as PNG, one a material. \param path  for messages
std::vector<std::string> picture_files(const std::string& path, const geometry::Mesh& mesh,
                                       const std::vector<std::uint8_t>& painted);

/// A texture whose texels outside the charts take the colours near them. Viewers filter across the charts'
/// rims, so other colours there would show as seams.
template <std::floating_point T>
Array<T, 3> with_gutters_filled(raster::PaintedMesh body, const Array<T, 3>& texture);

/// Pictures inside a .glb, as PNG.
struct GlbPictures {
  std::string paint;                   ///< of the painted faces; empty for none
  double u_extent = 1;                 ///< of the paint
  std::vector<std::string> materials;  ///< names for the other faces, one a material; empty for none
};

/// The bytes of a .glb, compiled where a program includes implementation.hpp.
/// \param painted whether each face is painted; empty: none
std::string glb_file(const std::string& path, const geometry::Mesh& mesh,
                     const std::vector<std::uint8_t>& painted, const GlbPictures& pictures);
}  // namespace detail

/// Writes a mesh as OBJ with its materials beside it: `car.obj`, `car.mtl`, and the pictures of materials as
/// `car-1.png` and so on. A picture that cannot be read is left out. Faces keep their order.
/// \throws FileError: write, usage (a control character in the file's name or in those of materials and
///         groups); NumericError if a vertex is not finite
void write_obj(const std::string& path, const geometry::Mesh& mesh);

/// Writes a painted mesh: `car.obj`, `car.mtl` and the texture `car.png`, each of them whole or not at all,
/// the OBJ last. Painted faces get a material of their own with the texture; the others keep theirs.
///
/// \param body     written as raster::with_atlas(). The texture spans u in [0, u_extent) of its layout;
///               written u are divided by it, as viewers expect
/// \param texture  RGB in [0, 1], [H, W, 3], row 0 at v = 1, any H and W for an
/// atlas, the charts' own for other kinds of texture, as camouflage::atlas_of() has.
/// Texels that no painted face
///               refers to are written with the colours around them
/// \throws ShapeError unless body.painted has an entry a face and the texture fits the charts; otherwise as
///         write_obj()
template <std::floating_point T>
void write_painted_obj(const std::string& path, const raster::PaintedMesh& body, const Array<T, 3>& texture);

/// Writes a mesh with the colours and pictures of its materials as glTF 2.0 binary (.glb), which viewers open
/// directly. A node turns z up into glTF's y up, and the front from +x to +z. \throws DomainError without
/// faces; NumericError if a vertex is not finite; FileError (write, limit)
void write_glb(const std::string& path, const geometry::Mesh& mesh);

/// Writes a painted mesh as .glb with its texture inside; parameters and errors as write_painted_obj().
template <std::floating_point T>
void write_painted_glb(const std::string& path, const raster::PaintedMesh& body, const Array<T, 3>& texture);
}  // namespace tapestry::io
