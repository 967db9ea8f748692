#pragma once
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <tapestry/io/float_formats.hpp>
#include <tapestry/io/onnx/element_type.hpp>
#include <variant>
#include <vector>

namespace tapestry::io {

/// Elements as nn::Constant keeps them.
using ConstantValues = std::variant<std::vector<float>, std::vector<double>>;

namespace detail {

/// A little-endian integer; rounded to the nearest double beyond 2^53.
template <std::integral Integer>
[[nodiscard]] double double_from_integer(const std::byte* bytes) {
  return static_cast<double>(static_cast<Integer>(little_endian_word<std::make_unsigned_t<Integer>>(bytes)));
}

[[nodiscard]] inline double double_from_f64(const std::byte* bytes) {
  return std::bit_cast<double>(little_endian_word<std::uint64_t>(bytes));
}

/// Any byte but 0 is true.
[[nodiscard]] inline double double_from_truth(const std::byte* byte) {
  return *byte == std::byte(0) ? 0.0 : 1.0;
}

template <auto value_from>
[[nodiscard]] auto converted(std::span<const std::byte> bytes, std::size_t item) {
  std::vector<decltype(value_from(bytes.data()))> values(bytes.size() / item);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = value_from(bytes.data() + item * i);
  return values;
}

[[nodiscard]] inline std::vector<float> floats_of(std::span<const std::byte> bytes) {
  if constexpr (std::endian::native != std::endian::little) return converted<float_from_f32>(bytes, 4);
  std::vector<float> values(bytes.size() / 4);
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), 4 * values.size());
  return values;
}

/// Element i of four-bit ones: the lower half of a byte comes first.
[[nodiscard]] inline double four_bits_at(std::span<const std::byte> bytes, std::size_t i, bool is_signed) {
  const auto byte = std::to_integer<unsigned>(bytes[i / 2]);
  const auto bits = static_cast<int>((i % 2 == 0 ? byte : byte >> 4U) & 0xFU);
  return is_signed && bits > 7 ? bits - 16 : bits;
}

}  // namespace detail

/// The elements that lie in raw_data: FLOAT, FLOAT16 and BFLOAT16 exactly as floats, all others as doubles.
/// INT64 and UINT64 beyond 2^53 are rounded to the nearest double.
///
/// \param bytes  raw_size(type, count) of them
[[nodiscard]] inline ConstantValues values_from_raw(OnnxType type, std::span<const std::byte> bytes,
                                                    std::size_t count) {
  switch (type) {
    case OnnxType::float32:
      return detail::floats_of(bytes);
    case OnnxType::float16:
      return detail::converted<float_from_f16>(bytes, 2);
    case OnnxType::bfloat16:
      return detail::converted<float_from_bf16>(bytes, 2);
    case OnnxType::float64:
      return detail::converted<detail::double_from_f64>(bytes, 8);
    case OnnxType::uint8:
      return detail::converted<detail::double_from_integer<std::uint8_t>>(bytes, 1);
    case OnnxType::int8:
      return detail::converted<detail::double_from_integer<std::int8_t>>(bytes, 1);
    case OnnxType::uint16:
      return detail::converted<detail::double_from_integer<std::uint16_t>>(bytes, 2);
    case OnnxType::int16:
      return detail::converted<detail::double_from_integer<std::int16_t>>(bytes, 2);
    case OnnxType::uint32:
      return detail::converted<detail::double_from_integer<std::uint32_t>>(bytes, 4);
    case OnnxType::int32:
      return detail::converted<detail::double_from_integer<std::int32_t>>(bytes, 4);
    case OnnxType::uint64:
      return detail::converted<detail::double_from_integer<std::uint64_t>>(bytes, 8);
    case OnnxType::int64:
      return detail::converted<detail::double_from_integer<std::int64_t>>(bytes, 8);
    case OnnxType::boolean:
      return detail::converted<detail::double_from_truth>(bytes, 1);
    case OnnxType::uint4:
    case OnnxType::int4: {
      std::vector<double> values(count);
      for (std::size_t i = 0; i < count; ++i)
        values[i] = detail::four_bits_at(bytes, i, type == OnnxType::int4);
      return values;
    }
    case OnnxType::undefined:
      break;
  }
  return {};
}

/// The range of an integer that stands for an element in int32_data or uint64_data.
struct IntegerRange {
  std::int64_t least = 0;
  std::int64_t largest = 0;
};

/// Of 16-bit floats, whose bits are kept as an integer, and of pairs of four-bit elements, too. INT64 and
/// UINT64 fill their fields and have no range.
[[nodiscard]] constexpr IntegerRange integer_range(OnnxType type) {
  switch (type) {
    case OnnxType::int8:
      return {-128, 127};
    case OnnxType::int16:
      return {-32768, 32767};
    case OnnxType::int32:
      return {std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()};
    case OnnxType::uint32:
      return {0, std::numeric_limits<std::uint32_t>::max()};
    case OnnxType::boolean:
    case OnnxType::uint8:
    case OnnxType::uint4:
    case OnnxType::int4:
      return {0, 255};
    default:
      return {0, 65535};
  }
}

}  // namespace tapestry::io
