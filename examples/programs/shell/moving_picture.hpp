#pragma once
#include <tapestry/core/parallel.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/image_file.hpp>
#include "pixel_font.hpp"

namespace tapestry::shell {
namespace detail {
/// The last `bytes` bytes of a number, the highest first.
inline std::string number_bytes(std::size_t value, unsigned bytes = 4) {
  std::string text;
  for (unsigned shift = 8 * bytes; shift > 0; shift -= 8)
    text += static_cast<char>(value >> (shift - 8) & 0xFFU);
  return text;
}

/// A chunk of a PNG: length, name and content, checksum.
inline std::string png_chunk(const std::string& words) {
  const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(words.data()), words.size());
  return number_bytes(words.size() - 4) + words + number_bytes(sum);
}

/// Opaque pixels, [H, W, 4], transparent where they are those of the frame before, which cost nothing then. A
/// frame of four channels stays as it is, since it replaces the one before.
inline Bitmap changed_pixels(const Bitmap& now, const Bitmap* before) {
  if (now.shape(2) == 4) return now;
  auto changed = zeros<std::uint8_t, 3>({now.shape(0), now.shape(1), 4});
  for (std::size_t i = 0; i < now.size() / 3; ++i) {
    const std::uint8_t* const pixel = now.data() + 3 * i;
    if (before != nullptr && std::equal(pixel, pixel + 3, before->data() + 3 * i)) continue;
    std::copy_n(pixel, 3, changed.data() + 4 * i);
    changed.data()[4 * i + 3] = 255;
  }
  return changed;
}
}  // namespace detail

/// Bytes of a PNG file that moves without end (APNG). Programs that do not know the chunks acTL, fcTL and
/// fdAT show the first frame. Source: PNG specification, third edition.
///
/// \param path     for messages
/// \param frames   at least one, all [H, W, 3], or all [H, W, 4] with straight opacity
/// \param seconds  that each of them shows, to a thousandth, at most 65
inline std::string moving_png(const std::string& path, const std::vector<Bitmap>& frames, double seconds) {
  using detail::number_bytes, detail::png_chunk;
  std::vector<std::string> pictures(frames.size());  // files of their own
  parallel_for(frames.size(), [&](std::size_t i) {
    require_shape("moving_png", "frame", frames[i], frames[0].shape());
    pictures[i] = io::png_file(path, detail::changed_pixels(frames[i], i > 0 ? &frames[i - 1] : nullptr));
  });
  // Each holds a signature and its extents, one chunk of data, and an end.
  constexpr std::size_t begin = 33, frame = 12, end = 12;  // bytes
  std::string file =
      pictures[0].substr(0, begin) + png_chunk("acTL" + number_bytes(frames.size()) + number_bytes(0));
  const std::string control =
      number_bytes(frames[0].shape(1)) + number_bytes(frames[0].shape(0)) + number_bytes(0) +
      number_bytes(0) +  // its place
      number_bytes(static_cast<std::size_t>(std::lround(1000 * seconds)), 2) + number_bytes(1000, 2) +
      '\0' +                                    // what is drawn stays
      (frames[0].shape(2) == 3 ? '\1' : '\0');  // lies over, or replaces, what was there
  for (std::size_t i = 0, sequence = 0; i < frames.size(); ++i) {
    const auto data = pictures[i].substr(begin + 8, pictures[i].size() - begin - frame - end);
    file += png_chunk("fcTL" + number_bytes(sequence++) + control);
    file += png_chunk(i == 0 ? "IDAT" + data : "fdAT" + number_bytes(sequence++) + data);
  }
  return file + pictures[0].substr(pictures[0].size() - end);
}
}  // namespace tapestry::shell
