#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tapestry::detail {

/// Sets of numbers, each kept once: equal sets have the same name. The empty one is 0.
class IndexSets {
 public:
  using Name = std::uint32_t;

  [[nodiscard]] std::span<const std::uint32_t> members(Name set) const {
    return {members_.data() + begins_[set], begins_[set + 1] - begins_[set]};
  }

  [[nodiscard]] Name single(std::uint32_t member) { return named({member}); }

  /// The union. Those of two sets are remembered.
  [[nodiscard]] Name join(std::vector<Name>& sets) {
    std::sort(sets.begin(), sets.end());
    sets.erase(std::unique(sets.begin(), sets.end()), sets.end());
    if (sets.empty()) return 0;
    if (sets.size() == 1) return sets.front();
    if (sets.size() > 2) return named(united(sets));
    const std::uint64_t pair = std::uint64_t(sets[0]) << 32U | sets[1];
    if (const auto found = pairs_.find(pair); found != pairs_.end()) return found->second;
    return pairs_[pair] = named(united(sets));
  }

 private:
  [[nodiscard]] std::vector<std::uint32_t> united(std::span<const Name> sets) const {
    std::vector<std::uint32_t> all;
    for (const Name set : sets) all.insert(all.end(), members(set).begin(), members(set).end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }

  [[nodiscard]] Name named(const std::vector<std::uint32_t>& wanted) {
    std::uint64_t hash = 1469598103934665603U;  // FNV-1a, a number at a time
    for (const std::uint32_t member : wanted) hash = (hash ^ member) * 1099511628211U;
    const auto [begin, end] = names_.equal_range(hash);
    for (auto candidate = begin; candidate != end; ++candidate)
      if (const auto held = members(candidate->second);
          std::equal(held.begin(), held.end(), wanted.begin(), wanted.end()))
        return candidate->second;
    const auto name = static_cast<Name>(begins_.size() - 1);
    members_.insert(members_.end(), wanted.begin(), wanted.end());
    begins_.push_back(members_.size());
    names_.emplace(hash, name);
    return name;
  }

  std::vector<std::uint32_t> members_;
  std::vector<std::size_t> begins_{0, 0};  // of sets, and the end
  std::unordered_multimap<std::uint64_t, Name> names_;
  std::unordered_map<std::uint64_t, Name> pairs_;
};

/// Of each statement, the sets that were added to it and not joined yet; memory is used again.
class PendingSets {
 public:
  explicit PendingSets(std::size_t statements) : first_(statements, 0) {}

  void add(std::size_t statement, IndexSets::Name set) {
    std::uint32_t& first = first_[statement];
    if (first != 0 && nodes_[first].set == set) return;  // most operands meet the same set again
    std::uint32_t node = free_;
    if (node == 0) {
      node = static_cast<std::uint32_t>(nodes_.size());
      nodes_.emplace_back();
    } else {
      free_ = nodes_[node].next;
    }
    nodes_[node] = {set, first};
    first = node;
  }

  /// The union of what was added, which is forgotten.
  [[nodiscard]] IndexSets::Name take(std::size_t statement, IndexSets& sets) {
    std::uint32_t node = std::exchange(first_[statement], 0);
    if (node == 0) return 0;
    pending_.clear();
    while (node != 0) {
      pending_.push_back(nodes_[node].set);
      node = std::exchange(nodes_[node].next, std::exchange(free_, node));
    }
    return sets.join(pending_);
  }

 private:
  struct Node {
    IndexSets::Name set = 0;
    std::uint32_t next = 0;
  };
  std::vector<std::uint32_t> first_;  // of each statement a node, or 0
  std::vector<Node> nodes_ = std::vector<Node>(1);
  std::uint32_t free_ = 0;
  std::vector<IndexSets::Name> pending_;
};

}  // namespace tapestry::detail
