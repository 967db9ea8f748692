#pragma once
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <tapestry/core/platform.hpp>

namespace tapestry::test {
/// A folder of its own that vanishes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    const auto start = std::filesystem::temp_directory_path() / "tapestry-";
    const std::string name = start.string() + std::to_string(platform::process_number()) + "-";
    for (int number = 0; folder_.empty() || !std::filesystem::create_directory(folder_); ++number)
      folder_ = name + std::to_string(number);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  [[nodiscard]] const std::string& path() const { return folder_; }
  /// The path of a name, with the system's own separators.
  [[nodiscard]] std::string path(const std::string& name) const {
    return (std::filesystem::path(folder_) / name).make_preferred().string();
  }

  /// Writes a file and returns its path.
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ifstream stream(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  std::string folder_;
};
}  // namespace tapestry::test
