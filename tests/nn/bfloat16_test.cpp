#include <tapestry/nn/detail/bfloat16.hpp>
#include <tapestry/nn/engine.hpp>

#include "../support/random_buffer.hpp"
#include "../support/relative_distance.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// The nearer of the two bfloat16 around a value, of equally near ones the even one; as a float.
float rounded(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  if (std::isnan(value)) return value;
  if (std::fpclassify(value) == FP_SUBNORMAL) return std::copysign(0.0F, value);
  const float below = std::bit_cast<float>(bits & 0xffff0000U);  // towards zero
  const std::uint32_t next = (bits & 0xffff0000U) + 0x10000U;
  const auto size = [](std::uint32_t of) {  // 2^128 where a float has infinity
    const float as_float = std::bit_cast<float>(of & 0x7fffffffU);
    return std::isinf(as_float) ? std::ldexp(1.0, 128) : static_cast<double>(as_float);
  };
  if (std::isinf(value)) return value;
  const double down = std::abs(static_cast<double>(value)) - size(bits & 0xffff0000U);
  const double up = size(next) - std::abs(static_cast<double>(value));
  if (down < up) return below;
  if (down > up) return std::bit_cast<float>(next);
  return (bits >> 16 & 1U) == 0 ? below : std::bit_cast<float>(next);
}

bool is_same(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

/// The two of a word.
std::pair<float, float> halves(float word) {
  const auto bits = std::bit_cast<std::uint32_t>(word);
  return {std::bit_cast<float>(bits << 16), std::bit_cast<float>(bits & 0xffff0000U)};
}

/// Everything that rounding may get wrong, and many others.
std::vector<float> hard_values() {
  std::vector<float> values;
  for (const std::uint32_t bits :
       {0x00000000U, 0x00000001U, 0x00007fffU, 0x00008000U, 0x007fffffU, 0x00800000U, 0x00808000U,
        0x3f7f8000U, 0x3f800000U, 0x3f807fffU, 0x3f808000U, 0x3f808001U, 0x3f817fffU, 0x3f818000U,
        0x3f818001U, 0x3fff8000U, 0x7f7f0000U, 0x7f7f7fffU, 0x7f7f8000U, 0x7f7fffffU, 0x7f800000U,
        0x7f800001U, 0x7f80ffffU, 0x7fc00000U, 0x7fffffffU})
    for (const std::uint32_t sign : {0U, 0x80000000U}) values.push_back(std::bit_cast<float>(bits | sign));
  Random random(7);
  while (values.size() < 640)
    values.push_back(std::bit_cast<float>(static_cast<std::uint32_t>(random.index(std::size_t(1) << 32U))));
  return values;
}

/// The kernels of every instruction set of this machine; the best set's kernels use the machine's
/// instructions for bfloat16 if it has them; the others emulate them.
std::vector<nn::Kernels<float>> all_kernels() {
  std::vector<nn::Kernels<float>> all;
  for (const auto set : tapestry::instruction_sets()) all.push_back(nn::kernels_of<float>(set));
  return all;
}

nn::Buffer<float> convolved(nn::Engine engine, const nn::ConvolutionShape& s, const nn::Buffer<float>& in,
                            const nn::Buffer<float>& weights) {
  const auto packed = nn::pack_convolution<float>(s, [&](std::size_t i) { return weights.data()[i]; });
  nn::Buffer<float> out(s.out_size());
  nn::convolve<float>(engine, packed, 1, in.data(), {}, out.data(), s.out_size());
  return out;
}

/// out[y, x, m] by the definition, in the order of the kernels; `used(value)` converts an operand.
template <class Sum, class Used>
std::vector<Sum> summed(const nn::ConvolutionShape& s, const nn::Buffer<float>& in,
                        const nn::Buffer<float>& weights, Used used) {
  std::vector<Sum> out;
  const float *values = in.data(), *all_weights = weights.data();
  for (std::size_t oy = 0; oy < s.rows.output; ++oy)
    for (std::size_t ox = 0; ox < s.columns.output; ++ox)
      for (std::size_t m = 0; m < s.out_channels; ++m) {
        Sum sum = 0;
        for (std::size_t ty = 0; ty < s.rows.taps; ++ty)
          for (std::size_t tx = 0; tx < s.columns.taps; ++tx) {
            const std::size_t y = oy * s.rows.stride + ty - static_cast<std::size_t>(s.rows.padding);
            const std::size_t x = ox * s.columns.stride + tx - static_cast<std::size_t>(s.columns.padding);
            const bool is_inside = y < s.rows.input && x < s.columns.input;
            for (std::size_t c = 0; c < s.in_channels; c += 2)
              for (std::size_t i = std::min(c + 1, s.in_channels - 1) + 1; i-- > c;) {
                const float weight =
                    all_weights[((m * s.in_channels + i) * s.rows.taps + ty) * s.columns.taps + tx];
                const float value = is_inside ? values[(y * s.columns.input + x) * s.in_channels + i] : 0;
                sum += static_cast<Sum>(used(value)) * static_cast<Sum>(used(weight));
              }
          }
        out.push_back(sum);
      }
  return out;
}
}  // namespace

TEST_CASE("operands are rounded to the nearest bfloat16, by every instruction set", "[nn][bfloat16]") {
  auto values = hard_values();
  nn::Buffer<float> first(values.size()), words(values.size());
  for (const auto& kernels : all_kernels()) {
    for (const std::size_t count : {values.size(), std::size_t(1), std::size_t(2), std::size_t(37)}) {
      std::copy(values.begin(), values.end(), first.data());
      for (std::size_t i = 0; i < values.size(); ++i) words.data()[i] = 42;
      kernels.pair_neighbours(first.data(), count, words.data());
      std::size_t wrong = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const auto [even, odd] = halves(words.data()[i / 2]);
        if (!is_same(i % 2 == 0 ? even : odd, rounded(values[i]))) ++wrong;
      }
      if (count % 2 != 0) CHECK(is_same(halves(words.data()[count / 2]).second, 0));
      CHECK(words.data()[(count + 1) / 2] == 42);
      CHECK(wrong == 0);
    }
    kernels.pair_rows(first.data(), first.data() + 320, 320, words.data());
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < 320; ++i) {
      const auto [even, odd] = halves(words.data()[i]);
      if (!is_same(even, rounded(values[i])) || !is_same(odd, rounded(values[i + 320]))) ++wrong;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("sums of pairs have the same bits with and without instructions for them", "[nn][bfloat16]") {
  constexpr std::size_t pairs = 40;
  const auto in = random_buffer<float>(12 * 2 * pairs, 1);
  const auto weights = random_buffer<float>(2 * pairs * 32, 2);
  for (const float special :
       {1.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(), 1e38F, 1e-41F})
    for (const auto& kernels : all_kernels()) {
      nn::Buffer<float> values(in.size()), words(12 * pairs), filters(pairs * 32);
      std::copy_n(in.data(), in.size(), values.data());
      values.data()[7] = special;
      kernels.pair_neighbours(values.data(), values.size(), words.data());
      for (std::size_t registers = 1; registers <= 2; ++registers) {
        const std::size_t width = registers * kernels.lanes;
        for (std::size_t p = 0; p < pairs; ++p)
          kernels.pair_rows(weights.data() + 2 * p * 32, weights.data() + (2 * p + 1) * 32, width,
                            filters.data() + p * width);
        for (std::size_t rows = 1; rows <= kernels.tile_rows; ++rows) {
          nn::Buffer<float> out(rows * width);
          kernels.reduce_pairs[registers - 1][rows - 1](
              {words.data(), pairs, pairs / 2, 1, filters.data(), 2, pairs / 2, out.data(),
               static_cast<std::ptrdiff_t>(width), width, nn::Epilogue<float>()});
          std::size_t wrong = 0;
          for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t lane = 0; lane < width; ++lane) {
              float sum = 0;
              for (std::size_t p = 0; p < pairs; ++p)
                for (const std::size_t i : {2 * p + 1, 2 * p})
                  sum = std::fma(rounded(values.data()[row * 2 * pairs + i]),
                                 rounded(weights.data()[i * 32 + lane]), sum);
              if (!is_same(sum, out.data()[row * width + lane])) ++wrong;
            }
          CHECK(wrong == 0);
        }
      }
    }
}

TEST_CASE("a convolution in bfloat16 is the sum of rounded operands, bit for bit", "[nn][bfloat16]") {
  for (const auto& s :
       {nn::square_convolution(1, 1, 3, 5, 3, 1, 1), nn::square_convolution(1, 1, 255, 7, 1, 1, 0),
        nn::square_convolution(7, 5, 3, 16, 3, 2, 1), nn::square_convolution(13, 13, 5, 255, 1, 1, 0),
        nn::square_convolution(9, 6, 24, 40, 3, 2, 1), nn::square_convolution(4, 5, 1, 33, 3, 1, 1),
        nn::square_convolution(20, 30, 8, 8, 1, 1, 0), nn::square_convolution(9, 10, 6, 7, 1, 2, 0)}) {
    CAPTURE(s.in_channels, s.out_channels, s.rows.input, s.rows.taps);
    const auto in = random_buffer<float>(s.in_size(), 1);
    const auto weights = random_buffer<float>(s.weight_count(), 2);
    const auto found = convolved(nn::Engine::bfloat16, s, in, weights);
    const auto expected = summed<float>(s, in, weights, rounded);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) wrong += found.data()[i] != expected[i];
    CHECK(wrong == 0);
  }
}

TEST_CASE("long sums in bfloat16 are as accurate as their rounded operands", "[nn][bfloat16]") {
  for (const auto& s :
       {nn::square_convolution(8, 8, 301, 17, 3, 2, 1), nn::square_convolution(5, 5, 1024, 9, 1, 1, 0),
        nn::square_convolution(6, 6, 300, 18, 3, 2, 0)}) {
    const auto in = random_buffer<float>(s.in_size(), 1);
    const auto weights = random_buffer<float>(s.weight_count(), 2);
    const auto found = convolved(nn::Engine::bfloat16, s, in, weights);
    const auto expected = summed<double>(s, in, weights, rounded);
    CHECK(relative_distance(found.data(), expected.data(), expected.size()) < 1e-6);
  }
}

TEST_CASE("the error of one layer in bfloat16 is below 2.5e-3, by tiles below 1.2e-2", "[nn][bfloat16]") {
  const auto one = [](float value) { return value; };
  for (const std::size_t channels : {16U, 64U, 256U})
    for (const std::size_t stride : {1U, 2U}) {
      const auto s = nn::square_convolution(14, 14, channels, 64, 3, stride, 1);
      const auto in = random_buffer<float>(s.in_size(), 1);
      const auto weights = random_buffer<float>(s.weight_count(), 2);
      const auto packed = nn::pack_convolution<float>(s, [&](std::size_t i) { return weights.data()[i]; });
      const bool has_tiles = nn::detail::winograd_form(nn::Engine::bfloat16, packed).has_value();
      CHECK(has_tiles == (stride == 1));
      const auto expected = summed<double>(s, in, weights, one);
      const auto found = convolved(nn::Engine::bfloat16, s, in, weights);
      const double error = relative_distance(found.data(), expected.data(), expected.size());
      CAPTURE(channels, stride);
      CHECK(error < (has_tiles ? 1.2e-2 : 2.5e-3));
      CHECK(error > 1e-4);  // it is rounded at all

      // The adjoint's parts: one by tiles for a stride of 1, else four, with tiles of two taps too.
      nn::Buffer<float> adjoint(s.in_size()), exact(s.in_size());
      for (const auto& part :
           nn::pack_convolution_adjoint<float>(s, [&](std::size_t i) { return weights.data()[i]; })) {
        nn::convolve<float>(nn::Engine::bfloat16, part, 1, found.data(), {}, adjoint.data(), s.in_size());
        nn::convolve<float>(nn::Engine::direct, part, 1, found.data(), {}, exact.data(), s.in_size());
      }
      CHECK(relative_distance(adjoint.data(), exact.data(), s.in_size()) < 1.2e-2);
    }
}

TEST_CASE("tiles of pairs are transformed alike by every instruction set", "[nn][bfloat16]") {
  const auto in = random_buffer<float>(36 * 16, 1);
  const auto weights = random_buffer<float>(9 * 2 * 16, 2);
  const float* pixels[36];
  for (std::size_t i = 0; i < 36; ++i) pixels[i] = in.data() + i * 16;
  for (std::size_t which = 0; which < nn::winograd_form_count; ++which) {
    const auto axis = nn::extents_of(static_cast<nn::WinogradForm>(which));
    const std::size_t count = axis.points * axis.points;
    const auto transformed = [&](const nn::Kernels<float>& kernels) {
      nn::Buffer<float> words(count * (8 + 16));
      kernels.winograd_input_pairs[which]({pixels, 0, 16, words.data(), 8});
      kernels.winograd_filter_pairs[which]({weights.data(), 2 * 16, 2, 16, words.data() + count * 8, 16});
      return words;
    };
    nn::Buffer<float> values(count * 16), filters(count * 2 * 16);
    const auto portable = nn::kernels_of<float>(nn::InstructionSet::portable);
    portable.winograd_input[which]({pixels, 0, 16, values.data(), 16});
    portable.winograd_filters[which]({weights.data(), 2 * 16, 2, 16, filters.data(), 2 * 16});
    for (const auto& kernels : all_kernels()) {
      const auto words = transformed(kernels);
      std::size_t wrong = 0;
      const auto compare = [&](float found, float exact) {
        const bool is_near = std::abs(found - exact) <= std::abs(exact) / 256 + 1e-6F;
        // {0, ±1, ∞} takes sums alone, with the same bits everywhere.
        if (which == 0 ? found != rounded(exact) : !is_near) ++wrong;
      };
      for (std::size_t point = 0; point < count; ++point) {
        for (std::size_t c = 0; c < 16; ++c) {
          const auto [even, odd] = halves(words.data()[point * 8 + c / 2]);
          compare(c % 2 == 0 ? even : odd, values.data()[point * 16 + c]);
        }
        for (std::size_t lane = 0; lane < 16; ++lane) {
          const auto [even, odd] = halves(words.data()[count * 8 + point * 16 + lane]);
          compare(even, filters.data()[point * 32 + lane]);
          compare(odd, filters.data()[point * 32 + 16 + lane]);
        }
      }
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("NaN and infinity reach every output in bfloat16 that reads them", "[nn][bfloat16]") {
  const std::size_t channels = GENERATE(5U, 6U);
  const auto s = nn::square_convolution(23, 26, channels, 40, 3, 1, 1);
  auto in = random_buffer<float>(s.in_size(), 1);
  const auto weights = random_buffer<float>(s.weight_count(), 2);
  in.data()[(10 * 26 + 7) * channels + channels - 1] =
      GENERATE(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
               std::numeric_limits<float>::max());  // which rounds to infinity
  const auto out = convolved(nn::Engine::bfloat16, s, in, weights);
  bool is_visible = true, is_finite_elsewhere = true;
  for (std::size_t y = 0; y < 23; ++y)
    for (std::size_t x = 0; x < 26; ++x)
      for (std::size_t m = 0; m < 40; ++m) {
        const bool is_finite = std::isfinite(out.data()[(y * 26 + x) * 40 + m]);
        const bool reads = y >= 9 && y <= 11 && x >= 6 && x <= 8;
        const bool is_far = y > 10 + 5 || y + 5 < 10 || x > 7 + 5 || x + 5 < 7;  // no tile reaches further
        is_visible = is_visible && !(reads && is_finite);
        is_finite_elsewhere = is_finite_elsewhere && (!is_far || is_finite);
      }
  CHECK(is_visible);
  CHECK(is_finite_elsewhere);
}

TEST_CASE("subnormal operands count as zero in bfloat16, and large ones keep their magnitude",
          "[nn][bfloat16]") {
  const auto s = nn::square_convolution(12, 12, 6, 40, 3, GENERATE(1U, 2U), 1);
  nn::Buffer<float> in(s.in_size()), weights(s.weight_count());
  for (std::size_t i = 0; i < weights.size(); ++i) weights.data()[i] = 0.25F;
  for (const auto& [value, expected] : {std::pair{1e-39F, 0.0F}, std::pair{0x1p120F, 54 * 0x1p118F}}) {
    for (std::size_t i = 0; i < in.size(); ++i) in.data()[i] = value;
    const auto out = convolved(nn::Engine::bfloat16, s, in, weights);
    const float centre = out.data()[(2 * s.columns.output + 2) * 40 + 1];
    CHECK(std::abs(centre - expected) <= 8e-3F * expected);
  }
}

TEST_CASE("what takes no pairs has the bits of the automatic engine", "[nn][bfloat16]") {
  for (const auto& s : {nn::square_convolution(8, 11, 12, 18, 3, 1, 1, 1, 3),   // groups
                        nn::square_convolution(11, 8, 20, 20, 5, 1, 2, 1, 20),  // depthwise
                        nn::square_convolution(17, 30, 8, 3, 3, 1, 1)}) {       // few channels out
    const auto in = random_buffer<float>(s.in_size(), 1);
    const auto weights = random_buffer<float>(s.weight_count(), 2);
    const auto found = convolved(nn::Engine::bfloat16, s, in, weights);
    const auto expected = convolved(nn::Engine::automatic, s, in, weights);
    CHECK(std::equal(found.data(), found.data() + found.size(), expected.data()));
  }
  const auto s = nn::square_convolution(9, 9, 16, 16, 3, 1, 1);  // double
  const auto in = random_buffer<double>(s.in_size(), 1);
  const auto packed =
      nn::pack_convolution<double>(s, [](std::size_t i) { return std::sin(static_cast<double>(i)); });
  nn::Buffer<double> found(s.out_size()), expected(s.out_size());
  nn::convolve<double>(nn::Engine::bfloat16, packed, 1, in.data(), {}, found.data(), s.out_size());
  nn::convolve<double>(nn::Engine::automatic, packed, 1, in.data(), {}, expected.data(), s.out_size());
  CHECK(std::equal(found.data(), found.data() + found.size(), expected.data()));
}
