#pragma once
#include <cmath>
#include <concepts>
#include <limits>
#include <tapestry/autodiff/functions/exponential.hpp>
#include <tapestry/autodiff/functions/hyperbolic.hpp>
#include <tapestry/autodiff/tape/placed_formula.hpp>
#include <tapestry/core/vector_functions.hpp>
#include <type_traits>

namespace tapestry::detail {

/// `function` of a number of type T, computed in double. For float the result is rounded once more, and right
/// to half a unit of the last place, except ties.
template <class T, class Function>
[[nodiscard, gnu::always_inline]] inline T in_double(const Function& function, T x) {
  return static_cast<T>(function(static_cast<double>(x)));
}
template <class T>
[[nodiscard, gnu::always_inline]] inline T lane_exp(T x) {
  return in_double(branchless_exp, x);
}
template <class T>
[[nodiscard, gnu::always_inline]] inline T lane_log1p(T x) {
  return in_double(branchless_log1p, x);
}
/// 1 / (1 + exp(−x)).
template <class T>
[[nodiscard, gnu::always_inline]] inline T lane_sigmoid(T x) {
  const T e = lane_exp(-std::abs(x));
  return (x < 0 ? e : T(1)) / (1 + e);
}

/// Operations of functions/ for lanes: formulas of branchless functions. Computing a vector of these again
/// costs less than keeping several partial derivatives.
struct LaneFunction {
  static constexpr bool is_cheap = true;
};
struct LaneExp : LaneFunction {
  template <class T>
  [[gnu::always_inline]] static T value(T x) {
    return lane_exp(x);
  }
  static auto partial(auto, auto exp_x) { return exp_x; }
};
struct LaneLog : LaneFunction {
  template <class T>
  [[gnu::always_inline]] static T value(T x) {
    return in_double(branchless_log, x);
  }
  static auto partial(auto x, auto) { return 1 / x; }
};
struct LaneLog1p : LaneFunction {
  template <class T>
  [[gnu::always_inline]] static T value(T x) {
    return lane_log1p(x);
  }
  static auto partial(auto x, auto) { return 1 / (1 + x); }
};
struct LaneTanh : LaneFunction {
  template <class T>
  [[gnu::always_inline]] static T value(T x) {
    return in_double(branchless_tanh, x);
  }
  template <class T>
  [[gnu::always_inline]] static T partial(T x, T) {
    const T e = lane_exp(-2 * std::abs(x));
    return 4 * e / ((1 + e) * (1 + e));
  }
};
struct LaneSigmoid : LaneFunction {
  template <class T>
  [[gnu::always_inline]] static T value(T x) {
    return lane_sigmoid(x);
  }
  template <class T>
  [[gnu::always_inline]] static T partial(T x, T) {
    const T e = lane_exp(-std::abs(x));
    return e / ((1 + e) * (1 + e));
  }
};
struct LaneSoftplus : LaneFunction {
  template <class T>
  [[gnu::always_inline]] static T value(T x) {
    return (x > 0 ? x : T(0)) + lane_log1p(lane_exp(-std::abs(x)));
  }
  template <class T>
  [[gnu::always_inline]] static T partial(T x, T) {
    return lane_sigmoid(x);
  }
};
struct LaneLogSumExp : LaneFunction {
  template <class T>
  [[gnu::always_inline]] static T value(T x, T y) {
    const T larger = x < y ? y : x;
    const T result = larger + lane_log1p(lane_exp(-std::abs(x - y)));
    return is_infinite_tie(x, y) ? x : result;
  }
  template <class T>
  [[gnu::always_inline]] static T partial_x(T x, T y, T) {
    return share(x, y);
  }
  template <class T>
  [[gnu::always_inline]] static T partial_y(T x, T y, T) {
    return share(y, x);
  }

 private:
  template <class T>
  [[gnu::always_inline]] static bool is_infinite_tie(T x, T y) {
    const T tied = x == y ? x : T(0);
    return std::abs(tied) == std::numeric_limits<T>::infinity();
  }
  /// d/dx = sigmoid(x − y), corrected by the rounding error of x − y; equal infinities share 1.
  template <class T>
  [[gnu::always_inline]] static T share(T x, T y) {
    const T difference = x - y;
    const T y_seen = x - difference;
    const T rest = (x - (difference + y_seen)) + (y_seen - y);
    const T lost = std::abs(difference) < std::numeric_limits<T>::infinity() ? rest : T(0);
    const T s = lane_sigmoid(difference);
    const T result = s + s * (lane_sigmoid(-difference) * lost);
    return is_infinite_tie(x, y) ? T(0.5) : result;
  }
};

/// Whether a formula has such an operation.
template <class E>
inline constexpr bool has_lane_function = false;
template <class Operation, class X>
inline constexpr bool has_lane_function<Unary<Operation, X>> =
    std::derived_from<Operation, LaneFunction> || has_lane_function<X>;
template <class Operation, class X, class Y>
inline constexpr bool has_lane_function<Binary<Operation, X, Y>> =
    std::derived_from<Operation, LaneFunction> || has_lane_function<X> || has_lane_function<Y>;

template <>
struct InLanes<Exp> : std::type_identity<LaneExp> {};
template <>
struct InLanes<Log> : std::type_identity<LaneLog> {};
template <>
struct InLanes<Log1p> : std::type_identity<LaneLog1p> {};
template <>
struct InLanes<Tanh> : std::type_identity<LaneTanh> {};
template <>
struct InLanes<Sigmoid> : std::type_identity<LaneSigmoid> {};
template <>
struct InLanes<Softplus> : std::type_identity<LaneSoftplus> {};
template <>
struct InLanes<LogSumExp> : std::type_identity<LaneLogSumExp> {};

}  // namespace tapestry::detail
