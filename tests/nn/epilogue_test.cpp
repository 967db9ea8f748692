#include <tapestry/nn/detail/vector_kernels.hpp>

#include <algorithm>

#include "../support/catch.hpp"
#include "../support/random_buffer.hpp"

namespace nn = tapestry::nn;
using tapestry::test::random_buffer;

namespace {
[[nodiscard]] bool bit(const std::vector<std::uint8_t>& bits, std::size_t i) {
  return (bits[i / 8] >> i % 8 & 1) != 0;
}

/// Options of an epilogue, in every combination.
struct Wishes {
  bool bias, adds, leaks, gate, positive, addend, factor;

  explicit Wishes(unsigned code)
      : bias((code & 1) != 0),
        adds((code & 2) != 0),
        leaks((code & 4) != 0),
        gate((code & 8) != 0),
        positive((code & 16) != 0),
        addend((code & 32) != 0),
        factor((code & 64) != 0) {}
};

/// `rows` sums of 40 products for `lane_count` outputs, finished by the kernel and by the definition.
template <class T>
void check_tile(const nn::Kernels<T>& kernels, std::size_t registers, std::size_t rows,
                std::size_t lane_count, const Wishes& wishes) {
  CAPTURE(kernels.lanes, registers, rows, lane_count, wishes.bias, wishes.adds, wishes.leaks, wishes.gate,
          wishes.positive, wishes.addend, wishes.factor);
  constexpr std::size_t products = 40;
  const std::size_t width = registers * kernels.lanes;
  const std::size_t row_step = 3 * width;  // of the output, whose first sum lies one vector inside
  const std::size_t first = kernels.lanes;
  const auto in = random_buffer<T>(rows * products, 1);
  const auto weights = random_buffer<T>(products * width, 2);
  const auto bias = random_buffer<T>(width, 3);
  const auto before = random_buffer<T>(rows * row_step, 4);
  const auto addend = random_buffer<T>(rows * row_step, 5), factor = random_buffer<T>(rows * row_step, 6);
  std::vector<std::uint8_t> gate(rows * row_step / 8 + 1), positive(gate.size(), 0);
  for (std::size_t i = 0; i < gate.size(); ++i) gate[i] = static_cast<std::uint8_t>(37 * i + 11);
  nn::Buffer<T> out(rows * row_step);
  std::copy_n(before.data(), out.size(), out.data());

  nn::ReduceArguments<T> a{};
  a.in = in.data();
  a.in_row_step = products;
  a.in_inner_step = 1;
  a.weights = weights.data();
  a.outer_count = 1;
  a.inner_count = products;
  a.out = out.data() + first;
  a.out_row_step = static_cast<std::ptrdiff_t>(row_step);
  a.lane_count = lane_count;
  a.end.bias = wishes.bias ? bias.data() : nullptr;
  a.end.adds = wishes.adds;
  a.end.factor = wishes.factor ? factor.data() : nullptr;
  a.end.slope = wishes.leaks ? T(0.125) : T(1);
  a.end.gate = wishes.gate ? gate.data() : nullptr;
  a.end.positive = wishes.positive ? positive.data() : nullptr;
  a.end.addend = wishes.addend ? addend.data() : nullptr;
  a.end.origin = out.data();
  kernels.reduce[registers - 1][rows - 1](a);

  const double tolerance = 50 * static_cast<double>(std::numeric_limits<T>::epsilon());
  bool is_right = true;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t row = i / row_step;
    const std::size_t lane = i % row_step - first;
    if (i % row_step < first || lane >= lane_count) {
      is_right = is_right && out.data()[i] == before.data()[i];  // untouched
      continue;
    }
    double value = wishes.bias ? static_cast<double>(bias.data()[lane]) : 0;
    for (std::size_t k = 0; k < products; ++k)
      value += static_cast<double>(in.data()[row * products + k]) *
               static_cast<double>(weights.data()[k * width + lane]);
    if (wishes.adds) value += static_cast<double>(before.data()[i]);
    if (wishes.factor) value *= static_cast<double>(factor.data()[i]);
    const bool keeps = wishes.gate ? bit(gate, i) : value > 0;
    if (wishes.leaks && !keeps) value *= 0.125;
    if (wishes.positive) is_right = is_right && bit(positive, i) == (value > 0);
    if (wishes.addend) value += static_cast<double>(addend.data()[i]);
    is_right = is_right && std::abs(static_cast<double>(out.data()[i]) - value) <= tolerance;
  }
  CHECK(is_right);
}

/// One row of a depthwise convolution and the sums of its definition.
template <class T>
void check_depthwise(const nn::Kernels<T>& kernels, std::size_t taps, std::size_t stride, std::size_t spacing,
                     std::ptrdiff_t padding, std::size_t in_columns, std::size_t channels) {
  const auto reach = static_cast<std::ptrdiff_t>((taps - 1) * spacing + 1);
  const std::ptrdiff_t room = static_cast<std::ptrdiff_t>(in_columns) + 2 * padding - reach;
  if (room < 0) return;
  CAPTURE(kernels.lanes, taps, stride, spacing, padding, in_columns, channels);
  const std::size_t row_taps = 2;
  const std::size_t pitch = (channels + kernels.lanes - 1) / kernels.lanes * kernels.lanes;
  const auto in = random_buffer<T>(row_taps * in_columns * channels, 1);
  const auto weights = random_buffer<T>(row_taps * taps * pitch, 2);
  nn::DepthwiseArguments<T> a{};
  a.in = in.data();
  a.in_row_step = in_columns * channels;
  a.row_taps = row_taps;
  a.column_taps = taps;
  a.column_stride = stride;
  a.column_spacing = spacing;
  a.column_padding = padding;
  a.in_columns = in_columns;
  a.weights = weights.data();
  a.weight_step = pitch;
  a.channel_count = channels;
  a.out_columns = static_cast<std::size_t>(room) / stride + 1;
  a.out_pixel_step = channels;
  nn::Buffer<T> out(a.out_columns * channels);
  a.out = out.data();
  a.end.origin = out.data();
  kernels.depthwise_row(a);
  double worst = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    double value = 0;
    for (std::size_t tap = 0; tap < row_taps * taps; ++tap) {
      const std::ptrdiff_t column = static_cast<std::ptrdiff_t>(i / channels * stride) - padding +
                                    static_cast<std::ptrdiff_t>(tap % taps * spacing);
      if (column < 0 || column >= static_cast<std::ptrdiff_t>(in_columns)) continue;
      const std::size_t pixel = tap / taps * in_columns + static_cast<std::size_t>(column);
      value += static_cast<double>(in.data()[pixel * channels + i % channels]) *
               static_cast<double>(weights.data()[tap * pitch + i % channels]);
    }
    worst = std::max(worst, std::abs(value - static_cast<double>(out.data()[i])));
  }
  CHECK(worst <= 30 * static_cast<double>(std::numeric_limits<T>::epsilon()));
}
}  // namespace

TEMPLATE_TEST_CASE("every instruction set finishes sums as the epilogue's definition says", "[nn][epilogue]",
                   float, double) {
  for (const auto set : tapestry::instruction_sets()) {
    const auto kernels = nn::kernels_of<TestType>(set);
    const bool has_bits = kernels.lanes % 8 == 0;
    for (unsigned code = 0; code < 128; ++code) {
      const Wishes wishes(code);
      const bool wants_bits = wishes.gate || wishes.positive;
      if (wants_bits && !has_bits) continue;
      for (const std::size_t rows : {std::size_t(1), kernels.tile_rows})
        for (const std::size_t registers : {1U, 2U}) {
          const std::size_t width = registers * kernels.lanes;
          check_tile(kernels, registers, rows, width, wishes);
          if (wants_bits) continue;  // only of whole vectors
          for (const std::size_t missing : {std::size_t(1), kernels.lanes / 2})
            check_tile(kernels, registers, rows, width - missing, wishes);
        }
    }
  }
}

TEMPLATE_TEST_CASE("every instruction set computes depthwise rows of any taps, stride and edge",
                   "[nn][depthwise]", float, double) {
  for (const auto set : tapestry::instruction_sets()) {
    const auto kernels = nn::kernels_of<TestType>(set);
    for (const std::size_t taps : {1U, 2U, 3U, 4U, 5U})
      for (const std::size_t stride : {1U, 2U, 3U})
        for (const std::size_t spacing : {1U, 2U})
          for (const std::ptrdiff_t padding : {-1, 0, 1, 2})
            for (const std::size_t columns : {1U, 2U, 6U, 13U, 20U})
              for (const std::size_t channels : {1U, 16U, 19U}) {
                if (channels != 19 && columns % 2 == 0) continue;  // not everything with everything
                check_depthwise(kernels, taps, stride, spacing, padding, columns, channels);
              }
  }
}
