#pragma once
#include <map>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/pose.hpp>
#include <tapestry/geometry/shapes.hpp>

namespace tapestry::geometry {
namespace detail {
/// 1 for every face whose label (an index into `known`) is one of `names`.
inline std::vector<std::uint8_t> faces_by_label(const char* operation, const char* kind,
                                                std::size_t face_count,
                                                const std::vector<std::int32_t>& labels,
                                                const std::vector<std::string>& known,
                                                const std::vector<std::string>& names) {
  if (names.empty()) throw DomainError({operation, ": no ", kind, " named"});
  const auto quoted = [](const std::string& name) { return "'" + name + "'"; };
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error(ErrorKind::mismatch, {operation, ": the mesh has no ", kind, " '", name, "'; it has ",
                                        known.empty() ? "none" : listed(known, quoted)});
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

[[nodiscard]] inline Mesh icosahedron() {
  Mesh mesh;
  const double g = (1 + std::sqrt(5.0)) / 2;  // corners of three golden rectangles
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const auto& [one, golden] : {std::pair{-1.0, -g}, {1.0, -g}, {-1.0, g}, {1.0, g}}) {
      Vector3 corner{};
      corner[axis] = one;
      corner[(axis + 1) % 3] = golden;
      mesh.positions.push_back(normalised(corner));
    }
  const auto corner = [&](std::int32_t i) { return mesh.positions[static_cast<std::size_t>(i)]; };
  const auto are_neighbours = [&](std::int32_t i, std::int32_t j) {
    return dot(corner(i), corner(j)) > 0.4;  // 1/√5; it is −1/√5 or −1 of the others
  };
  for (std::int32_t a = 0; a < 12; ++a)
    for (std::int32_t b = a + 1; b < 12; ++b)
      for (std::int32_t c = b + 1; c < 12; ++c) {
        if (!are_neighbours(a, b) || !are_neighbours(b, c) || !are_neighbours(c, a)) continue;
        const bool is_outwards = dot(cross(corner(a), corner(b)), corner(c)) > 0;
        mesh.faces.push_back(is_outwards ? Corners{a, b, c} : Corners{a, c, b});
      }
  return mesh;
}

/// Cuts every face of a sphere of radius 1 into four.
inline void subdivide_sphere(Mesh& mesh) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
  const auto middle = [&](std::int32_t a, std::int32_t b) {
    const auto [at, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<std::int32_t>(mesh.positions.size()));
    if (is_new)
      mesh.positions.push_back(normalised(
          add(mesh.positions[static_cast<std::size_t>(a)], mesh.positions[static_cast<std::size_t>(b)])));
    return at->second;
  };
  std::vector<Corners> faces;
  for (const auto& [a, b, c] : mesh.faces) {
    const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    faces.insert(faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  mesh.faces = std::move(faces);
}

/// Appends `more` to `list`; where only one of the two has entries, the other's are filled in.
/// \param sizes  how many entries each has, if it has some
template <class Entry>
void append_filled(std::vector<Entry>& list, const std::vector<Entry>& more,
                   const std::array<std::size_t, 2>& sizes, const Entry& fill) {
  if (list.empty() && more.empty()) return;
  list.resize(sizes[0], fill);
  list.insert(list.end(), more.begin(), more.end());
  list.resize(sizes[0] + sizes[1], fill);
}

/// The indices of corners moved by `first`; −1, for none, stays.
[[nodiscard]] inline std::vector<Corners> shifted(std::vector<Corners> faces, std::size_t first) {
  for (Corners& face : faces)
    for (std::int32_t& index : face)
      if (index >= 0) index += static_cast<std::int32_t>(first);
  return faces;
}

[[nodiscard]] inline std::vector<std::int32_t> shifted(std::vector<std::int32_t> indices, std::size_t first) {
  for (std::int32_t& index : indices)
    if (index >= 0) index += static_cast<std::int32_t>(first);
  return indices;
}
}  // namespace detail

MeshTopology mesh_topology(const Mesh& mesh) {
  struct HalfEdge {
    std::array<std::size_t, 2> ends;
    std::size_t opposite;
  };
  std::vector<HalfEdge> halves;
  halves.reserve(3 * mesh.faces.size());
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    std::array<std::size_t, 3> corner{};
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = static_cast<std::size_t>(mesh.faces[face][k]);  // negative ones become huge
      if (corner[k] >= mesh.positions.size())
        throw Error(ErrorKind::mismatch, {"mesh_topology: face ", face, " refers to position ",
                                          mesh.faces[face][k], " of ", mesh.positions.size()});
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(corner[k], corner[(k + 1) % 3]);
      if (low != high) halves.push_back({{low, high}, corner[(k + 2) % 3]});
    }
  }
  std::stable_sort(halves.begin(), halves.end(),
                   [](const HalfEdge& a, const HalfEdge& b) { return a.ends < b.ends; });
  MeshTopology topology{mesh.positions.size(), {}, {}};
  for (std::size_t begin = 0, end = 0; begin < halves.size(); begin = end) {
    while (end < halves.size() && halves[end].ends == halves[begin].ends) ++end;
    const auto& ends = halves[begin].ends;
    topology.edges.push_back(ends);
    if (end == begin + 2)
      topology.hinges.push_back({ends[0], ends[1], halves[begin].opposite, halves[begin + 1].opposite});
  }
  return topology;
}

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
    if (id < 1 || static_cast<std::uint64_t>(id) > mesh.faces.size())
      throw Error(ErrorKind::mismatch, {"faces_by_ids: entry ", entry + 1, " is face ", id,
                                        ", expected 1 to ", mesh.faces.size()});
    selected[static_cast<std::size_t>(id) - 1] = 1;
  }
  return selected;
}

Vector3 axis_by_name(const std::string& name) {
  const bool is_negative = name.starts_with('-');
  const std::string letter = name.substr(is_negative ? 1 : 0);
  if (letter != "x" && letter != "y" && letter != "z")
    throw DomainError({"axis_by_name: found ", in_quotes(name), ", expected x, y, z, -x, -y or -z"});
  Vector3 axis{0, 0, 0};
  axis[static_cast<std::size_t>(letter[0] - 'x')] = is_negative ? -1 : 1;
  return axis;
}

Matrix3 world_from_mesh(const MeshAxes& axes) {
  const Vector3 up = axis_by_name(axes.up), forward = axis_by_name(axes.forward);
  if (dot(up, forward) != 0)
    throw DomainError({"world_from_mesh: up is ", axes.up, " and forward ", axes.forward,
                       ", expected two axes at a right angle"});
  return {forward, cross(up, forward), up};
}

Mesh turned_upright(Mesh mesh, const MeshAxes& axes) {
  const Matrix3 rotation = world_from_mesh(axes);
  if (rotation == world_from_mesh({})) return mesh;
  for (auto* const vectors : {&mesh.positions, &mesh.normals})
    for (Vector3& vector : *vectors) vector = multiply(rotation, vector);
  return mesh;
}

Mesh icosphere(std::size_t subdivisions, double radius, const Vector3& centre) {
  if (subdivisions > 8) throw DomainError("icosphere: expected at most 8 subdivisions");
  if (!(radius > 0)) throw DomainError("icosphere: the radius must be positive");
  Mesh mesh = detail::icosahedron();
  for (std::size_t n = 0; n < subdivisions; ++n) detail::subdivide_sphere(mesh);
  for (Vector3& position : mesh.positions) position = add(scale(position, radius), centre);
  return mesh;
}

Camera carla_camera(const CarlaPose& pose, const CarlaOptions& options) {
  constexpr double rad_per_deg = std::numbers::pi / 180;
  const double pitch = pose.camera_rotation_deg[0] * rad_per_deg;
  const double yaw = pose.camera_rotation_deg[1] * rad_per_deg;
  const double vehicle_yaw = pose.vehicle_rotation_deg[1] * rad_per_deg;
  const auto mesh_from_carla = [c = std::cos(vehicle_yaw), s = std::sin(vehicle_yaw)](const Vector3& a) {
    return Vector3{a[0] * c + a[1] * s, -(a[1] * c - a[0] * s), a[2]};
  };
  const Vector3 offset_m = subtract(pose.camera_translation, {0, 0, options.z_shift_m});
  const Vector3 forward{std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch)};
  const Vector3 up{-std::sin(pitch) * std::cos(yaw), -std::sin(pitch) * std::sin(yaw), std::cos(pitch)};
  Camera camera = look_along(mesh_from_carla(scale(offset_m, options.scale)), mesh_from_carla(forward),
                             mesh_from_carla(up));
  camera.tan_half_fov_x = camera.tan_half_fov_y = detail::tan_half("carla_camera", options.fov_rad);
  camera.near = options.near;
  camera.far = options.far;
  return camera;
}

Mesh normalise_mesh(Mesh mesh) {
  const Bounds bounds = bounds_of(mesh.positions);
  const Vector3 extent = subtract(bounds.high, bounds.low);
  const double longest = 2 * bounds.half_length();
  if (!(longest > 0)) return mesh;
  for (Vector3& position : mesh.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = (position[axis] - bounds.low[axis]) / longest * 2 - extent[axis] / longest;
    }
  }
  return mesh;
}

void append(Mesh& mesh, const Mesh& other) {
  assert(&mesh != &other);
  constexpr Corners none{-1, -1, -1};
  const std::size_t positions = mesh.positions.size();
  const std::array faces{mesh.faces.size(), other.faces.size()};
  using detail::append_filled, detail::shifted;
  append_filled(mesh.face_uvs, shifted(other.face_uvs, mesh.uvs.size()), faces, none);
  append_filled(mesh.face_normals, shifted(other.face_normals, mesh.normals.size()), faces, none);
  append_filled(mesh.face_materials, shifted(other.face_materials, mesh.materials.size()), faces, -1);
  append_filled(mesh.face_groups, shifted(other.face_groups, mesh.groups.size()), faces, -1);
  append_filled(mesh.vertex_colours, other.vertex_colours, {positions, other.positions.size()},
                Material{}.colour);
  for (const Corners& face : shifted(other.faces, positions)) mesh.faces.push_back(face);
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.uvs.insert(mesh.uvs.end(), other.uvs.begin(), other.uvs.end());
  mesh.normals.insert(mesh.normals.end(), other.normals.begin(), other.normals.end());
  mesh.materials.insert(mesh.materials.end(), other.materials.begin(), other.materials.end());
  mesh.groups.insert(mesh.groups.end(), other.groups.begin(), other.groups.end());
}
}  // namespace tapestry::geometry
