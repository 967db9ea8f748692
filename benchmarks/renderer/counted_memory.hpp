#pragma once
#include <cstddef>

namespace tapestry::benchmarks {
/// Bytes that operator new has given out and not got back. A program that counts them links
/// counted_memory.cpp, which replaces operator new.
[[nodiscard]] std::size_t bytes_in_use();

/// The most that bytes_in_use() has been since reset_peak_bytes().
[[nodiscard]] std::size_t peak_bytes();
void reset_peak_bytes();
}  // namespace tapestry::benchmarks
