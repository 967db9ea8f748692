#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/pooling.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include "../support/catch.hpp"

namespace nn = tapestry::nn;

namespace {
template <class T>
struct Pooled {
  std::vector<T> values;
  std::vector<long> choices;
};

template <class T>
Pooled<T> pooled(const nn::PoolingShape& shape, const std::vector<T>& picture) {
  nn::Buffer<T> in(shape.in_size());
  std::copy(picture.begin(), picture.end(), in.data());
  nn::Buffer<T> out(shape.out_size());
  nn::Buffer<nn::Position<T>> choice(shape.out_size());
  nn::max_pool<T>(shape, 1, in.data(), out.data(), choice.data());
  return {{out.data(), out.data() + out.size()}, {choice.data(), choice.data() + choice.size()}};
}
}  // namespace

TEMPLATE_TEST_CASE("max-pooling of stride one extends right and down", "[nn][pooling]", float, double) {
  const nn::PoolingShape shape{2, 3, 2, 3, 1, 2, 1, 0};
  const auto result = pooled<TestType>(shape, {-5, -2, -3, -1, -4, -6});
  CHECK(result.values == std::vector<TestType>{-1, -2, -3, -1, -4, -6});
  CHECK(result.choices == std::vector<long>{3, 1, 2, 3, 4, 5});
}

TEMPLATE_TEST_CASE("max-pooling takes the first of equal values", "[nn][pooling]", float, double) {
  const nn::PoolingShape shape{2, 2, 1, 1, 3, 2, 2, 0};
  const auto result = pooled<TestType>(shape, {1, 0, 7, 1, 2, 7, 1, 2, 7, 0, 2, 7});
  CHECK(result.values == std::vector<TestType>{1, 2, 7});
  CHECK(result.choices == std::vector<long>{0, 1, 0});
}

TEMPLATE_TEST_CASE("max-pooling lets NaN through and takes minus infinity", "[nn][pooling]", float, double) {
  const auto nan = std::numeric_limits<TestType>::quiet_NaN();
  const auto infinity = std::numeric_limits<TestType>::infinity();
  const nn::PoolingShape shape{1, 4, 1, 2, 1, 2, 2, 0};
  const auto result = pooled<TestType>(shape, {5, nan, -infinity, -infinity});
  CHECK(std::isnan(result.values[0]));
  CHECK(result.choices[0] == 1);
  CHECK(result.values[1] == -infinity);
  CHECK(result.choices[1] == 2);
}

TEST_CASE("the adjoint of max-pooling goes to the chosen pixels", "[nn][pooling]") {
  const nn::PoolingShape shape{3, 3, 3, 3, 1, 3, 1, 1};  // as in spatial pyramid pooling
  const auto result = pooled<double>(shape, {1, 2, 3, 4, 9, 5, 6, 7, 8});
  CHECK(result.values == std::vector<double>(9, 9.0));
  std::vector<nn::Position<double>> choice(result.choices.begin(), result.choices.end());
  const std::vector<double> adjoint = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  std::vector<double> in_adjoint(9, 1.0);
  nn::max_pool_adjoint<double>(shape, 1, choice.data(), adjoint.data(), in_adjoint.data());
  CHECK(in_adjoint == std::vector<double>{1, 1, 1, 1, 46, 1, 1, 1, 1});
}
