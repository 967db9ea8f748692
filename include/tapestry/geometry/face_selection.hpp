#pragma once
#include <cstdint>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::geometry {

/// 1 for every face whose material is one of `names`, else 0; one entry a face.
///
/// \throws DomainError if names is empty
/// \throws Error (mismatch) if the mesh has no material of that name
[[nodiscard]] std::vector<std::uint8_t> faces_by_material(const Mesh& mesh,
                                                          const std::vector<std::string>& names);

/// 1 for every face of one of the named groups, else 0; errors as faces_by_material().
[[nodiscard]] std::vector<std::uint8_t> faces_by_group(const Mesh& mesh,
                                                       const std::vector<std::string>& names);

/// 1 for every listed face, else 0. Ids count from 1, as in the published face lists; repeats are
/// harmless.
///
/// \throws DomainError if the list is empty
/// \throws Error (mismatch) if an id is not 1 … face count
[[nodiscard]] std::vector<std::uint8_t> faces_by_ids(const Mesh& mesh,
                                                     const std::vector<std::int64_t>& one_based_ids);

}  // namespace tapestry::geometry
