#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/face_selection.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::geometry::detail {

inline std::string quoted_list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
  return text.empty() ? "none" : text;
}

/// 1 for every face whose label (an index into `known`) is one of `names`.
inline std::vector<std::uint8_t> faces_by_label(const char* operation, const char* kind,
                                                std::size_t face_count,
                                                const std::vector<std::int32_t>& labels,
                                                const std::vector<std::string>& known,
                                                const std::vector<std::string>& names) {
  if (names.empty()) throw DomainError(std::string(operation) + ": no " + kind + " named");
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw Error(ErrorKind::mismatch, std::string(operation) + ": the mesh has no " + kind + " '" + name +
                                           "'; it has " + quoted_list(known));
    }
  }
  std::vector<std::uint8_t> selected(face_count, 0);
  for (std::size_t face = 0; face < std::min(face_count, labels.size()); ++face) {
    const std::int32_t label = labels[face];
    if (label < 0 || static_cast<std::size_t>(label) >= known.size()) continue;
    const std::string& name = known[static_cast<std::size_t>(label)];
    selected[face] = std::find(names.begin(), names.end(), name) != names.end() ? 1 : 0;
  }
  return selected;
}

}  // namespace tapestry::geometry::detail

namespace tapestry::geometry {

std::vector<std::uint8_t> faces_by_material(const Mesh& mesh, const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const Material& material : mesh.materials) known.push_back(material.name);
  return detail::faces_by_label("faces_by_material", "material", mesh.faces.size(), mesh.face_materials,
                                known, names);
}

std::vector<std::uint8_t> faces_by_group(const Mesh& mesh, const std::vector<std::string>& names) {
  return detail::faces_by_label("faces_by_group", "group", mesh.faces.size(), mesh.face_groups, mesh.groups,
                                names);
}

std::vector<std::uint8_t> faces_by_ids(const Mesh& mesh, const std::vector<std::int64_t>& one_based_ids) {
  if (one_based_ids.empty()) throw DomainError("faces_by_ids: the list is empty");
  std::vector<std::uint8_t> selected(mesh.faces.size(), 0);
  for (std::size_t entry = 0; entry < one_based_ids.size(); ++entry) {
    const std::int64_t id = one_based_ids[entry];
    if (id < 1 || static_cast<std::uint64_t>(id) > mesh.faces.size()) {
      throw Error(ErrorKind::mismatch, "faces_by_ids: entry " + std::to_string(entry + 1) + " is face " +
                                           std::to_string(id) + ", expected 1 to " +
                                           std::to_string(mesh.faces.size()));
    }
    selected[static_cast<std::size_t>(id) - 1] = 1;
  }
  return selected;
}

}  // namespace tapestry::geometry
