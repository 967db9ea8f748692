#pragma once
#include <tapestry/io/npy.hpp>

namespace tapestry::io {
namespace detail {
std::vector<std::uint8_t> row_major(const std::vector<std::uint8_t>& column_major,
                                    const std::vector<std::size_t>& shape, std::size_t item) {
  std::vector<std::uint8_t> result(column_major.size());
  std::vector<std::size_t> index(shape.size(), 0);
  std::vector<std::size_t> stride(shape.size(), item);
  for (std::size_t axis = 1; axis < shape.size(); ++axis) stride[axis] = stride[axis - 1] * shape[axis - 1];
  for (std::size_t to = 0; to < result.size(); to += item) {
    std::size_t from = 0;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) from += index[axis] * stride[axis];
    std::memcpy(result.data() + to, column_major.data() + from, item);
    for (std::size_t axis = shape.size(); axis-- > 0;) {
      if (++index[axis] < shape[axis]) break;
      index[axis] = 0;
    }
  }
  return result;
}
}  // namespace detail

NpyArray parse_npy(std::string_view file, const std::string& origin) {
  const NpyHeader header = parse_npy_header(file, origin);
  const std::size_t item = item_size(header.type);
  const std::size_t needed = header.element_count * item;
  if (file.size() - header.size != needed)
    throw malformed_file({origin, "@" + std::to_string(header.size),
                          "payload does not have the size of shape " + shape_text(header.shape),
                          std::to_string(needed) + " bytes", std::to_string(file.size() - header.size)});
  NpyArray array{origin, header.shape, header.type, {}};
  array.bytes.resize(needed);
  if (needed > 0) std::memcpy(array.bytes.data(), file.data() + header.size, needed);
  if (item > 1 && header.big_endian == (std::endian::native == std::endian::little))
    for (std::uint8_t* at = array.bytes.data(); at < array.bytes.data() + needed; at += item)
      std::reverse(at, at + item);
  if (header.column_major && header.shape.size() > 1)
    array.bytes = detail::row_major(array.bytes, header.shape, item);
  return array;
}

NpzFile NpzFile::parse(std::string_view bytes, const std::string& path, const ZipLimits& limits) {
  const ZipArchive archive(bytes, path, limits);
  NpzFile file(path);
  for (const auto& member : archive.members()) {
    const std::string_view name = member.name;
    if (!name.ends_with(".npy")) continue;  // not an array; NumPy returns such members as bytes
    file.add(std::string(name.substr(0, name.size() - 4)),
             parse_npy(archive.unpack(member), path + ":" + member.name));
  }
  return file;
}

const NpyArray& NpzFile::get(std::string_view name) const {
  const NpyArray* array = find(name);
  if (array != nullptr) return *array;
  const std::string list = listed(names_);
  throw file_mismatch({path_, "", "member '" + std::string(name) + "' is missing", std::string(name),
                       list.empty() ? "none" : list});
}

const NpyArray* NpzFile::find(std::string_view name) const {
  const auto found = arrays_.find(name);
  return found == arrays_.end() ? nullptr : &found->second;
}

std::string NpzWriter::bytes(bool compress) const {
  std::size_t size = 200;
  for (const auto& [name, content] : members_) size += content.size() + 2 * name.size() + 100;
  ZipWriter archive(compress ? 0 : size);
  for (const auto& [name, content] : members_) archive.add(name, content, compress);
  return archive.bytes();
}
}  // namespace tapestry::io
