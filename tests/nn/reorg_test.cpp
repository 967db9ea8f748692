#include <tapestry/nn/reorg.hpp>

#include <algorithm>
#include <numeric>
#include <vector>

#include "../support/catch.hpp"

namespace nn = tapestry::nn;

namespace {
std::vector<double> counted(std::size_t count) {
  std::vector<double> values(count);
  std::iota(values.begin(), values.end(), 0.0);
  return values;
}

/// [H, W, C] to [C, H, W].
std::vector<double> channels_first(const std::vector<double>& in, std::size_t pixels, std::size_t channels) {
  std::vector<double> out(in.size());
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t p = 0; p < pixels; ++p) out[c * pixels + p] = in[p * channels + c];
  return out;
}

/// The same with channels first, as the inverse of what spreads [C, H, W] over [C / s², s·H, s·W].
std::vector<double> reorganised_planes(const nn::ReorgShape& shape, const std::vector<double>& in) {
  const std::size_t s = shape.stride, folded = shape.channels / (s * s);
  std::vector<double> out;
  for (std::size_t dy = 0; dy < s; ++dy)
    for (std::size_t dx = 0; dx < s; ++dx)
      for (std::size_t c = 0; c < folded; ++c)
        for (std::size_t y = dy; y < s * shape.height; y += s)
          for (std::size_t x = dx; x < s * shape.width; x += s)
            out.push_back(in[(c * s * shape.height + y) * s * shape.width + x]);
  return out;
}
}  // namespace

TEST_CASE("reorg of 2 x 2 pixels of 4 channels is Darknet's by hand", "[nn][reorg]") {
  // Channel c holds c0, c1, c2, c3 in its pixels. Darknet's list 00 01 02 03 10 … 33, read as 4 x 4, gives
  // its even rows' even columns, odd columns, then its odd rows': 00 02 20 22, 01 03 21 23, 10 12 30 32, …
  const nn::ReorgShape shape{2, 2, 4, 2};
  const std::vector<double> in{0, 10, 20, 30, 1, 11, 21, 31, 2, 12, 22, 32, 3, 13, 23, 33};
  std::vector<double> out(16);
  nn::reorg(shape, 1, in.data(), out.data());
  CHECK(out == std::vector<double>{0, 2, 20, 22, 1, 3, 21, 23, 10, 12, 30, 32, 11, 13, 31, 33});
}

TEST_CASE("reorg takes apart what spreads channels over pixels", "[nn][reorg]") {
  const auto shape =
      GENERATE(nn::ReorgShape{6, 4, 8, 2}, nn::ReorgShape{4, 10, 16, 2}, nn::ReorgShape{3, 6, 18, 3},
               nn::ReorgShape{5, 3, 2, 1}, nn::ReorgShape{8, 4, 16, 4});
  const std::size_t s = shape.stride, count = shape.size();
  const auto in = counted(2 * count);
  std::vector<double> out(2 * count, -1);
  nn::reorg(shape, 2, in.data(), out.data());
  for (std::size_t n = 0; n < 2; ++n) {
    const auto first = static_cast<std::ptrdiff_t>(n * count),
               last = static_cast<std::ptrdiff_t>((n + 1) * count);
    const std::vector<double> image(in.begin() + first, in.begin() + last),
        found(out.begin() + first, out.begin() + last);
    CHECK(channels_first(found, shape.height * shape.width / (s * s), shape.channels * s * s) ==
          reorganised_planes(shape, channels_first(image, shape.height * shape.width, shape.channels)));
    CHECK(std::is_permutation(found.begin(), found.end(), image.begin()));
  }
}

TEST_CASE("space to depth puts each block's pixels behind each other", "[nn][reorg]") {
  const auto shape = GENERATE(nn::ReorgShape{4, 6, 3, 2, nn::ReorgOrder::space_to_depth},
                              nn::ReorgShape{6, 3, 2, 3, nn::ReorgOrder::space_to_depth});
  const std::size_t s = shape.stride, width = shape.width / s, channels = shape.channels * s * s;
  const auto in = counted(2 * shape.size());
  std::vector<double> out(in.size(), -1);
  nn::reorg(shape, 2, in.data(), out.data());
  for (std::size_t n = 0; n < 2; ++n)
    for (std::size_t y = 0; y < shape.height; ++y)
      for (std::size_t x = 0; x < shape.width; ++x)
        for (std::size_t c = 0; c < shape.channels; ++c) {
          const std::size_t from = n * shape.size() + (y * shape.width + x) * shape.channels + c;
          const std::size_t channel = (y % s * s + x % s) * shape.channels + c;
          CHECK(out[n * shape.size() + (y / s * width + x / s) * channels + channel] == in[from]);
        }
}

TEMPLATE_TEST_CASE("reorg_adjoint adds what reorg took, back where it came from", "[nn][reorg]", float,
                   double) {
  const nn::ReorgShape shape{4, 6, 8, 2, GENERATE(nn::ReorgOrder::darknet, nn::ReorgOrder::space_to_depth)};
  const auto counting = counted(2 * shape.size());
  const std::vector<TestType> in(counting.begin(), counting.end());
  std::vector<TestType> out(in.size()), back(in.size(), TestType(0.5));
  nn::reorg(shape, 2, in.data(), out.data());
  for (int half = 0; half < 2; ++half) nn::reorg_adjoint(shape, 2, out.data(), back.data());
  for (std::size_t i = 0; i < in.size(); ++i) CHECK(back[i] == 2 * in[i] + TestType(0.5));
}
