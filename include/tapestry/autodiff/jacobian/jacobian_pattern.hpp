#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <tapestry/core/error.hpp>
#include <utility>
#include <vector>

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
      throw DomainError("JacobianPattern: " + std::to_string(rows) + " rows and " + std::to_string(columns) +
                        " columns, expected below 2^32");
    for (const Entry& entry : entries)
      if (entry.row >= rows || entry.column >= columns)
        throw DomainError("JacobianPattern: entry (" + std::to_string(entry.row) + ", " +
                          std::to_string(entry.column) + ") of a matrix of " + std::to_string(rows) +
                          " rows and " + std::to_string(columns) + " columns");
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
  /// How many entries may differ from 0.
  [[nodiscard]] std::size_t entry_count() const { return columns_of_.size(); }

  /// The columns of a row's entries.
  [[nodiscard]] std::span<const Index> row(std::size_t row) const {
    return {columns_of_.data() + begins_[row], begins_[row + 1] - begins_[row]};
  }
  /// visit(row, column, number) for each entry, in order.
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
  std::vector<std::size_t> begins_ = {0};  // of rows, and the end
  std::vector<Index> columns_of_;
};

/// Colours of columns, no two of which have an entry in the same row if they have the same colour.
struct ColumnColouring {
  std::vector<std::uint32_t> colour_of;
  std::size_t colour_count = 0;
};

/// Greedy: columns take, in the order of falling numbers of entries and then of their places, the first
/// colour that none of the columns in their rows has. Time: the sum over all entries of their rows' lengths.
/// Source: Gebremedhin, Manne and Pothen, What Color Is Your Jacobian? (SIAM Review 47, 2005), partial
/// distance-2 colouring.
[[nodiscard]] inline ColumnColouring colour_columns(const JacobianPattern& pattern) {
  const JacobianPattern rows_of = pattern.transposed();
  std::vector<std::size_t> order(pattern.column_count());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rows_of.row(a).size() > rows_of.row(b).size();
  });
  constexpr std::uint32_t none = 0xFFFFFFFFU;
  ColumnColouring colouring{std::vector<std::uint32_t>(order.size(), none), 0};
  std::vector<std::size_t> taken_by;  // of each colour, the last column beside which it was seen, plus one
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
