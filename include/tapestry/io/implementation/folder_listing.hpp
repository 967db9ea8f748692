#pragma once
#include <algorithm>
#include <cctype>
#include <concepts>
#include <filesystem>
#include <iterator>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <tapestry/core/error.hpp>
#include <tapestry/io/folder_listing.hpp>
#include <vector>

namespace tapestry::io {

bool has_picture_name(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::string_view known[]{".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".pnm"};
  return std::find(std::begin(known), std::end(known), extension) != std::end(known);
}

}  // namespace tapestry::io
