#pragma once
#include <tapestry/core/array.hpp>

namespace tapestry::test {
/// Addresses of arrays, as Detector::pull_back() takes adjoints of logits.
template <class T>
[[nodiscard]] std::vector<const Array<T, 4>*> pointers_to(const std::vector<Array<T, 4>>& arrays) {
  std::vector<const Array<T, 4>*> pointers;
  for (const auto& array : arrays) pointers.push_back(&array);
  return pointers;
}
}  // namespace tapestry::test
