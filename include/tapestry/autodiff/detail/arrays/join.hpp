#pragma once
#include <tapestry/autodiff/detail/arrays/elementwise.hpp>

namespace tapestry {
namespace detail {
template <std::size_t Rank>
void require_count(const char* operation, std::size_t count, const Extents<Rank>& extents) {
  if (count_of(extents) != count)
    throw ShapeError({operation, ": ", count, " elements, expected those of ", extents});
}
}  // namespace detail

/// An array of scalar variables, in row-major order. \throws ShapeError if there are not as many as elements
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> array_of(std::span<const Variable<T>> scalars,
                                              const Extents<Rank>& extents) {
  detail::require_count("array_of", scalars.size(), extents);
  Array<T, Rank> value(extents);
  for (std::size_t i = 0; i < scalars.size(); ++i) value.data()[i] = scalars[i].value();
  const auto pullback = [](const Array<T, Rank>& value_adjoint, const std::vector<T*>& scalar_adjoints) {
    for (std::size_t i = 0; i < scalar_adjoints.size(); ++i)
      if (scalar_adjoints[i] != nullptr) *scalar_adjoints[i] += value_adjoint.data()[i];
  };
  return record_array(std::move(value), CarriesTangents{pullback}, scalars);
}

/// Arrays one behind the other along an axis.
/// \throws ShapeError if there are none, if there is no such axis, or if they differ along another one
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> concatenate(std::span<const ArrayVariable<T, Rank>> parts,
                                                 std::size_t axis) {
  if (parts.empty() || axis >= Rank)
    throw ShapeError({"concatenate: ", parts.size(), " arrays along axis ", axis, " of ", Rank});
  Extents<Rank> extents = parts.front().shape();
  std::size_t outer = 1, inner = 1;
  for (std::size_t a = 0; a < Rank; ++a) (a < axis ? outer : a == axis ? extents[a] : inner) *= extents[a];
  extents[axis] = 0;
  std::vector<std::size_t> lengths;  // elements of each part for one index before the axis
  for (const auto& part : parts) {
    Extents<Rank> expected = extents;
    expected[axis] = part.shape()[axis];
    require_shape("concatenate", "part", part.value(), expected);
    lengths.push_back(part.shape()[axis] * inner);
  }
  for (const auto& part : parts) extents[axis] += part.shape()[axis];
  Array<T, Rank> value(extents);
  T* to = value.data();
  for (std::size_t o = 0; o < outer; ++o)
    for (std::size_t p = 0; p < parts.size(); ++p)
      to = std::copy_n(parts[p].value().data() + o * lengths[p], lengths[p], to);
  const auto pullback = [lengths, outer](const Array<T, Rank>& value_adjoint,
                                         const std::vector<Array<T, Rank>*>& part_adjoints) {
    const T* from = value_adjoint.data();
    for (std::size_t o = 0; o < outer; ++o)
      for (std::size_t p = 0; p < lengths.size(); from += lengths[p++]) {
        if (part_adjoints[p] == nullptr) continue;
        T* const part = part_adjoints[p]->data() + o * lengths[p];
        for (std::size_t i = 0; i < lengths[p]; ++i) part[i] += from[i];
      }
  };
  return record_array(std::move(value), CarriesTangents{pullback}, parts);
}
}  // namespace tapestry
