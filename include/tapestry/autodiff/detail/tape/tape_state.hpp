#pragma once
#include <tapestry/autodiff/detail/tape/careful_sweep.hpp>
#include <tapestry/autodiff/detail/tape/diagnosis.hpp>
#include <tapestry/autodiff/detail/tape/expression.hpp>
#include <tapestry/autodiff/detail/tape/inactive_heads.hpp>
#include <tapestry/autodiff/detail/tape/shared.hpp>
#include <tapestry/autodiff/detail/tape/tape_record.hpp>

namespace tapestry::detail {
/// A place on the tape; see Tape::mark().
struct TapePosition {
  TapeMemory::Place place;
  std::size_t records = 0;
  std::uint32_t generation = 0;  ///< generation of the last statement before the place
};

/// Contents of a tape. They stay at one address while the Tape that owns them is moved.
///
/// Statement i has adjoint i, from 1 on. It is an input, a list of operands, or a record with a pullback.
/// Memory: 1 byte a statement; 4 an operand of partial derivative ±1, 4 + sizeof(T) any other; and, once
/// there was a sweep, sizeof(T) a statement for its adjoint.
///
/// A stale variable is found by its generation: clear() starts a new generation at statement 1, and
/// rewind() one at the position, so that statements are never mistaken for those they replace.
template <class T>
class TapeState : public TapeDiagnosis {
 public:
  TapeState() { clear(); }
  ~TapeState() {
    drop_records(0);
    delete adjoint_lane;
  }
  TapeState(const TapeState&) = delete;
  TapeState& operator=(const TapeState&) = delete;

  /// Head that this thread writes statements to: a TapeState's, or one without room.
  [[gnu::visibility("default")]] static inline constinit thread_local WriteHead* active = &no_tape<T>;
  [[gnu::visibility("default")]] static inline constinit thread_local std::size_t scope_count = 0;

  static bool is_any_active() {
    return active != &no_tape<T> && active != &swept_tape<T> && active != &disordered_tapes<T>;
  }

  static TapeState& require_active() {
    if (!is_any_active()) throw_inactive<T>(active);
    return static_cast<TapeState&>(*active);
  }

  /// \throws DomainError unless the variable with this link was recorded here and is still on the tape
  void require_own(Link link) const {
    if (link.generation() != next.generation() && !owns_older(link)) [[unlikely]]
      throw_not_own();
  }

  void require_own_if_active(Link link) const {
    if (link.is_active()) require_own(link);
  }

  /// Reserves memory for so many more statements with so many operands, and their adjoints.
  void reserve(std::size_t statements, std::size_t operands) {
    if (statements > most_statements || operands > most_statements * largest_counts.sum())
      throw Error(ErrorKind::limit, "reserve: a tape holds about 2^32 statements");
    TapeMemory::reserve(statements + operands * pair_words<T>);
    adjoints_.reserve(statement_count() + statements + 1);
  }

  [[nodiscard]] Link append_input() {
    make_room(1);
    return commit(StatementKind::input, 1);
  }

  /// Writes one scalar statement with the given operands, any number of them; passive ones are left out.
  template <class LinkOf>
  [[nodiscard]] Link append_linear(std::size_t count, LinkOf link_of, const T* partials) {
    if (count >= most_operands) throw Error(ErrorKind::limit, "a statement holds at most 2^29 operands");
    make_room(count * pair_words<T> + 2);
    CarefulSink sink(*this);
    for (std::size_t i = 0; i < count; ++i) sink.add(link_of(i), partials[i]);
    return commit_pairs(sink.end());
  }

  /// Ends a statement of general operands that were written up to `end`.
  [[nodiscard]] Link commit_pairs(Word* end) {
    const auto word_count = static_cast<std::size_t>(end - words);
    const std::size_t count = word_count / pair_words<T>;
    if (count != 0 && count <= largest_counts.general) return commit(kind_of({0, 0, count}), word_count);
    *end = static_cast<Word>(count);
    return commit(StatementKind::many_pairs, word_count + 1);
  }

  /// \param record  a std::unique_ptr to a TapeRecord<T>; it reads the adjoints of `results` inputs behind it
  template <class Owner>
  [[nodiscard]] Link append_record(Owner record, std::size_t results = 0) {
    make_room(1);
    if (results > most_results_) most_results_ = results;
    records_.push_back({nullptr, results});
    records_.back().record = record.release();
    return commit(StatementKind::record, 1);
  }

  /// Lets `seed(adjoints)` set adjoints up to `root`, the others being zero, and sweeps; twice if NaN is
  /// left.
  template <class Seed>
  void reverse(std::size_t root, Seed seed) {
    const Sweeping sweeping(*this);
    root_ = root;
    sweep_by(ReverseSweep<T>(), seed);
    if constexpr (std::floating_point<T>)
      if (may_hide_zeros(adjoints())) sweep_by(CarefulSweep<T>(), seed);
  }

  /// Calls sweep(records) while nothing can be recorded, for sweeps that keep their adjoints elsewhere.
  template <class Sweep>
  void sweep_outside(Sweep sweep) {
    const Sweeping sweeping(*this);
    sweep(records());
  }
  [[nodiscard]] std::span<const HeldRecord<T>> records() const noexcept { return records_; }

  /// The adjoint of the last reverse(); zero before it, and for statements recorded since.
  [[nodiscard]] T adjoint(Link link) const {
    if (!link.is_active()) return T(0);
    require_own(link);
    return link.index() < adjoints_.size() ? adjoints_.data()[link.index()] : T(0);
  }

  /// Adjoints of the last reverse(), by statement, up to its root.
  [[nodiscard]] std::span<const T> adjoints() const {
    return {adjoints_.data(), adjoints_.size() < root_ + 1 ? adjoints_.size() : root_ + 1};
  }

  [[nodiscard]] TapePosition mark() const {
    return {place(), records_.size(), segment_of(next_statement() - 1).generation};
  }

  void rewind(const TapePosition& position) {
    require_idle("rewind");
    const std::size_t begin = position.place.next_index;
    if (begin == 0 || begin > next_statement() || segment_of(begin - 1).generation != position.generation)
      throw DomainError("rewind: the position is not on this tape, or was cleared or rewound over");
    segments_.reserve(segments_.size() + 1);
    drop_records(position.records);
    forget_diagnosis(begin);
    return_to(position.place);
    adjoints_.truncate(begin);
    while (segments_.back().begin >= begin) segments_.pop_back();
    start_segment(begin);
  }

  void clear() {
    require_idle("clear");
    segments_.reserve(1);
    drop_records(0);
    forget_diagnosis(0);
    return_to({1, 0, 0});
    adjoints_.truncate(0);
    segments_.clear();
    start_segment(0);
  }

  [[nodiscard]] std::size_t operand_count() const {
    std::size_t count = 0;
    visit_operands<T>(*this, [&](std::size_t, const T&) { ++count; });
    return count;
  }
  /// Bytes of the statements, without adjoints and the memory of records.
  [[nodiscard]] std::size_t statement_bytes() const {
    return statement_count() * sizeof(StatementKind) + used_words() * sizeof(Word);
  }
  [[nodiscard]] std::size_t record_count() const noexcept { return records_.size(); }
  void require_idle(const char* operation) const {
    if (is_sweeping_) throw DomainError({operation, ": called from within reverse()"});
  }

  ThreadClaim claim;
  std::uint64_t vector_sweeps = 0;         ///< number of sweeps of several roots so far
  TapeAttachment* adjoint_lane = nullptr;  ///< owned: of the arrays on this tape; see arrays/adjoint_lane.hpp

 private:
  static constexpr std::size_t most_operands = std::size_t(1) << 29U;

  class CarefulSink {
   public:
    explicit CarefulSink(const TapeState& state) : state_(state), end_(state.words) {}
    template <class Factor>
    void add(Link link, Factor factor) {
      if (!link.is_active()) return;
      state_.require_own(link);
      write_pair(end_, link.index(), as_number<T>(factor));
      end_ += pair_words<T>;
    }
    [[nodiscard]] Word* end() const { return end_; }

   private:
    const TapeState& state_;
    Word* end_;
  };

  /// Statements from `begin` to the next segment's begin share a generation.
  struct Segment {
    std::size_t begin;
    std::uint32_t generation;
  };

  /// While it lives, the tape sweeps, and nothing can be recorded on it.
  class Sweeping {
   public:
    explicit Sweeping(TapeState& state) : state_(state), previous_(active) {
      state.require_idle("reverse");
      state.is_sweeping_ = true;
      if (active == &state) active = &swept_tape<T>;
    }
    Sweeping(const Sweeping&) = delete;
    Sweeping& operator=(const Sweeping&) = delete;
    ~Sweeping() {
      state_.is_sweeping_ = false;
      if (active == &swept_tape<T>) active = previous_;  // unless a pullback has ended its scope
    }

   private:
    TapeState& state_;
    WriteHead* previous_;
  };

  template <class Sweep, class Seed>
  void sweep_by(const Sweep& sweep, Seed& seed) {
    adjoints_.zero(root_ + most_results_);
    for (const auto& held : records_) held.record->forget_adjoint();
    T* const adjoints = adjoints_.data();
    seed(adjoints);
    std::size_t record = records_.size();
    const auto pull_back = [&](std::size_t i) { records_[--record].record->pull_back(adjoints, i); };
    visit_backwards([&, root = root_](const StatementRun& run) {
      sweep.run(run, root, adjoints, pull_back, [&] { --record; });
    });
  }

  [[nodiscard]] std::size_t next_statement() const { return statement_count() + 1; }

  [[nodiscard]] bool owns_older(Link link) const noexcept {
    return link.index() < next_statement() && segment_of(link.index()).generation == link.generation();
  }
  [[noreturn]] static void throw_not_own() {
    throw DomainError(
        "the variable belongs to another tape, or its tape was cleared or rewound; a function that is "
        "recorded on a tape of its own takes variables as arguments");
  }

  [[nodiscard]] const Segment& segment_of(std::size_t statement) const {
    std::size_t last = segments_.size() - 1;
    while (segments_[last].begin > statement) --last;
    return segments_[last];
  }

  void start_segment(std::size_t begin) {
    next = Link(next.index(), next_generation());
    segments_.push_back({begin, next.generation()});
  }

  void drop_records(std::size_t size) {
    for (; records_.size() > size; records_.pop_back()) delete records_.back().record;
  }

  std::vector<HeldRecord<T>> records_;
  AdjointMemory<T> adjoints_;
  std::vector<Segment> segments_;
  std::size_t most_results_ = 0;
  std::size_t root_ = 0;  // of the last sweep
  bool is_sweeping_ = false;
};
}  // namespace tapestry::detail
