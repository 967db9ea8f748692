#pragma once
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/npz_file.hpp>
#include <vector>

namespace tapestry::shell {

/// The colours that a run ended with, [texel, 3].
/// \throws FileError: mismatch (of another car or layout), malformed (a colour outside 0 to 1)
inline Array<float, 2> read_colours(const std::string& path, std::size_t texel_count) {
  auto colours = io::NpzFile::read(path).array<float, 2>("colours");
  if (colours.shape(0) != texel_count || colours.shape(1) != 3)
    throw FileError(ErrorKind::mismatch,
                    {path, "", "the texture does not fit the car",
                     io::shape_text(std::vector<std::size_t>{texel_count, 3}),
                     io::shape_text(std::vector<std::size_t>{colours.shape(0), colours.shape(1)})});
  for (std::size_t i = 0; i < colours.size(); ++i)
    if (!(colours.data()[i] >= 0 && colours.data()[i] <= 1))
      throw FileError(ErrorKind::malformed, {path, "", "colour " + std::to_string(i), "a number in 0 to 1",
                                             std::to_string(colours.data()[i])});
  return colours;
}

}  // namespace tapestry::shell
