#pragma once
#include <algorithm>
#include <climits>
#include <tapestry/core/error.hpp>
#include <tapestry/core/platform.hpp>
#include <type_traits>
#include "processes.hpp"

namespace tapestry::shell {
/// The processes of one program that mpirun has started to share its work; without mpirun only this process.
/// Values are combined in the order of ranks, so that results do not depend on the number of ranks. Only the
/// first rank prints and writes files.
class Ranks {
 public:
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  /// The ranks of this program. The first call waits for all of them, so it must come before anything is
  /// printed.
  static const Ranks& all() {
    static const Ranks ranks;
    return ranks;
  }

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t index() const { return index_; }
  [[nodiscard]] bool is_first() const { return index_ == 0; }

  /// Overwrites the values with the first rank's. Every rank must call this, with as many values.
  template <class T>
  void share(std::span<T> values) const {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count_ > 1) share_bytes(values.data(), bytes_of(values));
  }

  /// The values of all ranks, one after another. Every rank must call this, with as many values.
  template <class T>
  [[nodiscard]] std::vector<T> gathered(const std::vector<T>& own) const {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count_ == 1) return own;
    std::vector<T> all(own.size() * count_);
    gather_bytes(own.data(), bytes_of(std::span(own)), all.data());
    return all;
  }

  /// Whether `here` is true at any rank. Every rank must call this.
  [[nodiscard]] bool any(bool here) const {
    const auto everywhere = gathered(std::vector<char>{here});
    return std::find(everywhere.begin(), everywhere.end(), char{1}) != everywhere.end();
  }

  /// Every rank must call this, with the SHA-256 of content that must be the same at all ranks.
  /// \throws Error (mismatch) naming a rank with another one
  void require_same(const std::string& what, const std::string& sha256) const {
    const auto all = gathered(std::vector<char>(sha256.begin(), sha256.end()));
    for (std::size_t rank = 0; rank < count_; ++rank)
      if (!std::equal(sha256.begin(), sha256.end(), all.data() + rank * sha256.size()))
        throw Error(ErrorKind::mismatch, what + " of rank " + std::to_string(rank) +
                                             " are others than those of rank " + std::to_string(index_) +
                                             ": all ranks need the same");
  }

  /// File descriptor that errors are written to.
  [[nodiscard]] int error_stream() const { return error_stream_; }

  /// Ends every rank at once if there are several, because the others would wait for this one for ever.
  void abandon(int exit_code) const {
    if (count_ > 1) abandon_processes(exit_code);
  }

 private:
  Ranks() {
    const ProcessPlace place = join_processes();
    count_ = place.count, index_ = place.index;
    if (index_ > 0) error_stream_ = platform::silence_standard_streams();
  }

  ~Ranks() { leave_processes(); }

  template <class T>
  static int bytes_of(std::span<T> values) {
    if (values.size_bytes() > INT_MAX)
      throw Error(ErrorKind::limit, "mpirun: ranks exchange at most 2 GiB at a time, not " +
                                        std::to_string(values.size_bytes()) + " bytes");
    return static_cast<int>(values.size_bytes());
  }

  std::size_t count_ = 1, index_ = 0;
  int error_stream_ = 2;
};
}  // namespace tapestry::shell
