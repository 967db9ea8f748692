#include <tapestry/io/file_source.hpp>

#include "mesh_inputs.hpp"

namespace tapestry::shell {

// CMake gives both folders as seen from the program's, so that the programs of two clones have the same
// bytes.
std::string bundled_folder() {
  std::error_code error;
  const auto folder = io::path_of(platform::program_path()).parent_path();
  const auto installed = folder / TAPESTRY_INSTALLED_ASSETS;
  const auto status = std::filesystem::status(installed, error);
  // A folder that cannot be examined counts as present: opening a file in it reports the reason.
  const bool is_installed =
      error ? status.type() != std::filesystem::file_type::not_found : is_directory(status);
  return (is_installed ? installed : (folder / TAPESTRY_ASSETS).lexically_normal()).string();
}

}  // namespace tapestry::shell
