#pragma once
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/io/npy.hpp>

namespace tapestry::camouflage {
namespace detail {
/// \throws FileError (mismatch) with the text `wrong`, unless an array of a file is [count, 3]
inline void require_rows_of_3(const std::string& path, const char* wrong, std::size_t count,
                              const Array<float, 2>& found) {
  if (found.shape(0) == count && found.shape(1) == 3) return;
  throw file_mismatch({path, "", wrong, io::shape_text(std::vector<std::size_t>{count, 3}),
                       io::shape_text(std::vector<std::size_t>{found.shape(0), found.shape(1)})});
}
}  // namespace detail

Paint<float> read_paint(const std::string& path, std::size_t texel_count) {
  const auto file = io::NpzFile::read(path);
  Paint<float> paint{file.array<float, 2>("colours")};
  const auto& colours = paint.colours;
  detail::require_rows_of_3(path, "the texture does not fit the car", texel_count, colours);
  for (std::size_t i = 0; i < colours.size(); ++i)
    if (!(colours.data()[i] >= 0 && colours.data()[i] <= 1))
      throw malformed_file(
          {path, "", "colour " + std::to_string(i), "a number in 0 to 1", std::to_string(colours.data()[i])});
  if (!file.has("painted")) return paint;
  const auto painted = file.array<std::uint8_t, 1>("painted");
  if (painted.size() != texel_count)
    throw file_mismatch({path, "", "painted does not fit the car",
                         io::shape_text(std::vector<std::size_t>{texel_count}),
                         io::shape_text(std::vector<std::size_t>{painted.size()})});
  for (std::size_t i = 0; i < painted.size(); ++i)
    if (painted(i) > 1)
      throw malformed_file(
          {path, "", "painted, texel " + std::to_string(i), "0 or 1", std::to_string(painted(i))});
  if (std::ranges::find(painted.storage(), 0) != painted.storage().end())
    paint.painted.assign(painted.begin(), painted.end());
  return paint;
}

Array<float, 2> read_offsets(const std::string& path, std::size_t position_count) {
  const auto file = io::NpzFile::read(path);
  if (!file.has("offsets")) return {};
  auto offsets = file.array<float, 2>("offsets");
  detail::require_rows_of_3(path, "the shape does not fit the car", position_count, offsets);
  for (std::size_t i = 0; i < offsets.size(); ++i)
    if (!(std::abs(offsets.data()[i]) <= 1))
      throw malformed_file({path, "", "offset " + std::to_string(i), "a number in -1 to 1",
                            std::to_string(offsets.data()[i])});
  return offsets;
}

void write_paint(const std::string& path, const Array<float, 2>& parameter, const Paint<float>& paint,
                 const Array<float, 2>& offsets, const std::string& layout) {
  require_sound("write_paint", paint);
  Array<std::uint8_t, 1> painted = filled<std::uint8_t, 1>({paint.colours.shape(0)}, 1);
  std::copy(paint.painted.begin(), paint.painted.end(), painted.begin());
  io::NpzWriter file;
  file.add("parameter", parameter);
  file.add("colours", paint.colours);
  file.add("painted", painted);
  if (offsets.size() > 0) file.add("offsets", offsets);
  if (!layout.empty()) file.add("layout", std::string_view(layout));
  file.write(path);
}

std::string read_layout(const std::string& path) {
  const auto file = io::NpzFile::read(path);
  if (!file.has("layout")) return {};
  const auto text = file.get("layout").as<std::uint8_t>();
  return {text.begin(), text.end()};
}
}  // namespace tapestry::camouflage
