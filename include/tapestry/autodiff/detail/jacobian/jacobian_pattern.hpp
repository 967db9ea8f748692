#pragma once
#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <tapestry/core/error.hpp>
#include <unordered_map>
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

  /// The union. Unions of two sets are stored.
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
  std::vector<std::size_t> begins_{0, 0};  // begin of each set, and the end
  std::unordered_multimap<std::uint64_t, Name> names_;
  std::unordered_map<std::uint64_t, Name> pairs_;
};

/// For each statement, the sets that were added to it and not joined yet; memory is used again.
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

  /// The union of a statement's pending sets, which are then forgotten.
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
  std::vector<std::uint32_t> first_;  // first node of each statement, or 0
  std::vector<Node> nodes_ = std::vector<Node>(1);
  std::uint32_t free_ = 0;
  std::vector<IndexSets::Name> pending_;
};
}  // namespace tapestry::detail

namespace tapestry {
/// Which entries of a matrix may differ from 0, row by row, their columns ascending.
class JacobianPattern {
 public:
  using Index = std::uint32_t;
  /// A place that may hold another number than zero.
  struct Entry {
    std::size_t row;
    std::size_t column;
  };

  JacobianPattern() = default;

  /// \param entries  in any order; one may be named more than once
  /// \throws DomainError if one lies outside, or there are 2³² rows or columns or more
  JacobianPattern(std::size_t rows, std::size_t columns, std::vector<Entry> entries)
      : rows_(rows), columns_(columns) {
    if (std::max(rows, columns) > std::numeric_limits<Index>::max())
      throw DomainError({"JacobianPattern: ", rows, " rows and ", columns, " columns, expected below 2^32"});
    for (const Entry& entry : entries)
      if (entry.row >= rows || entry.column >= columns)
        throw DomainError({"JacobianPattern: entry (", entry.row, ", ", entry.column, ") of a matrix of ",
                           rows, " rows and ", columns, " columns"});
    const auto key = [](const Entry& entry) { return std::pair(entry.row, entry.column); };
    std::sort(entries.begin(), entries.end(),
              [&](const Entry& a, const Entry& b) { return key(a) < key(b); });
    begins_.assign(rows + 1, 0);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (i > 0 && key(entries[i]) == key(entries[i - 1])) continue;
      ++begins_[entries[i].row + 1];
      columns_of_.push_back(static_cast<Index>(entries[i].column));
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  }

  [[nodiscard]] std::size_t row_count() const { return rows_; }
  [[nodiscard]] std::size_t column_count() const { return columns_; }
  /// Number of entries that may differ from 0.
  [[nodiscard]] std::size_t entry_count() const { return columns_of_.size(); }

  /// The columns of a row's entries.
  [[nodiscard]] std::span<const Index> row(std::size_t row) const {
    return {columns_of_.data() + begins_[row], begins_[row + 1] - begins_[row]};
  }
  /// Calls visit(row, column, number) for each entry, in order.
  template <class Visit>
  void visit(Visit visit) const {
    for (std::size_t r = 0; r < rows_; ++r)
      for (std::size_t e = begins_[r]; e < begins_[r + 1]; ++e) visit(r, std::size_t(columns_of_[e]), e);
  }
  [[nodiscard]] bool operator==(const JacobianPattern&) const = default;

  /// The pattern of the transposed matrix.
  [[nodiscard]] JacobianPattern transposed() const {
    JacobianPattern turned;
    turned.rows_ = columns_;
    turned.columns_ = rows_;
    turned.begins_.assign(columns_ + 1, 0);
    for (const Index column : columns_of_) ++turned.begins_[column + 1];
    std::partial_sum(turned.begins_.begin(), turned.begins_.end(), turned.begins_.begin());
    std::vector<std::size_t> next(turned.begins_.begin(), turned.begins_.end() - 1);
    turned.columns_of_.resize(entry_count());
    for (std::size_t r = 0; r < row_count(); ++r)
      for (const Index column : row(r)) turned.columns_of_[next[column]++] = static_cast<Index>(r);
    return turned;
  }

 private:
  std::size_t rows_ = 0;
  std::size_t columns_ = 0;
  std::vector<std::size_t> begins_ = {0};  // begin of each row, and the end
  std::vector<Index> columns_of_;
};

/// Colours of columns: two columns with an entry in the same row have different colours.
struct ColumnColouring {
  std::vector<std::uint32_t> colour_of;
  std::size_t colour_count = 0;
};

/// Greedy colouring: columns, sorted by falling number of entries and then by place, take the first
/// colour that no column sharing a row has. Time: the sum over all entries of their rows' lengths.
/// Source: Gebremedhin, Manne and Pothen, What Color Is Your Jacobian? (SIAM Review 47, 2005),
/// partial distance-2 colouring.
[[nodiscard]] inline ColumnColouring colour_columns(const JacobianPattern& pattern) {
  const JacobianPattern rows_of = pattern.transposed();
  std::vector<std::size_t> order(pattern.column_count());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rows_of.row(a).size() > rows_of.row(b).size();
  });
  constexpr std::uint32_t none = 0xFFFFFFFFU;
  ColumnColouring colouring{std::vector<std::uint32_t>(order.size(), none), 0};
  std::vector<std::size_t> taken_by;  // by colour: 1 + the last column with a neighbour of it
  for (const std::size_t column : order) {
    for (const auto row : rows_of.row(column))
      for (const auto neighbour : pattern.row(row))
        if (colouring.colour_of[neighbour] != none) taken_by[colouring.colour_of[neighbour]] = column + 1;
    std::size_t colour = 0;
    while (colour < taken_by.size() && taken_by[colour] == column + 1) ++colour;
    if (colour == taken_by.size()) taken_by.push_back(0);
    colouring.colour_of[column] = static_cast<std::uint32_t>(colour);
  }
  colouring.colour_count = taken_by.size();
  return colouring;
}
}  // namespace tapestry
