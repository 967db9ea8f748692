#pragma once
#include <locale.h>
#include <stdlib.h>

#include <charconv>
#include <concepts>
#include <string>
#include <system_error>

namespace tapestry::io {
namespace detail {

/// The end of the longest decimal number that a text begins with, as strtod() reads it but without blanks,
/// "+", words and hexadecimal; `first` if there is none.
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
[[nodiscard]] std::from_chars_result decimal_by_strtod(const char* first, const char* last, T& value) {
  static const locale_t c_locale = newlocale(LC_ALL_MASK, "C", locale_t{});
  const char* const end = end_of_decimal(first, last);
  if (end == first) return {first, std::errc::invalid_argument};
  const std::string text(first, end);
  T number = 0;
  if constexpr (std::same_as<T, float>) {
    number = strtof_l(text.c_str(), nullptr, c_locale);
  } else {
    number = strtod_l(text.c_str(), nullptr, c_locale);
  }
  const bool is_zero = text.find_first_of("123456789") >= text.find_first_of("eE");
  if (number - number != 0 || (number == 0 && !is_zero)) return {end, std::errc::result_out_of_range};
  value = number;
  return {end, std::errc()};
}
}  // namespace detail

/// std::from_chars, also where the standard library has it for whole numbers alone, as libc++ before 20.
template <class Number>
[[nodiscard]] std::from_chars_result decimal_from_chars(const char* first, const char* last, Number& value) {
  if constexpr (requires { std::from_chars(first, last, value); }) {
    return std::from_chars(first, last, value);
  } else {
    return detail::decimal_by_strtod(first, last, value);
  }
}

}  // namespace tapestry::io
