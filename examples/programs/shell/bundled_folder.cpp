
#include "mesh_inputs.hpp"
#include "program.hpp"

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

std::string line_of(const Error& error) {
  const std::string message = error.what(), folder = bundled_folder();
  std::error_code failure;
  const bool lacks = message.starts_with(folder) && !std::filesystem::exists(io::path_of(folder), failure);
  const char* const remedy =
      "; this copy of the program has no bundled files beside it: make a link to the program instead, or "
      "give files of your own by options such as --mesh, --frames and --weights";
  return for_terminal(message + (lacks ? remedy : ""));
}
}  // namespace tapestry::shell
