#pragma once
#include <algorithm>
#include <iosfwd>
#include <map>
#include <tapestry/autodiff/tape.hpp>

namespace tapestry {
/// Counts of a tape's contents; see tape_statistics().
struct TapeStatistics {
  /// Statements of one kind.
  struct Row {
    std::string name;
    std::size_t count = 0;
    std::size_t operands = 0;
    std::size_t bytes = 0;  ///< on the tape, without adjoints and data of pullbacks
  };

  Row all;                      ///< everything
  std::vector<Row> statements;  ///< scalar statements by their number of operands; inputs have none
  std::vector<Row> operations;  ///< operations with a pullback, with array inputs, the most frequent first
  std::vector<Row> labels;      ///< counts of each label, in the order in which labels begin

  /// Prints a table; the header `ostream` must be included.
  template <class Character, class Traits>
  friend std::basic_ostream<Character, Traits>& operator<<(std::basic_ostream<Character, Traits>& out,
                                                           const TapeStatistics& statistics) {
    for (const std::string& line : statistics.lines()) out << line.c_str() << '\n';
    return out;
  }

  /// The lines of that table.
  [[nodiscard]] std::vector<std::string> lines() const {
    std::vector<std::string> text{line("", "count", "operands", "bytes"), line(all)};
    const auto add = [&](const std::vector<Row>& rows, const char* title) {
      if (rows.empty()) return;
      text.push_back(title);
      for (const Row& row : rows) text.push_back(line(row));
    };
    add(statements, "scalar statements");
    add(operations, "operations with a pullback");
    add(labels, "labels");
    return text;
  }

 private:
  [[nodiscard]] static std::string line(const Row& row) {
    return line("  " + row.name, std::to_string(row.count), std::to_string(row.operands),
                std::to_string(row.bytes));
  }
  [[nodiscard]] static std::string line(std::string name, const std::string& count,
                                        const std::string& operands, const std::string& bytes) {
    name.resize(std::max<std::size_t>(name.size(), 32), ' ');
    for (const std::string& number : {count, operands, bytes})
      name += std::string(number.size() < 14 ? 14 - number.size() : 1, ' ') + number;
    return name;
  }
};

namespace detail {
/// A readable name of a callable's type: for a lambda the function that it stands in, else the type without
/// template arguments; without our namespace. Read from the mangled name of the Itanium ABI, as GCC and Clang
/// make it: their demangler fails for some lambdas. "Z" begins a name within a function, "N" one of several
/// parts, each after its length.
[[nodiscard]] inline std::string operation_name(std::string_view mangled) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t at = 0;
  for (std::size_t i = 0; i + 1 < mangled.size() && at == 0; ++i)
    if (mangled[i] == 'Z' && (mangled[i + 1] == 'N' || is_digit(mangled[i + 1]))) at = i + 1;
  if (at < mangled.size() && mangled[at] == 'N') ++at;
  if (at < mangled.size() && mangled[at] == 'S')  // a namespace named before, or std
    at = mangled.substr(at, 2) == "St" ? at + 2 : mangled.find('_', at) + 1;
  std::string name;
  while (at < mangled.size() && is_digit(mangled[at])) {
    std::size_t length = 0;
    for (; at < mangled.size() && is_digit(mangled[at]); ++at)
      length = 10 * length + static_cast<std::size_t>(mangled[at] - '0');
    const std::string_view part = mangled.substr(at, length);
    at += part.size();
    if (part == "tapestry" || part == "detail" || part.substr(0, 8) == "_GLOBAL_") continue;
    name += (name.empty() ? "" : "::") + std::string(part);
  }
  return name.empty() ? "unnamed" : name;
}

inline void count_in(TapeStatistics::Row& row, std::size_t operands, std::size_t bytes) {
  ++row.count;
  row.operands += operands;
  row.bytes += bytes;
}

/// Counts of statements by kind, and sums over the statements behind some of them.
struct StatementCounts {
  static constexpr std::array names{"inputs",     "1 operand",       "2 operands",
                                    "3 operands", "4 to 7 operands", "8 operands or more"};
  TapeStatistics::Row all{"all", 0, 0, 0};
  std::array<TapeStatistics::Row, names.size()> by_operands{};
  std::map<std::string, TapeStatistics::Row> by_name{};
  /// Operands and bytes from a statement on, for the statements that are keys already.
  std::map<std::size_t, std::pair<std::size_t, std::size_t>> behind{};
};

/// Walks over all statements, the last one first.
template <class T>
void count_statements(const TapeState<T>& state, StatementCounts& counts) {
  std::size_t record = state.record_count();
  std::vector<std::uint32_t> inputs;
  state.visit_backwards([&](const StatementRun& run) {
    const Word* end = run.words_end;
    for (std::size_t index = run.end_index; index-- > run.first_index;) {
      const auto kind = run.kinds[index - run.first_index];
      std::size_t operands = 0;
      const Word* const begin = for_each_operand<T>(end, kind, [&](std::size_t, const T&) { ++operands; });
      const std::size_t bytes = sizeof(kind) + static_cast<std::size_t>(end - begin) * sizeof(Word);
      end = begin;
      if (kind == StatementKind::record) {
        const TapeRecord<T>& operation = *state.records()[--record].record;
        inputs.clear();
        operation.list_inputs(inputs);
        operands = inputs.size();
        count_in(counts.by_name[operation_name(operation.operation())], operands, bytes);
      } else {
        count_in(counts.by_operands[operands < 4 ? operands : operands < 8 ? 4 : 5], operands, bytes);
      }
      count_in(counts.all, operands, bytes);
      if (const auto found = counts.behind.find(index); found != counts.behind.end())
        found->second = {counts.all.operands, counts.all.bytes};
    }
  });
}
}  // namespace detail

/// Counts the content of a tape: scalar statements by their number of operands, operations with a pullback by
/// their names, everything by label. A scalar statement is a whole formula; the tape keeps its partial
/// derivatives but not its operations, so scalar statements have no names. Use labels to count them
/// separately. An operation is named after the function that called record_array() and the like with a
/// lambda, or after the type of another callable. Counting takes one pass over the tape and costs nothing
/// during recording.
///
///   std::cout << tape_statistics(tape);
template <class T>
[[nodiscard]] TapeStatistics tape_statistics(const Tape<T>& tape) {
  const auto& state = *tape.shared_state();
  detail::StatementCounts counts;
  state.visit_labels([&](const std::string&, std::size_t begin, std::size_t end) {
    counts.behind[begin], counts.behind[end];
  });
  detail::count_statements<T>(state, counts);
  TapeStatistics result{counts.all, {}, {}, {}};
  for (std::size_t i = 0; i < counts.names.size(); ++i) {
    counts.by_operands[i].name = counts.names[i];
    if (counts.by_operands[i].count > 0) result.statements.push_back(std::move(counts.by_operands[i]));
  }
  for (auto& [name, row] : counts.by_name)
    result.operations.push_back({name, row.count, row.operands, row.bytes});
  std::stable_sort(result.operations.begin(), result.operations.end(),
                   [](const auto& a, const auto& b) { return a.count > b.count; });
  state.visit_labels([&](const std::string& path, std::size_t begin, std::size_t end) {
    const auto same = [&](const TapeStatistics::Row& row) { return row.name == path; };
    auto row = std::find_if(result.labels.begin(), result.labels.end(), same);
    if (row == result.labels.end()) row = result.labels.insert(row, {path, 0, 0, 0});
    row->count += end - begin;
    row->operands += counts.behind[begin].first - counts.behind[end].first;
    row->bytes += counts.behind[begin].second - counts.behind[end].second;
  });
  return result;
}
}  // namespace tapestry
