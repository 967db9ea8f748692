#pragma once
#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <new>
#include <string>
#include <string_view>

namespace tapestry::io::detail {
/// Deflates bytes begin … end − 1 of a text as if all before them had been deflated. Parts one behind the
/// other are one stream, without a header.
///
/// \param is_last  ends the stream; other parts end at a whole byte
/// \param level, memory_level  of zlib
/// \returns  empty for more than zlib takes at once
/// \throws std::bad_alloc
[[nodiscard]] inline std::string deflated_part(std::string_view all, std::size_t begin, std::size_t end,
                                               bool is_last, int level, int memory_level) {
  if (end - begin > std::numeric_limits<uInt>::max()) return {};
  z_stream stream{};
  if (deflateInit2(&stream, level, Z_DEFLATED, -MAX_WBITS, memory_level, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  auto* const bytes = reinterpret_cast<Bytef*>(const_cast<char*>(all.data()));  // zlib reads them alone
  const std::size_t seen = std::min(begin, std::size_t{1} << MAX_WBITS);
  if (seen > 0) deflateSetDictionary(&stream, bytes + begin - seen, static_cast<uInt>(seen));
  constexpr std::size_t end_of_part = 16;  // an empty block, and the rest of a byte
  std::string part(deflateBound(&stream, static_cast<uLong>(end - begin)) + end_of_part, '\0');
  stream.next_in = bytes + begin;
  stream.avail_in = static_cast<uInt>(end - begin);
  stream.next_out = reinterpret_cast<Bytef*>(part.data());
  stream.avail_out = static_cast<uInt>(std::min<std::size_t>(part.size(), std::numeric_limits<uInt>::max()));
  const int status = deflate(&stream, is_last ? Z_FINISH : Z_SYNC_FLUSH);
  const bool is_whole = is_last ? status == Z_STREAM_END : status == Z_OK && stream.avail_out > 0;
  part.resize(is_whole ? stream.total_out : 0);
  deflateEnd(&stream);
  return part;
}
}  // namespace tapestry::io::detail
