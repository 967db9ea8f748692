#pragma once
#include <cstring>
#include <tapestry/io/file_source.hpp>

namespace tapestry::test {
/// Numbers of a file that holds nothing else, in this machine's bytes, as the exports have them.
template <class Element>
std::vector<double> raw_numbers(const std::string& path) {
  const std::string bytes = io::read_text_file(path);
  std::vector<double> all(bytes.size() / sizeof(Element));
  for (std::size_t i = 0; i < all.size(); ++i) {
    Element element{};
    std::memcpy(&element, bytes.data() + i * sizeof(Element), sizeof(Element));
    all[i] = static_cast<double>(element);
  }
  return all;
}
}  // namespace tapestry::test
