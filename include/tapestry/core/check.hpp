#pragma once
#include <string>
#include <tapestry/core/error.hpp>

namespace tapestry {
namespace detail {
template <class Extents>
std::string to_text(const Extents& extents) {
  std::string text = "[";
  for (const auto extent : extents) text += (text.size() > 1 ? ", " : "") + std::to_string(extent);
  return text + "]";
}
}  // namespace detail

/// Throws ShapeError, naming the operation and both extents, unless `array` has the `expected` extents.
template <class Array>
void require_shape(const char* operation, const char* argument, const Array& array,
                   const typename Array::shape_type& expected) {
  if (array.shape() != expected) {
    throw ShapeError(std::string(operation) + ": " + argument + " is " + detail::to_text(array.shape()) +
                     ", expected " + detail::to_text(expected));
  }
}

}  // namespace tapestry
