#pragma once
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace tapestry::io {

/// A word from its bytes, the least significant first, on any machine.
template <std::unsigned_integral Word>
[[nodiscard]] constexpr Word little_endian_word(const std::byte* bytes) {
  Word word = 0;
  for (std::size_t i = 0; i < sizeof(Word); ++i)
    word = static_cast<Word>(word | static_cast<Word>(static_cast<Word>(bytes[i]) << (8 * i)));
  return word;
}

/// The bytes of a word, the least significant first.
template <std::unsigned_integral Word>
[[nodiscard]] constexpr std::array<std::byte, sizeof(Word)> little_endian_bytes(Word word) {
  std::array<std::byte, sizeof(Word)> bytes{};
  for (std::size_t i = 0; i < sizeof(Word); ++i) bytes[i] = static_cast<std::byte>(word >> (8 * i) & 0xFFU);
  return bytes;
}

/// Little-endian IEEE 754 binary32.
[[nodiscard]] inline float float_from_f32(const std::byte* bytes) {
  return std::bit_cast<float>(little_endian_word<std::uint32_t>(bytes));
}

/// Little-endian IEEE 754 binary64, rounded to the nearest float; to infinity if that lies beyond the
/// largest.
[[nodiscard]] inline float float_from_f64(const std::byte* bytes) {
  const auto value = std::bit_cast<double>(little_endian_word<std::uint64_t>(bytes));
  constexpr double beyond = 0x1.FFFFFFp127;  // the first that rounds to 2¹²⁸
  if (value >= beyond) return std::numeric_limits<float>::infinity();
  if (value <= -beyond) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(value);
}

/// Little-endian bfloat16, the upper half of a binary32; exact.
[[nodiscard]] inline float float_from_bf16(const std::byte* bytes) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(little_endian_word<std::uint16_t>(bytes)) << 16U);
}

/// Little-endian IEEE 754 binary16: sign, 5 bits of exponent with bias 15, 10 bits of fraction; exact.
[[nodiscard]] inline float float_from_f16(const std::byte* bytes) {
  const std::uint32_t half = little_endian_word<std::uint16_t>(bytes);
  const std::uint32_t sign = (half & 0x8000U) << 16U;
  const std::uint32_t exponent = half >> 10U & 0x1FU;
  const std::uint32_t fraction = half & 0x3FFU;
  if (exponent == 0) {  // zero, or fraction · 2⁻²⁴
    const float magnitude = static_cast<float>(fraction) * 0x1p-24F;
    return sign != 0 ? -magnitude : magnitude;
  }
  const std::uint32_t widened = exponent == 31 ? 255 : exponent + 112;  // 112 = 127 − 15
  return std::bit_cast<float>(sign | widened << 23U | fraction << 13U);
}

}  // namespace tapestry::io
