#pragma once
#include <algorithm>
#include <cstddef>
#include <ranges>
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>

namespace tapestry::io {

/// Insertions, deletions, replacements and exchanges of neighbours that turn one word into the other, no part
/// of it changed twice (optimal string alignment).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The known word closest to `word`, the first of several; empty when none is near (more than a third of the
/// longer word would have to change).
[[nodiscard]] inline std::string nearest_word(std::string_view word,
                                              const std::ranges::forward_range auto& known) {
  std::string nearest;
  std::size_t best = 0;
  for (const std::string_view candidate : known) {
    const auto [shorter, longer] = std::minmax({word.size(), candidate.size()});
    if (3 * (longer - shorter) > longer) continue;  // so many insertions at least, without looking
    const std::size_t distance = edit_distance(word, candidate);
    if (3 * distance > longer) continue;
    if (nearest.empty() || distance < best) {
      nearest = candidate;
      best = distance;
    }
  }
  return nearest;
}

}  // namespace tapestry::io
