#pragma once
#include <cctype>
#include <tapestry/io/jpeg_file.hpp>
#include "../../scenes/photograph.hpp"
#include "formatted.hpp"

namespace tapestry::shell {
/// A photograph to put a car into.
struct Photograph {
  std::string path;
  double fov_deg = 0;  ///< horizontal field of view by its EXIF; 0 where that states none
};

/// The field of view that a JPEG states, horizontal, of the upright picture, degrees; 0 for other files.
inline double stated_fov_deg(const std::string& path) {
  const std::string file = io::read_text_file(path);
  if (!io::is_jpeg(file)) return 0;
  const io::JpegHeader header = io::scan_jpeg(file, path);
  if (header.focal_length_35mm == 0) return 0;
  auto height = static_cast<double>(header.height), width = static_cast<double>(header.width);
  if (header.orientation >= 5) std::swap(height, width);
  return scenes::fov_of_lens_deg(static_cast<double>(header.focal_length_35mm), height, width);
}

/// A sentence on pictures of a folder whose formats are not read; empty if there are none.
inline std::string word_on_unread(const std::string& folder) {
  const auto is_unread = [](const std::filesystem::path& path) {
    std::string ending = path.extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
    constexpr std::array endings{".webp", ".tif", ".tiff", ".gif", ".heic", ".heif", ".avif"};
    return std::ranges::find(endings, ending) != endings.end();
  };
  const auto unread = io::listed_paths(folder, is_unread);
  if (unread.empty()) return {};
  return std::to_string(unread.size()) + " picture(s) such as " + unread.front() +
         " are left out: this format is not read; convert them to PNG or JPEG";
}

/// A word on a picture that is no photograph in colour; empty if nothing shows that. A painting passes.
inline std::string word_on_kind(const Array<std::uint8_t, 3>& picture) {
  std::size_t equal = 0, grey = 0;
  const std::size_t pixels = picture.shape(0) * (picture.shape(1) - 1);
  for (std::size_t y = 0; y < picture.shape(0); ++y)
    for (std::size_t x = 0; x + 1 < picture.shape(1); ++x) {
      const std::uint8_t* const rgb = &picture(y, x, 0);
      equal += std::equal(rgb, rgb + 3, rgb + 3) ? 1U : 0U;
      grey += rgb[0] == rgb[1] && rgb[1] == rgb[2] ? 1U : 0U;
    }
  if (10 * equal > 7 * pixels)
    return formatted("%.0f %% of neighbouring pixels are equal, as in drawings, not in photographs",
                     100 * static_cast<double>(equal) / static_cast<double>(pixels));
  return grey == pixels ? "it has no colour, unlike what detectors mostly see" : "";
}

/// The usable photographs of a folder, sorted by name; none for an empty name.
/// \param require_usable  called in parallel as require_usable(photograph, warnings); throws an Error for a
///                        photograph to be left out
/// \param warnings        receives the reasons to leave photographs out
/// \throws FileError unless at least two are usable
template <class RequireUsable>
std::vector<Photograph> photographs(const std::string& folder, RequireUsable require_usable,
                                    std::vector<std::string>& warnings) {
  if (folder.empty()) return {};
  constexpr std::size_t enough = 10;
  const auto paths = io::listed_paths(folder, io::has_picture_name);
  struct Examined {
    std::optional<Photograph> usable{};
    std::vector<std::string> warnings{};
  };
  std::vector<Examined> all(paths.size());
  parallel_for(paths.size(), [&](std::size_t i) {
    try {
      const Photograph photograph{paths[i], stated_fov_deg(paths[i])};
      require_usable(photograph, all[i].warnings);
      all[i].usable = photograph;
    } catch (const Error& error) {
      all[i].warnings.push_back(std::string(error.what()) + "; the photograph is left out");
    }
  });
  std::vector<Photograph> found;
  std::string example;  // of one left out
  for (const Examined& one : all) {
    if (one.usable) found.push_back(*one.usable);
    if (!one.usable && example.empty()) example = one.warnings.back();
    warnings.insert(warnings.end(), one.warnings.begin(), one.warnings.end());
  }
  const std::size_t left_out = paths.size() - found.size();
  const std::string left =
      left_out == 0 ? std::string() : ", and " + std::to_string(left_out) + " left out, such as " + example;
  const auto unread = word_on_unread(folder);
  if (!unread.empty()) warnings.push_back(unread);
  if (found.size() < 2)
    throw file_mismatch({folder, "", "too few photographs to hold some out",
                         "at least 2 (" + io::picture_endings() + ")",
                         std::to_string(found.size()) + left + (unread.empty() ? "" : "; " + unread)});
  if (found.size() < enough)
    warnings.push_back(folder + ": " + std::to_string(found.size()) +
                       " photographs are few: a paint that hides the car in them may hide it nowhere else; "
                       "10 or more are better");
  return found;
}

/// What names of photographs of one place have in common: the stem up to the digits at its end.
inline std::string place_of(const Photograph& photograph) {
  const std::string stem = io::path_of(photograph.path).stem().string();
  return stem.substr(0, stem.find_last_not_of("0123456789") + 1);
}

/// The photographs of the two parts, to optimise on and held out.
struct PhotographShares {
  std::vector<Photograph> train, test;
  bool are_apart = false;  ///< whether the photographs' names tell places, and the parts share none
};

/// Divides photographs in the proportion of the frames, the last ones being held out. Where a border of two
/// places lies near, it is the parts' border.
/// \param all          sorted by name
/// \param train, test  frames of the parts
inline PhotographShares shares_of(const std::vector<Photograph>& all, std::size_t train, std::size_t test) {
  if (train == 0 || all.empty()) return {{}, all};
  const double share = static_cast<double>(train) / static_cast<double>(train + test);
  const auto count = static_cast<long>(all.size());
  const long wanted = std::clamp<long>(std::lround(share * static_cast<double>(count)), 1, count - 1);
  const auto is_apart = [&](long i) {
    return i > 0 && i < count &&
           place_of(all[static_cast<std::size_t>(i - 1)]) != place_of(all[static_cast<std::size_t>(i)]);
  };
  long border = wanted;
  for (long off = 1; 4 * off <= 3 * std::min(wanted, count - wanted) && !is_apart(border); ++off)
    for (const long i : {wanted - off, wanted + off})
      if (is_apart(i)) border = i;
  const auto middle = all.begin() + border;
  const bool name_places = std::ranges::adjacent_find(all, {}, place_of) != all.end();
  return {{all.begin(), middle}, {middle, all.end()}, name_places && is_apart(border)};
}
}  // namespace tapestry::shell
