#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/autodiff/flat_stack.hpp>
#include <tapestry/autodiff/scalar.hpp>
#include <tapestry/core/error.hpp>
#include <utility>
#include <vector>

namespace tapestry {

/// An operation on the tape that is more than a list of partial derivatives: its pullback.
/// record.hpp makes these from a callable; derive from it only for what that cannot express.
template <class T>
class TapeRecord {
 public:
  TapeRecord() = default;
  TapeRecord(const TapeRecord&) = delete;
  TapeRecord& operator=(const TapeRecord&) = delete;
  virtual ~TapeRecord() = default;

  /// Adds to the adjoints of the inputs. `adjoints[i]` is that of scalar statement i, and `statement`
  /// is the record's own place.
  virtual void pull_back(T* adjoints, std::size_t statement) = 0;
  /// Called before each reverse sweep: adjoints held by the record are zero again.
  virtual void forget_adjoint() noexcept {}
};

namespace detail {

/// Where a variable was recorded. Index 0 means nowhere: the variable is passive.
struct Link {
  std::uint32_t index = 0;
  std::uint32_t generation = 0;
  [[nodiscard]] constexpr bool is_active() const { return index != 0; }
};

/// Numbers, unique in the program, by which a tape knows its own variables.
inline std::uint32_t next_generation() {
  static std::atomic<std::uint32_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

/// A place on the tape; see Tape::mark().
struct TapePosition {
  std::size_t statements = 0;
  std::size_t operands = 0;
  std::size_t records = 0;
  std::uint32_t generation = 0;  ///< of the last statement before the place
};

/// What a tape holds. It stays at one address while the Tape that owns it is moved.
///
/// Statement i has adjoint i. It is either scalar, with `operand_counts_[i]` pairs (index, partial) on
/// the operand stacks, or a record, which has no pairs and the count `is_record`. Statement 0 is a
/// sentinel. Memory: 4 bytes a statement, and 4 + sizeof(T) bytes an operand.
///
/// A stale variable is found by its generation: clear() starts a new generation at statement 0, and
/// rewind() one at the position, so that statements are never mistaken for those they replace.
template <class T>
class TapeState {
 public:
  TapeState() { clear(); }
  TapeState(const TapeState&) = delete;
  TapeState& operator=(const TapeState&) = delete;
  ~TapeState() { drop_records(0); }

  /// The state that this thread records on, or null.
  static inline constinit thread_local TapeState* active = nullptr;

  static TapeState& require_active() {
    if (active == nullptr) throw_no_tape();
    return *active;
  }

  /// \throws DomainError unless the variable with this link was recorded here and is still on the tape
  void require_own(Link link) const {
    if (link.generation != generation_) [[unlikely]]
      require_older(link);
  }

  void require_own_if_active(Link link) const {
    if (link.is_active()) require_own(link);
  }

  [[nodiscard]] Link append_input() { return commit_statement(0, 0); }

  /// One scalar statement: pairs written by `expression.push(1, sink)`, at most E::operand_bound of them.
  template <class Expression>
  [[nodiscard]] Link append(const Expression& expression) {
    indices_.make_room(Expression::operand_bound);
    partials_.make_room(Expression::operand_bound);
    Sink sink{*this, indices_.end(), partials_.end()};
    expression.push(T(1), sink);
    const auto count = static_cast<std::size_t>(sink.index - indices_.end());
    return commit_statement(static_cast<std::uint32_t>(count), count);
  }

  /// One scalar statement with the given operands, any number of them; passive ones are left out.
  template <class LinkOf>
  [[nodiscard]] Link append_linear(std::size_t count, LinkOf link_of, const T* partials) {
    if (count >= is_record) throw_full();
    indices_.make_room(count);
    partials_.make_room(count);
    Sink sink{*this, indices_.end(), partials_.end()};
    for (std::size_t i = 0; i < count; ++i) sink.add(link_of(i), partials[i]);
    const auto active_count = static_cast<std::size_t>(sink.index - indices_.end());
    return commit_statement(static_cast<std::uint32_t>(active_count), active_count);
  }

  [[nodiscard]] Link append_record(std::unique_ptr<TapeRecord<T>> record) {
    make_room_for_statement();
    records_.push_back(std::move(record));
    return commit_statement(is_record, 0);
  }

  /// Zeroes every adjoint, lets `seed(adjoints)` set the first, and runs the records backwards.
  template <class Seed>
  void reverse(Seed seed) {
    const Sweep sweep(*this);
    adjoints_.assign(operand_counts_.size(), T(0));
    for (const auto& record : records_) record->forget_adjoint();
    seed(adjoints_.data());
    run_backwards();
  }

  /// The adjoint of the last reverse(); zero before it, and for what was recorded since.
  [[nodiscard]] T adjoint(Link link) const {
    if (!link.is_active()) return T(0);
    require_own(link);
    return link.index < adjoints_.size() ? adjoints_[link.index] : T(0);
  }

  [[nodiscard]] TapePosition mark() const {
    const std::size_t statements = operand_counts_.size();
    return {statements, partials_.size(), records_.size(), segment_of(statements - 1).generation};
  }

  void rewind(const TapePosition& position) {
    require_idle("rewind");
    if (position.statements == 0 || position.statements > operand_counts_.size() ||
        segment_of(position.statements - 1).generation != position.generation)
      throw DomainError("rewind: the position is not on this tape, or was cleared or rewound over");
    segments_.reserve(segments_.size() + 1);
    drop_records(position.records);
    truncate(position.statements, position.operands);
    while (segments_.back().begin >= position.statements) segments_.pop_back();
    start_segment(position.statements);
  }

  void clear() {
    require_idle("clear");
    segments_.reserve(1);
    operand_counts_.make_room(1);
    drop_records(0);
    truncate(0, 0);
    *operand_counts_.end() = 0;  // the sentinel
    operand_counts_.commit(1);
    segments_.clear();
    start_segment(0);
  }

  [[nodiscard]] std::size_t statement_count() const noexcept { return operand_counts_.size() - 1; }
  [[nodiscard]] std::size_t operand_count() const noexcept { return partials_.size(); }
  [[nodiscard]] std::size_t record_count() const noexcept { return records_.size(); }
  void require_idle(const char* operation) const {
    if (is_sweeping_) throw DomainError(std::string(operation) + ": called from within reverse()");
  }

  std::shared_ptr<void> array_memory;  ///< of the arrays on this tape; see array_memory.hpp

 private:
  static constexpr std::uint32_t is_record = 0xFFFFFFFFU;

  /// Receives the pairs of one statement.
  struct Sink {
    const TapeState& state;
    std::uint32_t* index;
    T* partial;

    void add(Link link, T value) {
      if (!link.is_active()) return;
      state.require_own(link);
      *index++ = link.index;
      *partial++ = value;
    }
  };

  /// Statements from `begin` to the next segment's begin share a generation.
  struct Segment {
    std::size_t begin;
    std::uint32_t generation;
  };

  /// While it lives, the tape sweeps, and nothing can be recorded on it.
  class Sweep {
   public:
    explicit Sweep(TapeState& state) : state_(state), previous_(active) {
      state.require_idle("reverse");
      state.is_sweeping_ = true;
      if (active == &state) active = nullptr;
    }
    Sweep(const Sweep&) = delete;
    Sweep& operator=(const Sweep&) = delete;
    ~Sweep() {
      state_.is_sweeping_ = false;
      active = previous_;
    }

   private:
    TapeState& state_;
    TapeState* previous_;
  };

  [[noreturn]] static void throw_no_tape() {
    throw DomainError(
        "an operation on an active variable needs an active tape: keep the result of "
        "Tape::activate() alive on this thread");
  }
  [[noreturn]] static void throw_full() {
    throw Error(ErrorKind::limit, "the tape is full: it holds at most 2^32 - 2 statements");
  }

  void require_older(Link link) const {
    if (link.index >= operand_counts_.size() || segment_of(link.index).generation != link.generation)
      throw DomainError("the variable belongs to another tape, or its tape was cleared or rewound");
  }

  [[nodiscard]] const Segment& segment_of(std::size_t statement) const {
    std::size_t last = segments_.size() - 1;
    while (segments_[last].begin > statement) --last;
    return segments_[last];
  }

  void start_segment(std::size_t begin) {
    generation_ = next_generation();
    segments_.push_back({begin, generation_});
  }

  void make_room_for_statement() {
    if (operand_counts_.size() >= is_record) [[unlikely]]
      throw_full();
    operand_counts_.make_room(1);
  }

  Link commit_statement(std::uint32_t count, std::size_t operands) {
    make_room_for_statement();
    const auto index = static_cast<std::uint32_t>(operand_counts_.size());
    *operand_counts_.end() = count;
    operand_counts_.commit(1);
    indices_.commit(operands);
    partials_.commit(operands);
    return {index, generation_};
  }

  /// A zero adjoint passes nothing on, not even through an infinite partial.
  void run_backwards() {
    T* const adjoints = adjoints_.data();
    std::size_t operand = partials_.size();
    std::size_t record = records_.size();
    for (std::size_t statement = adjoints_.size(); statement-- > 1;) {
      const std::uint32_t count = operand_counts_.data()[statement];
      if (count == is_record) {
        records_[--record]->pull_back(adjoints, statement);
        continue;
      }
      operand -= count;
      const T adjoint = adjoints[statement];
      if (is_zero(adjoint)) continue;
      for (std::size_t k = operand; k < operand + count; ++k)
        adjoints[indices_.data()[k]] += partials_.data()[k] * adjoint;
    }
  }

  void drop_records(std::size_t size) {
    while (records_.size() > size) records_.pop_back();
  }

  void truncate(std::size_t statements, std::size_t operands) {
    operand_counts_.truncate(statements);
    indices_.truncate(operands);
    partials_.truncate(operands);
    if (adjoints_.size() > statements) adjoints_.resize(statements);
  }

  FlatStack<std::uint32_t> operand_counts_;
  FlatStack<std::uint32_t> indices_;
  FlatStack<T> partials_;
  std::vector<std::unique_ptr<TapeRecord<T>>> records_;
  std::vector<T> adjoints_;
  std::vector<Segment> segments_;
  std::uint32_t generation_ = 0;
  bool is_sweeping_ = false;
};

}  // namespace detail
}  // namespace tapestry
