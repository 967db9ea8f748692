#include <filesystem>
#include <system_error>

#include "mesh_inputs.hpp"

// Only this file contains the path of the sources, so that ccache finds all others in any folder.
namespace tapestry::shell {

#ifndef TAPESTRY_INSTALLED_ASSETS  // CMake gives it for the folders that it installs to
#define TAPESTRY_INSTALLED_ASSETS "../share/tapestry/assets"
#endif

std::string bundled_folder() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto installed = program.parent_path() / TAPESTRY_INSTALLED_ASSETS;
  if (error) return TAPESTRY_ASSETS;
  const auto status = std::filesystem::status(installed, error);
  if (status.type() == std::filesystem::file_type::not_found) return TAPESTRY_ASSETS;
  // A folder that cannot be examined counts as present: opening a file in it reports the reason.
  return error || std::filesystem::is_directory(status) ? installed.string() : TAPESTRY_ASSETS;
}

}  // namespace tapestry::shell
