// Gives every reader its seeds, which it must take, then each cut at every length and with every byte
// changed, which it may refuse.
#include <cstdio>
#include <exception>

#include "target.hpp"

namespace {
using namespace tapestry::fuzz;

/// Throws unless the target takes its seeds; also throws on a variant that is neither taken nor refused.
std::size_t replay(const Target& target) {
  std::size_t count = 0;
  for (const std::string& seed : target.seeds()) {
    if (!is_taken(target, seed)) throw std::logic_error("seed " + std::to_string(count) + " is refused");
    for (std::size_t length = 0; length < seed.size(); ++length, ++count)
      read_both(target, seed.substr(0, length));
    for (std::size_t place = 0; place < seed.size(); ++place, ++count) {
      std::string changed = seed;
      const auto byte = static_cast<unsigned char>(seed[place]);
      changed[place] = static_cast<char>(place % 3 == 0 ? 0xFF : place % 3 == 1 ? byte ^ 1U : byte ^ 0x80U);
      read_both(target, changed);
    }
  }
  return count;
}
}  // namespace

int main() {
  bool is_sound = !targets().empty();
  for (const Target& target : targets()) {
    try {
      const std::size_t count = replay(target);
      std::printf("%-18s %6zu variants\n", target.name.c_str(), count);
      is_sound = is_sound && count > 0;
    } catch (const std::exception& fault) {
      std::printf("%-18s FAULT: %s\n", target.name.c_str(), fault.what());
      is_sound = false;
    }
  }
  return is_sound ? 0 : 1;
}
