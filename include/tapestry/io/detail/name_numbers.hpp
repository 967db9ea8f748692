#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

namespace tapestry::io {

/// Numbers the different names of a file from 0 on, in order of appearance.
///
/// The caller keeps the names and passes a function from number to name. The table takes 16 to 32 bytes a
/// name, and half as much more while it grows. At most 2^31 names are numbered.
///
/// A name's place in the table follows from its hash, a polynomial over the bytes modulo 2^61 − 1. Each table
/// draws its base at random, so no file can be made whose names collide more often than by chance: two names
/// of n bytes have the same value in n / 7 of 2^61 draws, before it is reduced to 32 bits. Where the system
/// has no random numbers, the base is made of an address. The numbers of names do not depend on the base.
/// Source: Dietzfelbinger, Gil, Matias and Pippenger, Polynomial hash functions are reliable (1992).
class NameNumbers {
 public:
  static constexpr std::size_t none = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t size() const { return count_; }

  /// The number of a name. A new name gets the number size(), which then grows by one.
  /// \param name_of  returns the name with a number below size(), as std::string_view
  template <class NameOf>
  std::size_t add(std::string_view name, NameOf name_of) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    const std::uint32_t hash = hash_of(name);
    Slot& slot = slots_[search(name, hash, name_of)];
    if (slot.number_from_1 == 0) slot = {hash, static_cast<std::uint32_t>(++count_)};
    return slot.number_from_1 - 1;
  }

  /// The number of a name, or none.
  template <class NameOf>
  [[nodiscard]] std::size_t find(std::string_view name, NameOf name_of) const {
    if (slots_.empty()) return none;
    const Slot& slot = slots_[search(name, hash_of(name), name_of)];
    return slot.number_from_1 == 0 ? none : slot.number_from_1 - 1;
  }

 private:
  struct Slot {
    std::uint32_t hash = 0;
    std::uint32_t number_from_1 = 0;  // 0: nothing is here
  };
  static constexpr std::uint64_t modulus = (std::uint64_t(1) << 61U) - 1;

  [[nodiscard]] static std::uint64_t remainder_of_product(std::uint64_t a, std::uint64_t b) {
    __extension__ using Wide = unsigned __int128;
    const Wide product = static_cast<Wide>(a) * b;  // 2^61 leaves 1
    const auto sum =
        static_cast<std::uint64_t>(product >> 61U) + (static_cast<std::uint64_t>(product) & modulus);
    return sum >= modulus ? sum - modulus : sum;
  }

  [[nodiscard]] std::uint32_t hash_of(std::string_view name) const {
    std::uint64_t hash = 1;  // not 0: leading bytes of 0 count
    for (std::size_t at = 0; at < name.size(); at += 7) {
      std::uint64_t chunk = 0;
      std::memcpy(&chunk, name.data() + at, std::min<std::size_t>(7, name.size() - at));
      hash = remainder_of_product(hash, base_) + chunk;
      if (hash >= modulus) hash -= modulus;
    }
    hash = remainder_of_product(hash, base_) + name.size();
    hash = (hash ^ hash >> 32U) * 0x9E3779B97F4A7C15U;  // spreads neighbours
    return static_cast<std::uint32_t>(hash >> 32U);
  }

  /// The slot of that name, or the empty one where it belongs.
  template <class NameOf>
  [[nodiscard]] std::size_t search(std::string_view name, std::uint32_t hash, NameOf name_of) const {
    for (std::size_t at = hash & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
      const Slot& slot = slots_[at];
      if (slot.number_from_1 == 0) return at;
      if (slot.hash == hash && std::string_view(name_of(std::size_t{slot.number_from_1} - 1)) == name)
        return at;
    }
  }

  void grow() {
    if (slots_.empty()) draw_base();
    std::vector<Slot> grown(std::max<std::size_t>(16, 2 * slots_.size()));
    for (const Slot& slot : slots_) {
      if (slot.number_from_1 == 0) continue;
      std::size_t at = slot.hash & (grown.size() - 1);
      while (grown[at].number_from_1 != 0) at = (at + 1) & (grown.size() - 1);
      grown[at] = slot;
    }
    slots_ = std::move(grown);
  }

  void draw_base() {
    std::uint64_t drawn = reinterpret_cast<std::uintptr_t>(this) * 0x9E3779B97F4A7C15U;
    try {
      std::random_device device;
      drawn = std::uint64_t{device()} << 32U | device();
    } catch (const std::exception&) {  // the address stays
    }
    base_ = (drawn >> 3U) % (modulus - 256) + 256;
  }

  std::vector<Slot> slots_;  // a power of two, at most half of them taken
  std::size_t count_ = 0;
  std::uint64_t base_ = 0;
};

}  // namespace tapestry::io
