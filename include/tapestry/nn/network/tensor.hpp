#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>
#include <tapestry/core/array_limit.hpp>
#include <tapestry/core/error.hpp>
#include <variant>
#include <vector>

namespace tapestry::nn {
/// Extents of a tensor, outermost first; empty for a scalar.
using Shape = std::vector<std::size_t>;

/// Product of the extents: 1 for a scalar.
[[nodiscard]] inline std::size_t size_of(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t(1), std::multiplies<>());
}

/// Largest number of elements, and of axes, of a network's tensor.
inline constexpr std::size_t most_elements =
    static_cast<std::size_t>(std::min<std::uint64_t>(std::uint64_t(1) << 32U, array_limit));
inline constexpr std::size_t most_axes = 32;

/// Checks that no product of a tensor's extents wraps, even if another extent is 0.
/// \throws ShapeError for more than most_elements or most_axes
inline void require_room(const Shape& shape) {
  if (shape.size() > most_axes)
    throw ShapeError({"a tensor of ", shape.size(), " axes, expected at most ", most_axes});
  std::size_t count = 1;
  for (const std::size_t extent : shape) {
    if (extent > 0 && count > most_elements / extent) throw ShapeError({"a tensor ", shape, " is too large"});
    count *= extent > 0 ? extent : 1;
  }
}

/// Place along an axis of an index that may count from the end; `extent` where it is out of range or NaN. The
/// end is counted in integers: a float loses the last digits of more than 2^24 elements.
template <std::floating_point T>
[[nodiscard]] std::size_t place_of_index(T index, std::size_t extent) {
  if (!(index > T(-0x1p62) && index < T(0x1p62))) return extent;
  const auto whole = static_cast<std::int64_t>(index), count = static_cast<std::int64_t>(extent);
  const std::int64_t place = whole < 0 ? whole + count : whole;
  return place >= 0 && place < count ? static_cast<std::size_t>(place) : extent;
}

/// An index in messages: without a fraction if it has none.
template <std::floating_point T>
[[nodiscard]] std::string index_text(T index) {
  return index > T(-0x1p62) && index < T(0x1p62) && index == std::trunc(index)
             ? std::to_string(static_cast<std::int64_t>(index))
             : std::to_string(index);
}

/// Meaning of the elements of a tensor. All are computed in one floating type. Integers (indices and extents)
/// are exact in it up to its digits, 2^24 in float; a Boolean is 0 or 1.
enum class ElementType { floating, integer, boolean };

/// Numbers that another owner keeps, such as a model's parameters. With factors, each of as many equal rows
/// is multiplied by its factor and rounded.
struct BorrowedValues {
  std::span<const float> numbers{};
  std::vector<double> factors{};

  [[nodiscard]] std::size_t size() const { return numbers.size(); }
  [[nodiscard]] std::size_t row_size() const { return size() / std::max<std::size_t>(1, factors.size()); }
  [[nodiscard]] float operator[](std::size_t i) const {
    return factors.empty() ? numbers[i] : scaled(i, factors[i / row_size()]);
  }
  friend bool operator==(const BorrowedValues& a, const BorrowedValues& b) {
    return std::ranges::equal(a.numbers, b.numbers) && a.factors == b.factors;
  }
  [[nodiscard]] float scaled(std::size_t i, double factor) const {
    return static_cast<float>(static_cast<double>(numbers[i]) * factor);
  }
};

/// A tensor whose values are known before a network runs: weights, and numbers that shapes are computed from.
/// Weights stay in single precision, as files hold them; integers and doubles are stored in double.
struct Constant {
  Shape shape{};
  ElementType type = ElementType::floating;
  std::variant<std::vector<float>, std::vector<double>, BorrowedValues> values{};
  std::int32_t file_type = 0;  ///< of integers in a file, as ONNX numbers them: 2 is UINT8; else 0

  [[nodiscard]] std::size_t size() const {
    return std::visit([](const auto& all) { return all.size(); }, values);
  }
  /// Element i in row-major order.
  [[nodiscard]] double at(std::size_t i) const {
    return std::visit([i](const auto& all) { return static_cast<double>(all[i]); }, values);
  }
};

/// Appends a constant's values.
template <class Values, class To>
void append(const Values& from, To& to) {
  if constexpr (std::is_same_v<Values, BorrowedValues>) {
    for (std::size_t row = 0, i = 0; row < from.factors.size(); ++row)
      for (const std::size_t end = i + from.row_size(); i < end; ++i)
        to.push_back(static_cast<typename To::value_type>(from.scaled(i, from.factors[row])));
    if (!from.factors.empty()) return;
  }
  for (std::size_t i = 0; i < from.size(); ++i) to.push_back(static_cast<typename To::value_type>(from[i]));
}

/// A tensor that a pass holds: values in row-major order of its shape.
template <std::floating_point T>
struct TensorView {
  const Shape* shape = nullptr;
  T* values = nullptr;  ///< null for an operand that a node leaves out

  [[nodiscard]] bool is_there() const { return values != nullptr; }
  [[nodiscard]] std::size_t size() const { return size_of(*shape); }
};
}  // namespace tapestry::nn
