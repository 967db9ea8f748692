#pragma once
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/text_lists.hpp>

namespace tapestry::shell {
/// The folder of the bundled files: beside an installed program, else in the sources.
std::string bundled_folder();

/// The bundled files that replace inputs the user leaves out.
struct BundledAssets {
  std::string folder = bundled_folder();

  [[nodiscard]] std::string mesh() const { return folder + "/car_sedan.obj"; }
  [[nodiscard]] std::string frames() const { return folder + "/frames"; }
  [[nodiscard]] std::string cfg() const { return folder + "/detector.cfg"; }
  [[nodiscard]] std::string weights() const { return folder + "/detector.weights"; }
  [[nodiscard]] std::string names() const { return folder + "/detector.names"; }
  [[nodiscard]] std::string segmenter() const { return folder + "/segmenter.onnx"; }
};

/// 1 for every painted face, by material or, if `face_list` names a file, by number.
inline std::vector<std::uint8_t> selected_faces(const std::string& mesh_path, const geometry::Mesh& mesh,
                                                const std::vector<std::string>& materials,
                                                const std::string& face_list,
                                                std::vector<std::string>& warnings) {
  if (!face_list.empty()) {
    const auto list = io::read_face_list(face_list, mesh.faces.size());
    warnings.insert(warnings.end(), list.warnings.begin(), list.warnings.end());
    return geometry::faces_by_ids(mesh, list.ids);
  }
  try {
    return geometry::faces_by_material(mesh, materials);
  } catch (const Error& error) {
    throw FileError(error.kind(), {mesh_path, "", error.what()});
  }
}

/// \throws FileError (mismatch) unless every painted face has the texture coordinates that a picture requires
inline void require_uvs(const std::string& mesh_path, const geometry::Mesh& mesh,
                        const std::vector<std::uint8_t>& painted, const char* option) {
  if (mesh.uvs.empty())
    throw file_mismatch({mesh_path, "", std::string("no texture coordinates, which ") + option + " needs",
                         "vt records", "none"});
  for (std::size_t face = 0; face < painted.size(); ++face) {
    if (painted[face] == 0 || (face < mesh.face_uvs.size() && std::ranges::min(mesh.face_uvs[face]) >= 0))
      continue;
    throw file_mismatch({mesh_path, "",
                         "painted face " + std::to_string(face + 1) +
                             " (the first is 1) has none of the texture coordinates that " + option +
                             " needs",
                         "--material or --faces that leave it out", ""});
  }
}
}  // namespace tapestry::shell
