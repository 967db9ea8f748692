#pragma once
#include <cstddef>
#include <tapestry/core/parallel.hpp>

namespace tapestry::image::detail {

/// Calls body(y) for every row of a picture, from several threads.
template <class Body>
void for_each_row(std::size_t rows, Body body) {
  constexpr std::size_t rows_a_block = 16;
  parallel_for(block_count(rows, rows_a_block), [&](std::size_t block) {
    const auto [begin, end] = block_range(block, rows, rows_a_block);
    for (std::size_t y = begin; y < end; ++y) body(y);
  });
}

}  // namespace tapestry::image::detail
