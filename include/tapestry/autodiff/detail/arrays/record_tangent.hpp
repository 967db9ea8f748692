#pragma once
#include <tapestry/autodiff/detail/arrays/record_array.hpp>

namespace tapestry {
namespace detail {
/// Number k of a dual: 0 the value, then the tangents.
template <DualNumber D>
[[nodiscard]] constexpr typename D::value_type part_of(const D& x, std::size_t k) {
  return k == 0 ? x.value() : x.tangent(k - 1);
}
/// Part k of all elements.
template <DualNumber D, std::size_t Rank>
[[nodiscard]] Array<typename D::value_type, Rank> part_of(const Array<D, Rank>& x, std::size_t k) {
  Array<typename D::value_type, Rank> part(x.shape());
  for (std::size_t i = 0; i < part.size(); ++i) part.data()[i] = part_of(x.data()[i], k);
  return part;
}
template <DualNumber D>
[[nodiscard]] constexpr D dual_with(const typename D::value_type& part, std::size_t k) {
  if (k == 0) return D(part);
  auto tangents = D().tangents();
  tangents[k - 1] = part;
  return D(0, tangents);
}

// Arguments and results of an operation on a tape of duals are taken apart into arrays and scalars of
// numbers. part_on() makes an input of a tape of numbers of a part, unless it is passive. add_part() adds the
// part k of an adjoint, seed_part() begins a sweep with it, joined() makes a result of its parts.

template <class T, DualNumber D, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> part_on(Tape<T>& tape, const ArrayVariable<D, Rank>& x, std::size_t k) {
  Array<T, Rank> part = part_of(x.value(), k);
  return x.is_active() ? tape.input(std::move(part)) : ArrayVariable<T, Rank>(std::move(part));
}
template <class T, DualNumber D>
[[nodiscard]] Variable<T> part_on(Tape<T>& tape, const Variable<D>& x, std::size_t k) {
  const T part = part_of(x.value(), k);
  return x.is_active() ? tape.input(part) : Variable<T>(part);
}
template <class T, class X>
[[nodiscard]] auto part_on(Tape<T>& tape, const std::vector<X>& x, std::size_t k) {
  std::vector<decltype(part_on(tape, x[0], k))> parts;
  for (const X& each : x) parts.push_back(part_on(tape, each, k));
  return parts;
}

template <DualNumber D, class T, std::size_t Rank>
void add_part(Array<D, Rank>* to, const ArrayVariable<T, Rank>& x, std::size_t k) {
  if (to == nullptr) return;
  const Array<T, Rank>& adjoint = x.adjoint();
  const T* const from = adjoint.data();
  D* const all = to->data();
  if (k == 0) {
    for (std::size_t i = 0; i < adjoint.size(); ++i) all[i] += D(from[i]);
  } else {
    for (std::size_t i = 0; i < adjoint.size(); ++i) all[i] += dual_with<D>(from[i], k);
  }
}
template <DualNumber D, class T>
void add_part(D* to, const Variable<T>& x, const Tape<T>& tape, std::size_t k) {
  if (to != nullptr) *to += dual_with<D>(tape.adjoint(x), k);
}
template <class T>
void add_part(auto* to, const auto& x, const Tape<T>&, std::size_t k) {
  add_part(to, x, k);
}
template <class To, class X, class T>
void add_part(const std::vector<To>& to, const std::vector<X>& x, const Tape<T>& tape, std::size_t k) {
  for (std::size_t i = 0; i < to.size(); ++i) add_part(to[i], x[i], tape, k);
}

template <class T, DualNumber D, std::size_t Rank>
void seed_part(T*, const ArrayVariable<T, Rank>& y, const Array<D, Rank>& adjoint, std::size_t k) {
  if (!y.is_active()) return;
  T* const to = y.shared_adjoint()->touch().data();
  for (std::size_t i = 0; i < adjoint.size(); ++i) to[i] += part_of(adjoint.data()[i], k);
}
template <class T, DualNumber D>
void seed_part(T* adjoints, const Variable<T>& y, const D& adjoint, std::size_t k) {
  if (y.link().is_active()) adjoints[y.link().index()] += part_of(adjoint, k);
}
template <class T, class Y, class Adjoint>
void seed_part(T* adjoints, const std::vector<Y>& y, const std::vector<const Adjoint*>& adjoint,
               std::size_t k) {
  for (std::size_t i = 0; i < y.size(); ++i)
    if (adjoint[i] != nullptr) seed_part(adjoints, y[i], *adjoint[i], k);
}

/// The duals of a value and its tangents along each direction.
template <DualNumber D, class T, std::size_t Rank>
[[nodiscard]] Array<D, Rank> joined(const std::vector<ArrayVariable<T, Rank>>& parts) {
  Array<D, Rank> all(parts[0].shape());
  for (std::size_t i = 0; i < all.size(); ++i) {
    auto tangents = D().tangents();
    for (std::size_t k = 0; k < tangents.size(); ++k) tangents[k] = parts[k + 1].value().data()[i];
    all.data()[i] = D(parts[0].value().data()[i], tangents);
  }
  return all;
}
template <DualNumber D, class T>
[[nodiscard]] D joined(const std::vector<Variable<T>>& parts) {
  auto tangents = D().tangents();
  for (std::size_t k = 0; k < tangents.size(); ++k) tangents[k] = parts[k + 1].value();
  return D(parts[0].value(), tangents);
}
template <DualNumber D, class Y>
[[nodiscard]] auto joined(const std::vector<std::vector<Y>>& parts) {
  std::vector<decltype(joined<D>(parts[0]))> all;
  for (std::size_t i = 0; i < parts[0].size(); ++i) {
    std::vector<Y> of_one;
    for (const auto& part : parts) of_one.push_back(part[i]);
    all.push_back(joined<D>(of_one));
  }
  return all;
}

template <class Y>
[[nodiscard]] std::size_t last_index(const Y& y) {
  if constexpr (requires { y.link(); }) {
    return y.link().is_active() ? y.link().index() : 0;
  } else {
    std::size_t last = 0;
    for (const auto& each : y) last = std::max(last, last_index(each));
    return last;
  }
}

template <DualNumber D, std::size_t Rank, class Pullback, class... X>
[[nodiscard]] auto record_result(Array<D, Rank> value, Pullback pullback, const X&... x) {
  return record_array(std::move(value), CarriesTangents{std::move(pullback)}, x...);
}
template <DualNumber D, class Pullback, class... X>
[[nodiscard]] auto record_result(const D& value, Pullback pullback, const X&... x) {
  return record_scalar(value, CarriesTangents{std::move(pullback)}, x...);
}
template <DualNumber D, std::size_t Rank, class Pullback, class... X>
[[nodiscard]] auto record_result(std::vector<Array<D, Rank>> values, Pullback pullback, const X&... x) {
  return record_arrays(std::move(values), CarriesTangents{std::move(pullback)}, x...);
}

template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> zeros_like(const ArrayVariable<T, Rank>& x) {
  return zeros<T, Rank>(x.shape());
}
template <class X>
[[nodiscard]] std::vector<X> zeros_like(const std::vector<X>& x) {
  std::vector<X> all;
  for (const X& each : x) all.push_back(zeros_like(each));
  return all;
}
/// x less a constant, of the same record.
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> lessened(const ArrayVariable<T, Rank>& x,
                                              const ArrayVariable<T, Rank>& constant) {
  auto value = std::make_shared<Array<T, Rank>>(x.value());
  for (std::size_t i = 0; i < value->size(); ++i) value->data()[i] -= constant.value().data()[i];
  return {std::move(value), x.shared_adjoint(), x.link()};
}
template <class X>
[[nodiscard]] std::vector<X> lessened(std::vector<X> x, const std::vector<X>& constants) {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = lessened(x[i], constants[i]);
  return x;
}

/// An operation and its tangent along one direction, on a tape of their own.
template <class T, class Parts, class Result>
struct TangentRecording {
  Tape<T> tape;
  Parts values, tangents;
  Result result;  ///< y and ẏ

  /// \param k  number of the direction, from 1
  template <class Adjoint, class... Adjoints>
  void pull_back(std::size_t k, const Adjoint& value_adjoint, const Adjoints&... adjoints) {
    const auto seed = [&](T* of_scalars) {
      seed_part(of_scalars, result.first, value_adjoint, k);
      seed_part(of_scalars, result.second, value_adjoint, 0);
    };
    tape.shared_state()->reverse(std::max(last_index(result.first), last_index(result.second)), seed);
    const auto add = [&](const Parts& of, std::size_t part) {
      std::apply([&](const auto&... each) { (add_part(adjoints, each, tape, part), ...); }, of);
    };
    if (k == 1) add(tangents, 0);
    add(values, k);
  }
};

template <class X>
struct DualOf {
  using type = typename X::value_type;
};
template <class X>
struct DualOf<std::vector<X>> : DualOf<X> {};
}  // namespace detail

/// Records an operation on a tape of duals by operations on a tape of the numbers beneath, so that it needs
/// no pullback of its own. f(x…, ẋ…) takes the values, then as many tangents, and returns {y, ẏ} with
/// ẏ = J(x)·ẋ. For each direction both stay on a tape that this record keeps. There a sweep from ẏ with ȳ and
/// from y with the tangent of ȳ leaves x̄ at ẋ and the tangent of x̄ at x:
///
///   ∂(ȳᵀJ(x)ẋ)/∂ẋ = Jᵀȳ      ∂(ȳᵀJ(x)ẋ)/∂x + Jᵀȳ′ = (Jᵀȳ)′
///
/// A linear operation is {f(x), f(ẋ)}, see record_linear(); a bilinear one {f(x, w), f(ẋ, w) + f(x, ẇ)}; a
/// selection takes the elements of ẋ that it takes of x.
///
/// \param x  ArrayVariables or Variables of one Dual, or vectors of them; y is such, too, of the numbers
template <class F, class First, class... X>
[[nodiscard]] auto record_tangent(F f, const First& first, const X&... x) {
  using D = typename detail::DualOf<First>::type;
  using T = typename D::value_type;
  const auto parts = [](Tape<T>& tape, std::size_t k, const auto&... all) {
    return std::tuple(detail::part_on(tape, all, k)...);
  };
  using Parts = decltype(parts(std::declval<Tape<T>&>(), 0, first, x...));
  using Result = decltype(std::apply(f, std::tuple_cat(std::declval<Parts>(), std::declval<Parts>())));
  using Direction = detail::TangentRecording<T, Parts, Result>;
  const auto directions = std::make_shared<std::vector<Direction>>();
  for (std::size_t k = 1; k <= D::direction_count; ++k) {
    Tape<T> tape;
    const auto scope = tape.activate();
    Parts values = parts(tape, 0, first, x...), tangents = parts(tape, k, first, x...);
    Result result = std::apply(f, std::tuple_cat(values, tangents));
    directions->push_back({std::move(tape), std::move(values), std::move(tangents), std::move(result)});
  }
  std::vector<typename Result::first_type> results;
  results.push_back(directions->front().result.first);
  for (const Direction& direction : *directions) results.push_back(direction.result.second);
  auto value = detail::joined<D>(results);
  const auto pullback = [directions](const auto& value_adjoint, const auto&... adjoints) {
    for (std::size_t k = 1; k <= D::direction_count; ++k)
      (*directions)[k - 1].pull_back(k, value_adjoint, adjoints...);
  };
  return detail::record_result(std::move(value), pullback, first, x...);
}

/// f′(x)·ẋ of each element, on the tape: for record_tangent().
/// \param slope, curvature  f′ and f″ of a number
template <class T, std::size_t Rank, class Slope, class Curvature>
[[nodiscard]] ArrayVariable<T, Rank> tangent_of_elements(const ArrayVariable<T, Rank>& x,
                                                         const ArrayVariable<T, Rank>& x_tangent, Slope slope,
                                                         Curvature curvature) {
  Array<T, Rank> tangent(x.shape());
  const T* const at = x.value().data();
  for (std::size_t i = 0; i < tangent.size(); ++i)
    tangent.data()[i] = detail::chain(x_tangent.value().data()[i], slope(at[i]));
  const auto pullback = [kept = x.shared_value(), along = x_tangent.shared_value(), slope, curvature](
                            const Array<T, Rank>& adjoint, Array<T, Rank>* x_adjoint,
                            Array<T, Rank>* tangent_adjoint) {
    for (std::size_t i = 0; i < kept->size(); ++i) {
      const T at_i = kept->data()[i], g = adjoint.data()[i];
      if (x_adjoint != nullptr)
        x_adjoint->data()[i] += detail::chain(detail::chain(g, along->data()[i]), curvature(at_i));
      if (tangent_adjoint != nullptr) tangent_adjoint->data()[i] += detail::chain(g, slope(at_i));
    }
  };
  return record_array(std::move(tangent), pullback, x, x_tangent);
}

/// The same for a quadratic function without linear and constant parts, q(x) = xᵀAx:
/// ẏ = (q(x + ẋ) − q(x − ẋ)) / 2.
template <class F, class X>
[[nodiscard]] auto record_quadratic(F f, const X& x) {
  return record_tangent(
      [f](const auto& at, const auto& along) {
        using Part = std::remove_cvref_t<decltype(at)>;
        const auto ahead = f(Part(at + along)), behind = f(Part(at - along));
        return std::pair(f(at), std::remove_cvref_t<decltype(ahead)>((ahead - behind) / 2));
      },
      x);
}

/// The same for a linear function of its arguments together.
template <class F, class... X>
[[nodiscard]] auto record_linear(F f, const X&... x) {
  return record_tangent(
      [f](const auto&... parts) {
        const auto all = std::tie(parts...);
        return [&]<std::size_t... i>(std::index_sequence<i...>) {
          return std::pair(f(std::get<i>(all)...), f(std::get<sizeof...(X) + i>(all)...));
        }
        (std::index_sequence_for<X...>());
      },
      x...);
}

/// The same for a linear function of one argument plus a constant: ẏ = f(ẋ) − f(0).
template <class F, class X>
[[nodiscard]] auto record_affine(F f, const X& x) {
  return record_tangent(
      [f](const auto& at, const auto& along) {
        return std::pair(f(at), detail::lessened(f(along), f(detail::zeros_like(at))));
      },
      x);
}
}  // namespace tapestry
