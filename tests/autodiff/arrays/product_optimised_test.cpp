#include <tapestry/autodiff/detail/arrays/product.hpp>

#include <tapestry/autodiff/detail/arrays/reduction.hpp>
#include <tapestry/autodiff/detail/arrays/view.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"
#include "../../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::test::ActiveTape, tapestry::test::random_array;

namespace {
/// Σ_k a(i, k) · b(k, j) + c(i, j) in long double, to compare with `product`.
template <class T, class Product>
void check_product(std::size_t rows, std::size_t depth, std::size_t columns, bool is_turned,
                   const Product& product) {
  const auto a = random_array<T>({rows, depth}, 1, -1, 1), b = random_array<T>({depth, columns}, 2, -1, 1);
  const auto start = random_array<T>({rows, columns}, 3, -1, 1);
  Array<T, 2> turned(tapestry::Extents<2>{depth, rows}), c = start;
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k < depth; ++k) turned(k, i) = a(i, k);
  if (is_turned)
    product({turned.data(), 1, rows, b.data(), c.data(), rows, depth, columns});
  else
    product({a.data(), depth, 1, b.data(), c.data(), rows, depth, columns});
  long double worst = 0;
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      auto sum = static_cast<long double>(start(i, j));
      for (std::size_t k = 0; k < depth; ++k)
        sum += static_cast<long double>(a(i, k)) * static_cast<long double>(b(k, j));
      worst = std::max(worst, std::abs(sum - static_cast<long double>(c(i, j))));
    }
  // A sum of depth + 1 terms of at most 1, each partial sum rounded: (depth + 1)² · ε / 2.
  const auto terms = static_cast<long double>(depth + 1);
  CHECK(worst <= terms * terms * static_cast<long double>(std::numeric_limits<T>::epsilon()) / 2);
}

template <class T, class Product>
void check_extents(const Product& product) {
  for (const std::size_t rows : {1U, 3U, 4U, 9U})
    for (const std::size_t columns : {1U, 3U, 4U, 7U, 8U, 15U, 16U, 17U, 31U, 32U, 48U, 67U})
      for (const std::size_t depth : {0U, 1U, 5U})
        for (const bool is_turned : {false, true}) check_product<T>(rows, depth, columns, is_turned, product);
  check_product<T>(0, 3, 5, false, product);
  check_product<T>(5, 3, 0, false, product);
}
}  // namespace

TEMPLATE_TEST_CASE("every instruction set multiplies matrices of any extents", "[autodiff][product]", float,
                   double) {
  using T = TestType;
  using Arguments = tapestry::detail::ProductArguments<T>;
  for (const auto set : tapestry::instruction_sets())
    check_extents<T>([set](const Arguments& p) { tapestry::detail::add_product(p, set); });
}

TEST_CASE("a product of matrices on the tape satisfies the adjoint identity", "[autodiff][product]") {
  ActiveTape<double> tape;
  const ArrayVariable<double, 2> a = tape.input(random_array<double>({5, 7}, 1, -1, 1));
  const ArrayVariable<double, 2> b = tape.input(random_array<double>({7, 19}, 2, -1, 1));
  const auto seed = random_array<double>({5, 19}, 3, -1, 1);
  const auto a_step = random_array<double>({5, 7}, 4, -1, 1),
             b_step = random_array<double>({7, 19}, 5, -1, 1);
  tape.reverse(matmul(a, b), seed);
  double left = 0, right = 0;  // ⟨seed, A' B + A B'⟩ and ⟨adjoints, steps⟩
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 19; ++j)
      for (std::size_t k = 0; k < 7; ++k)
        left += seed(i, j) * (a_step(i, k) * b.value()(k, j) + a.value()(i, k) * b_step(k, j));
  for (std::size_t i = 0; i < a.size(); ++i) right += a.adjoint().data()[i] * a_step.data()[i];
  for (std::size_t i = 0; i < b.size(); ++i) right += b.adjoint().data()[i] * b_step.data()[i];
  CHECK(std::abs(left - right) <= 1e-12);
}

TEST_CASE("columns that are alike have sums that are alike, to the bit", "[autodiff][product]") {
  constexpr std::size_t rows = 5, depth = 40, columns = 2 * 16 + 16 + 3;
  std::vector<float> a(rows * depth), b(depth * columns), c(rows * columns, 1e8F);
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = static_cast<float>(i % 7) - 3;
  for (std::size_t i = 0; i < b.size(); ++i) b[i] = 1 + static_cast<float>(i / columns % 3);
  tapestry::detail::add_product(tapestry::detail::ProductArguments<float>{a.data(), depth, 1, b.data(),
                                                                          c.data(), rows, depth, columns});
  for (std::size_t i = 0; i < c.size(); ++i) CHECK(c[i] == c[i / columns * columns]);
}
