// The Hessian of a banded problem of many variables: its time grows with their number, not with its square.
#include <benchmark/benchmark.h>

#include <tapestry/autodiff/sparse_hessian.hpp>

namespace {
using tapestry::HessianPlan, tapestry::JacobianPattern;

/// Σ (x[i + 1] − x[i]²)² + (1 − x[i])² + x[i] x[i + 2] / 8, of half width 2.
const auto chain = []<class S>(std::span<const S> x) {
  S sum = 0;
  for (std::size_t i = 0; i + 2 < x.size(); ++i) {
    const S step = x[i + 1] - x[i] * x[i];
    sum += step * step + (1 - x[i]) * (1 - x[i]) + x[i] * x[i + 2] / 8;
  }
  return sum;
};

HessianPlan plan_of(std::size_t n) {
  std::vector<JacobianPattern::Entry> entries;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n && j <= i + 2; ++j) entries.push_back({i, j});
  return HessianPlan(JacobianPattern(n, n, entries));
}

void finding_the_pattern(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  const std::vector<double> x(n, 0.5);
  JacobianPattern found;
  for (auto _ : state) found = tapestry::hessian_pattern(chain, x);
  if (found.entry_count() != 5 * n - 9) state.SkipWithError("a wrong pattern");
  state.SetComplexityN(state.range(0));
}

void planning(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(plan_of(n).direction_count());
  state.SetComplexityN(state.range(0));
}

void evaluation(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  const HessianPlan plan = plan_of(n);
  std::vector<double> x(n, 0.5), values;
  for (auto _ : state) {
    values = tapestry::sparse_hessian(chain, x, plan);
    benchmark::DoNotOptimize(values.data());
  }
  const std::size_t middle = n / 2;  // 2 + 12 x² − 4 x + 2, by hand
  plan.pattern().visit([&](std::size_t row, std::size_t column, std::size_t number) {
    if (row == middle && column == middle && !(std::abs(values[number] - 5) <= 1e-14))
      state.SkipWithError("a wrong entry");
  });
  state.counters["directions"] = static_cast<double>(plan.direction_count());
  state.SetComplexityN(state.range(0));
}
}  // namespace

BENCHMARK(finding_the_pattern)
    ->RangeMultiplier(10)
    ->Range(1000, 100000)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();
BENCHMARK(planning)->RangeMultiplier(10)->Range(1000, 100000)->Unit(benchmark::kMillisecond)->Complexity();
BENCHMARK(evaluation)->RangeMultiplier(10)->Range(1000, 100000)->Unit(benchmark::kMillisecond)->Complexity();
