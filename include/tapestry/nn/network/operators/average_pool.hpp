#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/nn/network/operator_table.hpp>
#include <tapestry/nn/network/operators/max_pool.hpp>
#include <tapestry/nn/network/operators/pooling_plan.hpp>
#include <utility>
#include <vector>

namespace tapestry::nn {

/// AveragePool and GlobalAveragePool.
template <std::floating_point T>
class AveragePool : public Operation<T> {
 public:
  /// \param counts_padding  zeros around the picture count as values
  AveragePool(PoolingPlan plan, bool counts_padding)
      : Operation<T>({{plan.out_shape(), ElementType::floating}}),
        plan_(std::move(plan)),
        counts_padding_(counts_padding) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    plan_.for_each_output([&](std::size_t first, std::size_t to, const WindowTaps& row,
                              const WindowTaps& column) {
      std::vector<double> total;
      std::size_t summed = 0;
      plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
        if (summed == most_in_t) join(out + to, total, summed);
        if (summed++ == 0) {
          std::copy_n(in + tap, plan_.channels, out + to);
        } else {
          kernels<T>().add(in + tap, out + to, plan_.channels);
        }
      });
      if (summed == 0) std::fill_n(out + to, plan_.channels, T(0));
      if (!total.empty()) join(out + to, total, summed);
      const double factor = factor_of(row, column);
      for (std::size_t c = 0; c < plan_.channels; ++c)
        out[to + c] = static_cast<T>((total.empty() ? static_cast<double>(out[to + c]) : total[c]) * factor);
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const adjoint = call.output_adjoints[0].values;
    T* const in_adjoint = call.accumulate(0);
    plan_.for_each_output_in_order(
        [&](std::size_t first, std::size_t from, const WindowTaps& row, const WindowTaps& column) {
          const T factor = static_cast<T>(factor_of(row, column));
          for (std::size_t c = 0; c < plan_.channels; ++c) adjoint[from + c] *= factor;
          plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
            kernels<T>().add(adjoint + from, in_adjoint + tap, plan_.channels);
          });
        });
  }

 private:
  /// Values that are summed in T before their sum joins others in double, so that pictures may be large.
  static constexpr std::size_t most_in_t = 64;

  void join(const T* sum, std::vector<double>& total, std::size_t& summed) const {
    total.resize(plan_.channels, 0);
    for (std::size_t c = 0; c < plan_.channels; ++c) total[c] += static_cast<double>(sum[c]);
    summed = 0;
  }

  [[nodiscard]] double factor_of(const WindowTaps& row, const WindowTaps& column) const {
    const std::size_t count =
        counts_padding_ ? row.with_padding * column.with_padding : row.count * column.count;
    return 1 / static_cast<double>(std::max<std::size_t>(1, count));
  }

  PoolingPlan plan_;
  bool counts_padding_;
};

/// LpPool and GlobalLpPool: (Σ |x|^p)^(1/p). Where all of a window is 0, so is the derivative.
template <std::floating_point T>
class LpPool : public Operation<T> {
 public:
  LpPool(PoolingPlan plan, double p)
      : Operation<T>({{plan.out_shape(), ElementType::floating}}), plan_(std::move(plan)), p_(p) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    plan_.for_each_output(
        [&](std::size_t first, std::size_t to, const WindowTaps& row, const WindowTaps& column) {
          for (std::size_t c = 0; c < plan_.channels; ++c) {
            double sum = 0;
            plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
              sum += std::pow(std::abs(static_cast<double>(in[tap + c])), p_);
            });
            out[to + c] = static_cast<T>(std::pow(sum, 1 / p_));
          }
        });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    const T* const out = call.outputs[0].values;
    const T* const adjoint = call.output_adjoints[0].values;
    T* const in_adjoint = call.accumulate(0);
    plan_.for_each_output_in_order(
        [&](std::size_t first, std::size_t from, const WindowTaps& row, const WindowTaps& column) {
          plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
            for (std::size_t c = 0; c < plan_.channels; ++c) {
              const auto x = static_cast<double>(in[tap + c]), y = static_cast<double>(out[from + c]);
              if (x == 0 || y == 0) continue;
              const double slope = std::copysign(std::pow(std::abs(x) / y, p_ - 1), x);
              in_adjoint[tap + c] += static_cast<T>(slope * static_cast<double>(adjoint[from + c]));
            }
          });
        });
  }
  [[nodiscard]] AdjointReads adjoint_reads() const override { return {1, 1}; }

 private:
  PoolingPlan plan_;
  double p_;
};

template <std::floating_point T>
void add_average_pool(OperatorTable<T>& table) {
  const auto norm = [](OperatorContext& context) {
    const std::int64_t p = context.integer("p", 2);
    if (p < 1) throw DomainError("attribute 'p' is " + std::to_string(p) + ", expected at least 1");
    return static_cast<double>(p);
  };
  table["AveragePool"] = {LayoutRule::channels_last, 1, false, [](OperatorContext& context) {
                            const bool counts_padding = context.integer("count_include_pad", 0) != 0;
                            return std::make_unique<AveragePool<T>>(plan_pooling(context, true),
                                                                    counts_padding);
                          }};
  table["GlobalAveragePool"] = {LayoutRule::channels_last, 1, false, [](OperatorContext& context) {
                                  return std::make_unique<AveragePool<T>>(plan_global_pooling(context),
                                                                          false);
                                }};
  table["LpPool"] = {LayoutRule::channels_last, 1, false, [norm](OperatorContext& context) {
                       return std::make_unique<LpPool<T>>(plan_pooling(context, true), norm(context));
                     }};
  table["GlobalLpPool"] = {LayoutRule::channels_last, 1, false, [norm](OperatorContext& context) {
                             return std::make_unique<LpPool<T>>(plan_global_pooling(context), norm(context));
                           }};
}

}  // namespace tapestry::nn
