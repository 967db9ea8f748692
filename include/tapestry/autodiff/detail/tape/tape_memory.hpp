#pragma once
#include <tapestry/autodiff/detail/tape/page_memory.hpp>
#include <tapestry/autodiff/detail/tape/statement.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::detail {
/// Place of a tape's next statement. One without memory has no room.
struct WriteHead {
  static constexpr std::size_t usual_words = 64;  ///< most words of a usual statement

  Word* words = nullptr;
  Word* usual_limit = nullptr;    ///< below it a statement of usual_words fits
  Link next{};                    ///< link of the next statement
  std::uintptr_t kinds_base = 0;  ///< the kind of statement i is at kinds_base + i

  [[nodiscard]] bool has_usual_room() const noexcept { return words < usual_limit; }

  /// Adds a statement whose words, one or more, are written already.
  Link commit(StatementKind kind, std::size_t word_count) noexcept {
    const Link link = next;
    *reinterpret_cast<StatementKind*>(kinds_base + link.index()) = kind;
    words += word_count;
    ++next;
    return link;
  }
};

/// A piece of a tape's memory: words, behind them chunk_begin, and then as many kinds. A statement has at
/// least one word, so that there is always a kind for its words.
struct Chunk {
  PageMemory memory;
  std::size_t word_count = 0;
  std::uint32_t first_index = 0;  ///< of its first statement
  Word* words_end = nullptr;      ///< place of the head when it left

  [[nodiscard]] Word* words() const { return reinterpret_cast<Word*>(memory.get()); }
  [[nodiscard]] StatementKind* kinds() const {
    return reinterpret_cast<StatementKind*>(words() + word_count) + 1;
  }
};

/// The statements of one piece of the tape, the last one first.
struct StatementRun {
  const Word* words_end;
  const StatementKind* kinds;  ///< kind of the first of them; behind chunk_begin
  std::uint32_t first_index;
  std::uint32_t end_index;
};

/// Memory of a tape's statements, in chunks that stay where they are and are used again after clear().
/// Statements count from 1.
class TapeMemory : public WriteHead {
 public:
  struct Place {
    std::size_t next_index = 0;
    std::size_t chunk = 0;
    std::size_t word_count = 0;  ///< in the chunk
  };

  TapeMemory() = default;
  TapeMemory(const TapeMemory&) = delete;
  TapeMemory& operator=(const TapeMemory&) = delete;

  /// \throws Error when the tape is full, or there is no memory for more of it; it is then unchanged
  void make_room(std::size_t word_count) {
    if (chunks_.empty() || word_count > room()) [[unlikely]]
      enter_next_chunk(word_count);
  }

  /// Appends statements without operands, as many as there is room for but at most `count`.
  /// \returns the first one's link; `count` becomes the number of them
  [[nodiscard]] Link append_inputs(std::size_t& count) {
    make_room(1);
    if (count > room()) count = room();
    const Link first = next;
    std::memset(reinterpret_cast<void*>(kinds_base + first.index()), static_cast<int>(StatementKind::input),
                count);
    words += count;
    next = Link(first.index() + static_cast<std::uint32_t>(count), first.generation());
    return first;
  }

  /// Allocates room for so many more words, and statements of one word or more, and touches it.
  /// \throws Error as make_room()
  void reserve(std::size_t word_count) {
    make_room(1);
    std::size_t found = room();
    for (std::size_t i = current_ + 1; i < chunks_.size(); ++i) found += chunks_[i].word_count;
    while (found < word_count) {
      Chunk chunk = allocate(largest_size);
      constexpr std::size_t page = 4096;
      for (std::size_t at = 0; at < largest_size - page; at += page) chunk.memory.get()[at] = std::byte(0);
      found += chunk.word_count;
      chunks_.push_back(std::move(chunk));
    }
  }

  [[nodiscard]] Place place() const {
    if (chunks_.empty()) return {1, 0, 0};
    return {next.index(), current_, static_cast<std::size_t>(words - chunks_[current_].words())};
  }

  void return_to(const Place& place) noexcept {
    if (chunks_.empty()) return;
    enter(place.chunk);
    words += place.word_count;
    next = Link(static_cast<std::uint32_t>(place.next_index), next.generation());
  }

  [[nodiscard]] std::size_t statement_count() const { return place().next_index - 1; }

  [[nodiscard]] std::size_t used_words() const {
    std::size_t count = place().word_count;
    for (std::size_t i = 0; i < current_; ++i)
      count += static_cast<std::size_t>(chunks_[i].words_end - chunks_[i].words());
    return count;
  }

  /// Bytes of all chunks, spare ones included.
  [[nodiscard]] std::size_t chunk_bytes() const {
    std::size_t bytes = 0;
    for (const Chunk& chunk : chunks_) bytes += chunk.word_count * bytes_per_word;
    return bytes;
  }

  /// Number of statements without operands before the first other one.
  [[nodiscard]] std::size_t leading_input_count() const {
    std::size_t count = 0;
    visit_backwards([&](const StatementRun& run) {
      const std::size_t here = input_count(run.kinds, run.end_index - run.first_index);
      count = here + (here == run.end_index - run.first_index ? count : 0);
    });
    return count;
  }

  /// Calls visit(StatementRun) for each piece, the last one first.
  template <class Visit>
  void visit_backwards(Visit visit) const {
    if (chunks_.empty()) return;
    visit(run_of(chunks_[current_], words, next.index()));
    for (std::size_t i = current_; i-- > 0;)
      visit(run_of(chunks_[i], chunks_[i].words_end, chunks_[i + 1].first_index));
  }

 protected:
  static constexpr std::size_t most_statements = 0xFFFFFFFEU;

  /// Sets whether every statement from now on is written the careful way.
  void refuse_usual_room(bool refuses) noexcept {
    has_no_usual_room_ = refuses;
    if (chunks_.empty()) return;
    const Chunk& chunk = chunks_[current_];
    usual_limit = refuses ? nullptr : chunk.words() + (chunk.word_count - usual_words);
  }

 private:
  static constexpr std::size_t bytes_per_word = sizeof(Word) + sizeof(StatementKind);
  static constexpr std::size_t huge_page = std::size_t(1) << 21U;
  static constexpr std::size_t first_size = std::size_t(1) << 15U;
  static constexpr std::size_t largest_size = 4 * huge_page;

  /// Size of the piece after one of about `size` bytes. Pages of 4 KiB cost several times as much to touch as
  /// large ones of the same memory: the fourth piece is a large page, the fifth four of them.
  static std::size_t size_behind(std::size_t size) {
    if (size >= huge_page / 2) return largest_size;
    return size >= 3 * first_size ? huge_page : 2 * size;
  }

  [[nodiscard]] std::size_t room() const {
    return static_cast<std::size_t>(chunks_[current_].words() + chunks_[current_].word_count - words);
  }

  static StatementRun run_of(const Chunk& chunk, const Word* words_end, std::uint32_t end_index) {
    return {words_end, chunk.kinds(), chunk.first_index, end_index};
  }

  /// Inputs among the first `count` statements, before any other.
  static std::size_t input_count(const StatementKind* kinds, std::size_t count) {
    std::size_t here = 0;
    for (std::uint64_t eight = 0; here + sizeof(eight) <= count; here += sizeof(eight)) {
      std::memcpy(&eight, kinds + here, sizeof(eight));
      if (eight != 0) break;
    }
    while (here < count && kinds[here] == StatementKind::input) ++here;
    return here;
  }

  Chunk allocate(std::size_t size) const {
    Chunk chunk;
    try {
      chunk.memory = allocate_pages(size);
    } catch (const std::bad_alloc&) {
      throw Error(ErrorKind::limit,
                  {"the tape: no memory for ", size, " bytes beside the ", chunk_bytes(), " of ",
                   statement_count(), " statements; checkpoint() records a part only while it is swept"});
    }
    chunk.word_count = (size - sizeof(StatementKind)) / bytes_per_word;
    chunk.kinds()[-1] = StatementKind::chunk_begin;
    return chunk;
  }

  void enter_next_chunk(std::size_t word_count) {
    const std::size_t position = chunks_.empty() ? 0 : current_ + 1;
    const std::uint32_t first_index = chunks_.empty() ? 1 : next.index();
    const std::size_t needed = word_count > usual_words ? word_count : usual_words + 1;
    if (position == chunks_.size() || chunks_[position].word_count < needed) {
      std::size_t size =
          position == 0 ? first_size : size_behind(chunks_[current_].word_count * bytes_per_word);
      if (size < (needed + 1) * bytes_per_word) size = (needed + 1) * bytes_per_word;
      Chunk chunk = allocate(size);
      chunks_.insert(chunks_.begin() + static_cast<std::ptrdiff_t>(position), std::move(chunk));
    }
    if (chunks_[position].word_count > most_statements - first_index)
      throw Error(ErrorKind::limit, "the tape is full: it holds about 2^32 statements");
    if (position != 0) chunks_[current_].words_end = words;
    chunks_[position].first_index = first_index;
    enter(position);
    next = Link(first_index, next.generation());
  }

  void enter(std::size_t position) noexcept {
    const Chunk& chunk = chunks_[position];
    current_ = position;
    words = chunk.words();
    usual_limit = has_no_usual_room_ ? nullptr : words + (chunk.word_count - usual_words);
    kinds_base = reinterpret_cast<std::uintptr_t>(chunk.kinds()) - chunk.first_index;
  }

  std::vector<Chunk> chunks_;
  std::size_t current_ = 0;
  bool has_no_usual_room_ = false;
};

/// Calls visit(statement, partial) for each operand of each statement, the last statement first.
template <class T, class Visit>
void visit_operands(const TapeMemory& memory, Visit visit) {
  memory.visit_backwards([&](const StatementRun& run) {
    const Word* end = run.words_end;
    for (std::size_t i = run.end_index; i-- > run.first_index;)
      end = for_each_operand<T>(end, run.kinds[i - run.first_index],
                                [&](std::size_t, const T& partial) { visit(i, partial); });
  });
}
}  // namespace tapestry::detail
