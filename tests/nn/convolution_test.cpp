#include <tapestry/nn/detail/convolution_weight_adjoint.hpp>
#include <tapestry/nn/engine.hpp>

#include "../support/random_buffer.hpp"
#include "../support/relative_distance.hpp"

namespace nn = tapestry::nn;
using tapestry::test::largest_difference, tapestry::test::random_buffer;

namespace {
/// Calls visit(input index, weight index, output index) for every product of a convolution of one image.
template <class Visit>
void for_each_product(const nn::ConvolutionShape& s, Visit visit) {
  for (std::size_t oy = 0; oy < s.rows.output; ++oy)
    for (std::size_t ox = 0; ox < s.columns.output; ++ox)
      for (std::size_t m = 0; m < s.out_channels; ++m)
        for (std::size_t ty = 0; ty < s.rows.taps; ++ty)
          for (std::size_t tx = 0; tx < s.columns.taps; ++tx) {
            const auto y =
                static_cast<std::ptrdiff_t>(oy * s.rows.stride + ty * s.rows.spacing) - s.rows.padding;
            const auto x = static_cast<std::ptrdiff_t>(ox * s.columns.stride + tx * s.columns.spacing) -
                           s.columns.padding;
            if (y < 0 || x < 0 || y >= static_cast<std::ptrdiff_t>(s.rows.input) ||
                x >= static_cast<std::ptrdiff_t>(s.columns.input))
              continue;
            const std::size_t pixel =
                static_cast<std::size_t>(y) * s.columns.input + static_cast<std::size_t>(x);
            for (std::size_t i = 0; i < s.group_in(); ++i) {
              const std::size_t c = m / s.group_out() * s.group_in() + i;
              visit(pixel * s.in_channels + c,
                    ((m * s.group_in() + i) * s.rows.taps + ty) * s.columns.taps + tx,
                    (oy * s.columns.output + ox) * s.out_channels + m);
            }
          }
}

std::vector<nn::ConvolutionShape> shapes() {
  // Height, width, channels in and out, taps, stride, padding, dilation and groups.
  constexpr std::size_t numbers[][9] = {
      {1, 1, 3, 5, 3, 1, 1, 1, 1},     {1, 1, 255, 3, 1, 1, 0, 1, 1},  {7, 5, 3, 16, 3, 2, 1, 1, 1},
      {13, 13, 5, 255, 1, 1, 0, 1, 1}, {6, 9, 24, 40, 3, 1, 1, 1, 1},  {9, 8, 300, 33, 3, 1, 1, 1, 1},
      {8, 8, 256, 17, 3, 2, 1, 1, 1},  {8, 11, 12, 18, 3, 1, 1, 1, 3}, {11, 8, 20, 20, 5, 1, 2, 1, 20},
      {12, 9, 33, 33, 3, 2, 1, 1, 33}, {9, 9, 4, 6, 3, 1, 2, 2, 1},    {10, 9, 4, 6, 3, 2, 2, 2, 1},
      {10, 10, 6, 7, 3, 3, 0, 1, 1},   {9, 10, 6, 7, 1, 2, 0, 1, 1},   {20, 30, 8, 8, 1, 1, 0, 1, 1},
      {7, 7, 3, 4, 7, 2, 3, 1, 1},     {3, 3, 2, 2, 5, 1, 4, 1, 1},    {2, 3, 70, 9, 3, 1, 1, 1, 1},
      {17, 30, 8, 3, 3, 1, 1, 1, 1},   {33, 9, 8, 1, 1, 1, 0, 1, 1},   {18, 6, 9, 2, 3, 1, 1, 1, 1},
      {16, 21, 3, 20, 3, 1, 2, 1, 1},  {11, 19, 9, 4, 3, 1, 0, 1, 1},  {9, 9, 2, 20, 5, 2, 2, 1, 1}};
  std::vector<nn::ConvolutionShape> all;
  for (const auto& [height, width, in, out, taps, stride, padding, dilation, groups] : numbers)
    all.push_back(nn::square_convolution(height, width, in, out, taps, stride, padding, dilation, groups));
  return all;
}

/// Every engine against sums computed once for all.
template <class T>
void check_shape(const nn::ConvolutionShape& s, std::size_t images) {
  CAPTURE(s.rows.input, s.columns.input, s.in_channels, s.out_channels, s.rows.taps, s.rows.stride, s.groups);
  const auto in = random_buffer<T>(images * s.in_size(), 1);
  const auto weights = random_buffer<T>(s.weight_count(), 2);
  const auto bias = random_buffer<T>(s.out_channels, 3);
  const auto adjoint = random_buffer<T>(images * s.out_size(), 4);
  std::vector<double> out_expected(images * s.out_size()), in_adjoint_expected(images * s.in_size());
  std::vector<double> weights_adjoint_expected(s.weight_count());
  for (std::size_t n = 0; n < images; ++n) {
    const T* const x = in.data() + n * s.in_size();
    const T* const y_adjoint = adjoint.data() + n * s.out_size();
    const T* const weight = weights.data();
    double* const y = out_expected.data() + n * s.out_size();
    double* const x_adjoint = in_adjoint_expected.data() + n * s.in_size();
    double* const weight_adjoint = weights_adjoint_expected.data();
    for (std::size_t o = 0; o < s.out_size(); ++o)
      y[o] = static_cast<double>(bias.data()[o % s.out_channels]);
    for_each_product(s, [&](std::size_t i, std::size_t w, std::size_t o) {
      const auto g = static_cast<double>(y_adjoint[o]);
      y[o] += static_cast<double>(x[i]) * static_cast<double>(weight[w]);
      x_adjoint[i] += g * static_cast<double>(weight[w]);
      weight_adjoint[w] += g * static_cast<double>(x[i]);
    });
  }
  for (double& value : out_expected) value = value > 0 ? value : value * 0.125;
  for (double& value : in_adjoint_expected) value += 1;
  for (double& value : weights_adjoint_expected) value += 1;

  // Sums of at most `longest` products below 1 wander off by about ε·longest; 8 covers the worst of all.
  const std::size_t longest = std::max(
      {s.group_in() * s.taps(), s.group_out() * s.taps(), images * s.rows.output * s.columns.output});
  const double rounding =
      static_cast<double>(longest + 1) * static_cast<double>(std::numeric_limits<T>::epsilon());
  const auto weight_at = [&](std::size_t i) { return weights.data()[i]; };
  const auto packed = nn::pack_convolution<T>(s, weight_at);
  const auto adjoint_parts = nn::pack_convolution_adjoint<T>(s, weight_at);
  nn::Buffer<T> out(images * s.out_size()), in_adjoint(images * s.in_size());
  for (const auto engine :
       {nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2, nn::Engine::winograd_f4}) {
    CAPTURE(nn::name_of(engine));
    // Winograd's transforms multiply that by at most about 20, the largest row sums of A and B together.
    const double tolerance = (engine == nn::Engine::direct ? 8 : 40) * rounding;
    out.fill_zero();
    nn::convolve<T>(engine, packed, images, in.data(), {.bias = bias.data(), .slope = T(0.125)}, out.data(),
                    s.out_size());
    CHECK(largest_difference(out, out_expected) <= tolerance);

    std::fill_n(in_adjoint.data(), in_adjoint.size(), T(1));
    for (const auto& part : adjoint_parts)
      nn::convolve<T>(engine, part, images, adjoint.data(), {.adds = true}, in_adjoint.data(), s.in_size());
    CHECK(largest_difference(in_adjoint, in_adjoint_expected) <= tolerance);
  }

  nn::Buffer<T> weights_adjoint(s.weight_count());
  nn::Buffer<T> partial;
  std::fill_n(weights_adjoint.data(), weights_adjoint.size(), T(1));
  nn::convolution_weight_adjoint<T>(s, images, in.data(), adjoint.data(), partial, weights_adjoint.data());
  CHECK(largest_difference(weights_adjoint, weights_adjoint_expected) <= 8 * rounding);
}

/// One convolution of one image, or a window of it; outputs that are not written stay -7.
template <class T>
struct WindowCase {
  nn::Engine engine;
  const nn::PackedConvolution<T>& packed;
  std::size_t out_rows;
  const nn::Buffer<T>& plain_input;

  [[nodiscard]] nn::Buffer<T> convolved(const nn::Buffer<T>& in,
                                        const std::optional<nn::MapWindow>& window) const {
    nn::Buffer<T> out(out_rows * packed.out_columns * packed.shape.out_channels);
    std::fill_n(out.data(), out.size(), T(-7));
    const auto bias = random_buffer<T>(packed.shape.out_channels, 3);
    nn::convolve<T>(engine, packed, 1, in.data(), {.bias = bias.data(), .slope = T(0.125)}, out.data(),
                    out.size(), window);
    return out;
  }

  /// Calls visit(inside, a, b) with values of two outputs.
  template <class Visit>
  void compare(const nn::MapWindow& window, const nn::Buffer<T>& a, const nn::Buffer<T>& b,
               Visit visit) const {
    const T *of_a = a.data(), *of_b = b.data();
    for (std::size_t y = 0; y < out_rows; ++y)
      for (std::size_t x = 0; x < packed.out_columns; ++x) {
        const bool inside = y >= window.rows.begin && y < window.rows.end && x >= window.columns.begin &&
                            x < window.columns.end;
        for (std::size_t c = packed.shape.out_channels; c > 0; --c) visit(inside, *of_a++, *of_b++);
      }
  }
};

/// The input with its pixels inside, or outside, of a window set to NaN.
template <class T>
nn::Buffer<T> spoilt(const nn::Buffer<T>& in, const nn::ConvolutionShape& s, const nn::MapWindow& window,
                     bool inside) {
  nn::Buffer<T> result(in.size());
  std::copy_n(in.data(), in.size(), result.data());
  for (std::size_t y = 0; y < s.rows.input; ++y)
    for (std::size_t x = 0; x < s.columns.input; ++x)
      if (inside == (y >= window.rows.begin && y < window.rows.end && x >= window.columns.begin &&
                     x < window.columns.end))
        std::fill_n(result.data() + (y * s.columns.input + x) * s.in_channels, s.in_channels,
                    std::numeric_limits<T>::quiet_NaN());
  return result;
}

std::vector<nn::MapWindow> windows_in(std::size_t rows, std::size_t columns) {
  return {{{0, rows}, {0, columns}},
          {{0, 1}, {columns - 1, columns}},
          {{rows / 2, rows / 2 + 1}, {columns / 3, columns / 2 + 1}},
          {{rows - 1, rows}, {0, 1}},
          {{rows / 3, rows / 3 + 1}, {columns / 4, columns / 4 + 1}},
          {{rows / 4, rows - rows / 4}, {columns / 5, columns - columns / 5}},
          {{rows / 3, rows}, {0, columns}}};
}

/// Within a window all outputs are as in the whole. Outputs that share tiles with it may be written, too, and
/// no others. Unneeded inputs, even NaN, change no bit in it.
template <class T>
std::size_t window_faults(const WindowCase<T>& test, const nn::Buffer<T>& whole,
                          const nn::MapWindow& window) {
  const nn::ConvolutionShape& s = test.packed.shape;
  const nn::OutputTile tile = nn::tile_of(test.engine, test.packed);
  std::size_t count = 0;
  const auto out = test.convolved(test.plain_input, window);
  test.compare(window, out, whole, [&](bool inside, T found, T expected) {
    if (found != expected && (inside || found != T(-7))) ++count;
  });
  const nn::MapWindow tiles{
      nn::aligned(window.rows, tile.outputs * test.packed.row_step, test.out_rows),
      nn::aligned(window.columns, tile.outputs * test.packed.column_step, test.packed.out_columns)};
  test.compare(tiles, out, whole, [&](bool inside, T found, T) {
    if (!inside && found != T(-7)) ++count;
  });
  const nn::MapWindow outputs = nn::outputs_inside(test.packed, window);
  if (outputs.is_empty()) return count;
  const auto needed = spoilt(
      test.plain_input, s,
      {nn::inputs_needed(s.rows, tile, outputs.rows), nn::inputs_needed(s.columns, tile, outputs.columns)},
      false);
  test.compare(window, test.convolved(needed, window), whole, [&](bool inside, T found, T expected) {
    if (inside && found != expected) ++count;
  });
  return count;
}

/// Outputs beyond the reach of an input window do not depend on it.
template <class T>
std::size_t reach_faults(const WindowCase<T>& test, const nn::Buffer<T>& whole, const nn::MapWindow& window) {
  const nn::PackedConvolution<T>& packed = test.packed;
  const nn::ConvolutionShape& s = packed.shape;
  const nn::OutputTile tile = nn::tile_of(test.engine, packed);
  const auto rows = nn::outputs_reached(s.rows, tile, window.rows);
  const auto columns = nn::outputs_reached(s.columns, tile, window.columns);
  const auto out = test.convolved(spoilt(test.plain_input, s, window, true), {});
  const T *found = out.data(), *expected = whole.data();
  std::size_t count = 0;
  for (std::size_t y = 0; y < s.rows.output; ++y)
    for (std::size_t x = 0; x < s.columns.output; ++x) {
      if (y >= rows.begin && y < rows.end && x >= columns.begin && x < columns.end) continue;
      const std::size_t pixel = (packed.first_row + y * packed.row_step) * packed.out_columns +
                                packed.first_column + x * packed.column_step;
      for (std::size_t c = pixel * s.out_channels; c < (pixel + 1) * s.out_channels; ++c)
        if (found[c] != expected[c]) ++count;
    }
  return count;
}

template <class T>
void check_windows(nn::Engine engine, const nn::PackedConvolution<T>& packed, std::size_t out_rows) {
  const nn::ConvolutionShape& s = packed.shape;
  const auto in = random_buffer<T>(s.in_size(), 1);
  const WindowCase<T> test{engine, packed, out_rows, in};
  const auto whole = test.convolved(in, {});
  for (const nn::MapWindow& window : windows_in(out_rows, packed.out_columns))
    CHECK(window_faults(test, whole, window) == 0);
  CHECK(window_faults(test, whole, {{2, 2}, {1, 3}}) == 0);
  for (const nn::MapWindow& window : windows_in(s.rows.input, s.columns.input))
    CHECK(reach_faults(test, whole, window) == 0);
}
}  // namespace

TEMPLATE_TEST_CASE("convolution and its adjoints equal the sums of their definition", "[nn][convolution]",
                   float, double) {
  for (const auto& shape : shapes()) check_shape<TestType>(shape, 2);
  check_shape<TestType>(nn::square_convolution(5, 6, 9, 10, 3, 1, 1), 7);
}

// Rows belong to threads: writing behind a row would undo the next thread's work. At the last row
// AddressSanitizer sees such a store, since no memory follows it.
TEST_CASE("few channels touch nothing behind their rows", "[nn][convolution]") {
  for (std::size_t channels = 1; channels <= 4; ++channels)
    for (const std::size_t columns : std::vector<std::size_t>{1, 2, 5, 9}) {
      const auto s = nn::square_convolution(3, columns, 8, channels, 1, 1, 0);
      const auto in = random_buffer<float>(s.in_size(), 1);
      const auto weights = random_buffer<float>(s.weight_count(), 2);
      const auto packed = nn::pack_convolution<float>(s, [&](std::size_t i) { return weights.data()[i]; });
      REQUIRE(nn::has_few_channels(packed));
      std::vector<float> out(s.out_size());
      nn::convolve_few_channels<float>(packed, 1, in.data(), {}, out.data(), s.out_size());
      for (std::size_t o = 0; o < out.size(); ++o) {
        double expected = 0;
        for (std::size_t i = 0; i < 8; ++i)
          expected += static_cast<double>(in.data()[o / channels * 8 + i]) *
                      static_cast<double>(weights.data()[o % channels * 8 + i]);
        CHECK(static_cast<double>(out[o]) == Approx(expected).margin(1e-5));
      }
    }
}

TEST_CASE("an adjoint that covers its input overwrites all of it", "[nn][convolution]") {
  const auto engine =
      GENERATE(nn::Engine::direct, nn::Engine::winograd_f2, nn::Engine::winograd_f4, nn::Engine::bfloat16);
  for (const auto& s : shapes()) {
    if (!nn::adjoint_covers_input(s)) continue;
    const auto weights = random_buffer<float>(s.weight_count(), 2);
    const auto adjoint = random_buffer<float>(s.out_size(), 4);
    nn::Buffer<float> in_adjoint(s.in_size());
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (std::size_t i = 0; i < s.in_size(); ++i) in_adjoint.data()[i] = nan;
    for (const auto& part :
         nn::pack_convolution_adjoint<float>(s, [&](std::size_t i) { return weights.data()[i]; }))
      nn::convolve<float>(engine, part, 1, adjoint.data(), {}, in_adjoint.data(), s.in_size());
    bool is_finite = true;
    for (std::size_t i = 0; i < s.in_size(); ++i)
      is_finite = is_finite && std::isfinite(in_adjoint.data()[i]);
    CHECK(is_finite);
  }
}

TEMPLATE_TEST_CASE("every instruction set of this machine computes the same tile", "[nn][vector_kernels]",
                   float, double) {
  // The sum of 40 products, each at most 1, errs by at most 40 · ε/2 of the 40.
  constexpr double tolerance = 800 * static_cast<double>(std::numeric_limits<TestType>::epsilon());
  const auto in = random_buffer<TestType>(12 * 40, 1);
  const auto weights = random_buffer<TestType>(40 * 32, 2);
  for (const auto set : tapestry::instruction_sets()) {
    const auto kernels = nn::kernels_of<TestType>(set);
    for (std::size_t registers = 1; registers <= 2; ++registers)
      for (std::size_t rows = 1; rows <= kernels.tile_rows; ++rows) {
        const std::size_t width = registers * kernels.lanes;
        nn::Buffer<TestType> out(rows * width);
        nn::ReduceArguments<TestType> tile{
            in.data(), 40, 20, 1, weights.data(), 2, 20, out.data(), static_cast<std::ptrdiff_t>(width),
            width - 1, {}};
        out.fill_zero();
        kernels.reduce[registers - 1][rows - 1](tile);
        for (std::size_t p = 0; p < rows; ++p)
          for (std::size_t lane = 0; lane < width; ++lane) {
            double expected = 0;
            for (std::size_t r = 0; r < 40; ++r)
              expected += static_cast<double>(in.data()[p * 40 + r]) *
                          static_cast<double>(weights.data()[r * width + lane]) * (lane + 1 < width);
            CHECK(std::abs(static_cast<double>(out.data()[p * width + lane]) - expected) < tolerance);
          }
      }
  }
}

TEMPLATE_TEST_CASE("a window of a convolution has the bits of the whole one, and needs no more than it says",
                   "[nn][convolution][repeated]", float, double) {
  auto all = shapes();
  all.push_back(nn::square_convolution(21, 26, 32, 40, 3, 1, 1));    // large enough for every engine's tiles
  all.push_back(nn::square_convolution(22, 25, 70, 32, 3, 2, 1));    // and tiles of a stride's adjoint
  all.push_back(nn::square_convolution(9, 12, 256, 16, 3, 1, 1));    // inputs are copied with a gap
  all.push_back(nn::square_convolution(13, 13, 256, 128, 1, 1, 0));  // not at all
  const auto engine = GENERATE(nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2,
                               nn::Engine::winograd_f4, nn::Engine::bfloat16);
  for (const nn::ConvolutionShape& s : all) {
    CAPTURE(nn::name_of(engine), s.rows.input, s.columns.input, s.in_channels, s.out_channels, s.rows.taps,
            s.rows.stride, s.groups);
    const auto weights = random_buffer<TestType>(s.weight_count(), 2);
    const auto weight_at = [&](std::size_t i) { return weights.data()[i]; };
    check_windows(engine, nn::pack_convolution<TestType>(s, weight_at), s.rows.output);
    for (const auto& part : nn::pack_convolution_adjoint<TestType>(s, weight_at))
      check_windows(engine, part, s.rows.input);
  }
}

TEST_CASE("the outputs that a range reaches, and the inputs that one needs, are the fewest by the definition",
          "[nn][convolution]") {
  std::vector<nn::AxisWindow> axes;
  for (const nn::ConvolutionShape& s : shapes()) {
    for (const nn::AxisWindow& axis : {s.rows, s.columns}) {
      axes.push_back(axis);
      for (const auto& part : nn::adjoint_of(axis)) axes.push_back(part.window);
    }
  }
  axes.push_back({4, 5, 2, 2, 1, 8});  // some outputs read nothing
  std::size_t wrong = 0;
  for (const nn::AxisWindow& axis : axes) {
    const auto first_of = [&](std::size_t output) {
      return static_cast<std::ptrdiff_t>(output * axis.stride) - axis.padding;
    };
    const auto end_of = [&](std::size_t output) {
      return first_of(output) + static_cast<std::ptrdiff_t>((axis.taps - 1) * axis.spacing + 1);
    };
    for (std::size_t begin = 0; begin < axis.input; ++begin)
      for (std::size_t end = begin + 1; end <= axis.input; ++end) {
        const auto reached = nn::outputs_reached(axis, {}, {begin, end});
        if (reached.begin >= reached.end || reached.end > axis.output) ++wrong;
        for (std::size_t k = 0; k < axis.output; ++k) {
          const bool reads = first_of(k) < static_cast<std::ptrdiff_t>(end) &&
                             end_of(k) > static_cast<std::ptrdiff_t>(begin);
          const bool is_inside = k >= reached.begin && k < reached.end;
          const bool is_only_one = reached.end - reached.begin == 1;  // one at least, whatever it reads
          if (reads != is_inside && !(is_inside && is_only_one)) ++wrong;
        }
      }
    const auto clamped = [&](std::ptrdiff_t place) {
      return static_cast<std::size_t>(
          std::clamp(place, std::ptrdiff_t(0), static_cast<std::ptrdiff_t>(axis.input)));
    };
    for (std::size_t begin = 0; begin < axis.output; ++begin)
      for (std::size_t end = begin + 1; end <= axis.output; ++end) {
        const auto needed = nn::inputs_needed(axis, {}, {begin, end});
        if (needed.begin != clamped(first_of(begin)) || needed.end != clamped(end_of(end - 1))) ++wrong;
      }
  }
  CHECK(wrong == 0);
  // A tile of four outputs and three taps reads inputs 4k - 1 to 4k + 4.
  const nn::AxisWindow axis{12, 12, 3, 1, 1, 1};
  const nn::OutputTile tile{4, 1, 1};
  const auto is = [](tapestry::BlockRange found, std::size_t begin, std::size_t end) {
    return found.begin == begin && found.end == end;
  };
  CHECK(is(nn::outputs_reached(axis, tile, {4, 8}), 3, 9));
  CHECK(is(nn::outputs_reached(axis, tile, {3, 9}), 0, 12));
  CHECK(is(nn::inputs_needed(axis, tile, {4, 8}), 3, 9));
  CHECK(is(nn::inputs_needed(axis, tile, {5, 7}), 4, 8));
}
