#pragma once
#include <array>
#include <bit>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <locale>
#include <sstream>
#include <string>
#include <system_error>

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

namespace detail {
/// The end of the longest decimal number at the beginning of a text, in the form of strtod() but without
/// blanks, "+", words and hexadecimal; `first` if there is none.
[[nodiscard]] inline const char* end_of_decimal(const char* first, const char* last) {
  const auto skip_digits = [last](const char* at) {
    while (at != last && *at >= '0' && *at <= '9') ++at;
    return at;
  };
  const char* const whole = first != last && *first == '-' ? first + 1 : first;
  const char* end = skip_digits(whole);
  const bool has_point = end != last && *end == '.';
  if (has_point) end = skip_digits(end + 1);
  if (end - whole == (has_point ? 1 : 0)) return first;
  if (end != last && (*end == 'e' || *end == 'E')) {
    const char* const sign = end + 1;
    const char* const power = sign != last && (*sign == '-' || *sign == '+') ? sign + 1 : sign;
    if (const char* const behind = skip_digits(power); behind != power) end = behind;
  }
  return end;
}

/// decimal_from_chars() for standard libraries without std::from_chars for T.
template <std::floating_point T>
[[nodiscard]] std::from_chars_result decimal_by_stream(const char* first, const char* last, T& value) {
  const char* const end = end_of_decimal(first, last);
  if (end == first) return {first, std::errc::invalid_argument};
  const std::string text(first, end);
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  T number = 0;
  const bool fails = !(stream >> number);  // beyond the largest number, and for libc++ below normal ones, too
  const bool is_beyond =
      fails && (number >= std::numeric_limits<T>::max() || number <= std::numeric_limits<T>::lowest());
  const bool is_zero = text.find_first_of("123456789") >= text.find_first_of("eE");
  if (is_beyond || (number == 0 && !is_zero)) return {end, std::errc::result_out_of_range};
  value = number;
  return {end, std::errc()};
}
}  // namespace detail

/// std::from_chars, also for standard libraries that have it for whole numbers only, such as libc++ before
/// 20.
template <class Number>
[[nodiscard]] std::from_chars_result decimal_from_chars(const char* first, const char* last, Number& value) {
  if constexpr (requires { std::from_chars(first, last, value); }) {
    return std::from_chars(first, last, value);
  } else {
    return detail::decimal_by_stream(first, last, value);
  }
}
}  // namespace tapestry::io
