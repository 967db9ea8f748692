#pragma once
#include "worker_program.hpp"

namespace tapestry::benchmarks {
using Made = std::unique_ptr<Computation>;

/// A way to compute an objective, or null if there is none of that name. Defined in variant_definitions.hpp,
/// and compiled for groups of objectives in files of their own, which compilers work on side by side.
template <class Objective>
[[nodiscard]] Made make_variant(const Objective& objective, const std::string& variant,
                                std::ptrdiff_t threads);
}  // namespace tapestry::benchmarks
