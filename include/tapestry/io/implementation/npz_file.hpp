#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/name_numbers.hpp>
#include <tapestry/io/npy.hpp>
#include <tapestry/io/npz_file.hpp>
#include <tapestry/io/zip_archive.hpp>
#include <tapestry/io/zip_writer.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {

NpzFile NpzFile::parse(std::string_view bytes, const std::string& path, const ZipLimits& limits) {
  const ZipArchive archive(bytes, path, limits);
  NpzFile file;
  file.path_ = path;
  for (const auto& member : archive.members()) {
    const std::string_view name = member.name;
    if (!name.ends_with(".npy")) continue;  // not an array; NumPy hands such members out as bytes
    file.names_.emplace_back(name.substr(0, name.size() - 4));
    (void)file.numbers_.add(file.names_.back(),
                            [&](std::size_t i) -> std::string_view { return file.names_[i]; });
    file.arrays_.push_back(parse_npy(archive.unpack(member), path + ":" + member.name));
  }
  return file;
}

const NpyArray& NpzFile::get(std::string_view name) const {
  const NpyArray* array = find(name);
  if (array != nullptr) return *array;
  std::string list;
  for (const auto& other : names_) list += (list.empty() ? "" : ", ") + other;
  throw FileError(ErrorKind::mismatch, {.path = path_,
                                        .what = "member '" + std::string(name) + "' is missing",
                                        .expected = std::string(name),
                                        .found = list.empty() ? "no arrays" : list});
}

const NpyArray* NpzFile::find(std::string_view name) const {
  const std::size_t number =
      numbers_.find(name, [&](std::size_t i) -> std::string_view { return names_[i]; });
  return number == NameNumbers::none ? nullptr : &arrays_[number];
}

std::string NpzWriter::bytes(bool compress) const {
  ZipWriter archive;
  for (const auto& [name, content] : members_) archive.add(name, content, compress);
  return archive.bytes();
}

}  // namespace tapestry::io
