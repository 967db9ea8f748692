#pragma once
#include <cstring>
#include <fstream>
#include <tapestry/io/file_source.hpp>

namespace tapestry::benchmarks {
/// The numbers of a file that a program of a benchmark wrote, in this machine's form.
template <class T>
[[nodiscard]] std::vector<T> read_numbers(const std::string& path) {
  const auto bytes = io::read_file(path);
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

template <class T>
void write_numbers(const std::string& path, const std::vector<T>& values) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(values.data()),
             static_cast<std::streamsize>(sizeof(T) * values.size()));
  if (!file.flush()) throw FileError(ErrorKind::write, {path, "", "cannot write"});
}
}  // namespace tapestry::benchmarks
