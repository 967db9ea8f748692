#pragma once
#include <cstring>
#include <optional>
#include <tapestry/io/detail/number_formats.hpp>
#include <tapestry/nn/network/tensor.hpp>

namespace tapestry::io {
/// Element types by their numbers in a file; others are known by name only.
/// Source: onnx.proto, TensorProto.DataType.
enum class OnnxType : std::int64_t {
  undefined = 0,
  float32 = 1,
  uint8 = 2,
  int8 = 3,
  uint16 = 4,
  int16 = 5,
  int32 = 6,
  int64 = 7,
  boolean = 9,
  float16 = 10,
  float64 = 11,
  uint32 = 12,
  uint64 = 13,
  bfloat16 = 16,
  uint4 = 21,
  int4 = 22,
};

/// Elements as nn::Constant keeps them.
using ConstantValues = decltype(nn::Constant::values);

/// The range of integers that may stand for an element in int32_data or uint64_data.
struct IntegerRange {
  std::int64_t least = 0;
  std::int64_t largest = 65535;
};

/// Facts about the elements of one type in a file.
struct OnnxTypeFacts {
  std::string_view name;
  std::size_t bits = 0;  ///< bits of an element in raw_data; 0 for an unsupported type
  nn::ElementType meaning = nn::ElementType::floating;
  std::uint32_t field = 0;  ///< field of TensorProto that may replace raw_data
  /// Reads so many elements from raw_data.
  ConstantValues (*values)(std::span<const std::byte> bytes, std::size_t count) = nullptr;
  /// Least and largest number of an integer type. 16-bit floats have one, too: they are kept as integers of
  /// the same bits. So have pairs of four-bit elements. INT64 and UINT64 fill their fields and have none.
  IntegerRange range{};
};

namespace detail {
/// A little-endian integer, rounded to the nearest double beyond 2^53.
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

template <auto value_from, std::size_t item>
[[nodiscard]] ConstantValues converted(std::span<const std::byte> bytes, std::size_t count) {
  std::vector<decltype(value_from(bytes.data()))> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = value_from(bytes.data() + item * i);
  return values;
}

template <std::integral Integer>
inline constexpr auto integers = converted<double_from_integer<Integer>, sizeof(Integer)>;

[[nodiscard]] inline ConstantValues floats_of(std::span<const std::byte> bytes, std::size_t count) {
  if constexpr (std::endian::native != std::endian::little) return converted<float_from_f32, 4>(bytes, count);
  std::vector<float> values(count);
  if (count > 0) std::memcpy(values.data(), bytes.data(), 4 * count);
  return values;
}

/// Elements of four bits; the lower half of a byte comes first.
template <bool is_signed>
[[nodiscard]] ConstantValues four_bits(std::span<const std::byte> bytes, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto byte = std::to_integer<unsigned>(bytes[i / 2]);
    const auto bits = static_cast<int>((i % 2 == 0 ? byte : byte >> 4U) & 0xFU);
    values[i] = is_signed && bits > 7 ? bits - 16 : bits;
  }
  return values;
}

inline constexpr std::uint32_t float_data = 4;
inline constexpr std::uint32_t int32_data = 5;
inline constexpr std::uint32_t int64_data = 7;
inline constexpr std::uint32_t double_data = 10;
inline constexpr std::uint32_t uint64_data = 11;

[[nodiscard]] constexpr std::string_view field_name(std::uint32_t field) {
  if (field == float_data) return "float_data";
  if (field == int32_data) return "int32_data";
  if (field == int64_data) return "int64_data";
  return field == double_data ? "double_data" : "uint64_data";
}

inline constexpr auto whole_number = nn::ElementType::integer;
inline constexpr std::array<OnnxTypeFacts, 27> onnx_types{{
    {"UNDEFINED"},
    {"FLOAT", 32, nn::ElementType::floating, float_data, floats_of},
    {"UINT8", 8, whole_number, int32_data, integers<std::uint8_t>, {0, 255}},
    {"INT8", 8, whole_number, int32_data, integers<std::int8_t>, {-128, 127}},
    {"UINT16", 16, whole_number, int32_data, integers<std::uint16_t>},
    {"INT16", 16, whole_number, int32_data, integers<std::int16_t>, {-32768, 32767}},
    {"INT32", 32, whole_number, int32_data, integers<std::int32_t>, {-0x80000000LL, 0x7FFFFFFF}},
    {"INT64", 64, whole_number, int64_data, integers<std::int64_t>},
    {"STRING"},
    {"BOOL", 8, nn::ElementType::boolean, int32_data, converted<double_from_truth, 1>, {0, 255}},
    {"FLOAT16", 16, nn::ElementType::floating, int32_data, converted<float_from_f16, 2>},
    {"DOUBLE", 64, nn::ElementType::floating, double_data, converted<double_from_f64, 8>},
    {"UINT32", 32, whole_number, uint64_data, integers<std::uint32_t>, {0, 0xFFFFFFFF}},
    {"UINT64", 64, whole_number, uint64_data, integers<std::uint64_t>},
    {"COMPLEX64"},
    {"COMPLEX128"},
    {"BFLOAT16", 16, nn::ElementType::floating, int32_data, converted<float_from_bf16, 2>},
    {"FLOAT8E4M3FN"},
    {"FLOAT8E4M3FNUZ"},
    {"FLOAT8E5M2"},
    {"FLOAT8E5M2FNUZ"},
    {"UINT4", 4, whole_number, int32_data, four_bits<false>, {0, 255}},
    {"INT4", 4, whole_number, int32_data, four_bits<true>, {0, 255}},
    {"FLOAT4E2M1"},
    {"FLOAT8E8M0"},
    {"UINT2"},
    {"INT2"},
}};
}  // namespace detail

/// The facts of a type; an unknown number has those of an unsupported type.
[[nodiscard]] constexpr const OnnxTypeFacts& facts_of(OnnxType type) {
  const auto number = static_cast<std::uint64_t>(type);
  return detail::onnx_types[number < detail::onnx_types.size() ? static_cast<std::size_t>(number) : 0];
}

/// "FLOAT16", or "27" for a number without a name.
[[nodiscard]] inline std::string name_of(OnnxType type) {
  const auto number = static_cast<std::int64_t>(type);
  const bool is_known = number >= 0 && number < static_cast<std::int64_t>(detail::onnx_types.size());
  return is_known ? std::string(facts_of(type).name) : std::to_string(number);
}

/// Types that is_supported() accepts, for messages.
inline constexpr const char* supported_onnx_types = "FLOAT, FLOAT16, BFLOAT16, DOUBLE, BOOL or integers";

/// True for the types whose elements are read.
[[nodiscard]] constexpr bool is_supported(OnnxType type) { return facts_of(type).bits != 0; }

/// Bytes of so many elements in raw_data; two elements of four bits share a byte.
[[nodiscard]] constexpr std::uint64_t raw_size(OnnxType type, std::uint64_t count) {
  return (count * facts_of(type).bits + 7) / 8;
}

/// Product of extents; 0 if one is 0. Nothing if the product of those that are not 0 reaches 2^48, more than
/// any file holds.
[[nodiscard]] inline std::optional<std::uint64_t> element_count(std::span<const std::size_t> extents) {
  constexpr std::uint64_t largest = std::uint64_t(1) << 48U;
  std::uint64_t product = 1;
  bool is_empty = false;
  for (const std::size_t extent : extents) {
    is_empty = is_empty || extent == 0;
    const std::uint64_t factor = extent == 0 ? 1 : extent;
    if (product >= (largest + factor - 1) / factor) return {};
    product *= factor;
  }
  return is_empty ? 0 : product;
}

/// The elements in raw_data: FLOAT, FLOAT16 and BFLOAT16 exactly as floats, all others as doubles. INT64 and
/// UINT64 beyond 2^53 are rounded to the nearest double.
///
/// \param bytes  raw_size(type, count) of them
[[nodiscard]] inline ConstantValues values_from_raw(OnnxType type, std::span<const std::byte> bytes,
                                                    std::size_t count) {
  const auto values = facts_of(type).values;
  return values == nullptr ? ConstantValues() : values(bytes, count);
}
}  // namespace tapestry::io
