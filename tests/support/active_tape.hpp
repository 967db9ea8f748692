#pragma once
#include <tapestry/autodiff/tape.hpp>

namespace tapestry::test {
/// A tape that is active as long as it lives.
template <class T>
struct ActiveTape : Tape<T> {
  ActiveScope<T> scope = this->activate();
};
}  // namespace tapestry::test
