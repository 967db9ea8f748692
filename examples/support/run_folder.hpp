#pragma once
#include <sys/resource.h>

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <system_error>
#include <tapestry/core/atomic_file.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/file_source.hpp>
#include <tapestry/io/run_lock.hpp>
#include <tapestry/io/sha256.hpp>
#include <tapestry/version.hpp>
#include <vector>

namespace tapestry::examples {

using Json = nlohmann::ordered_json;

inline void write_text(const std::string& path, const std::string& text) {
  write_file_atomically(path, text);
}

/// Creates a folder and makes sure that files can be written into it, before hours are spent.
inline void make_writable_folder(const std::string& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure || !std::filesystem::is_directory(folder))
    throw FileError(
        ErrorKind::write,
        {folder, "", "cannot create the folder" + (failure ? ": " + failure.message() : std::string())});
  const std::string probe = folder + "/.probe";
  write_text(probe, "tapestry\n");
  std::filesystem::remove(probe, failure);
}

/// The first of `base`-001, `base`-002, … that does not exist.
inline std::string next_free_folder(const std::string& base) {
  for (int number = 1;; ++number) {
    char suffix[16];
    std::snprintf(suffix, sizeof suffix, "-%03d", number);
    if (!std::filesystem::exists(base + suffix)) return base + suffix;
  }
}

/// Parses a JSON file; errors carry the byte where reading stopped.
inline Json read_json(const std::string& path) {
  const std::string text = read_text_file(path, std::uint64_t(16) << 20U);
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw FileError(ErrorKind::malformed, {path, "@" + std::to_string(error.byte), "not valid JSON"});
  }
}

/// Path and SHA-256 of every input file.
inline Json input_hashes(const std::vector<std::string>& paths) {
  Json inputs = Json::array();
  for (const auto& path : paths) inputs.push_back({{"path", path}, {"sha256", io::sha256_of_file(path)}});
  return inputs;
}

/// Most memory the process has held so far, MiB.
inline double peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// The words of a command line, each quoted for a shell where it needs it.
inline std::string shell_words(int argc, char** argv) {
  std::string line;
  for (int i = 0; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = !word.empty() && word.find_first_not_of(
                                            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                            "0123456789_-./=,:+@") == std::string::npos;
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += (line.empty() ? "" : " ") + (plain ? word : quoted + "'");
  }
  return line;
}

}  // namespace tapestry::examples
