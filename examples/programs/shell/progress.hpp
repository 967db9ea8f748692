#pragma once
#include <chrono>
#include <tapestry/core/parallel.hpp>
#include "formatted.hpp"
#include "verbosity.hpp"

namespace tapestry::shell {
/// "1:05:09", "12:03" or "8 s".
inline std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  if (whole >= 3600) return formatted("%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
  return whole >= 60 ? formatted("%lld:%02lld", whole / 60, whole % 60) : formatted("%lld s", whole);
}

/// A progress line. On a terminal it is rewritten in place; elsewhere it is printed at most every ten
/// seconds. With --verbose it is printed every time, with --quiet never.
class ProgressLine {
 public:
  ProgressLine() {
    const char* terminal = std::getenv("TERM");
    terminal_ = verbosity() != Verbosity::verbose && platform::is_error_stream_a_terminal() &&
                !(terminal != nullptr && std::string(terminal) == "dumb");
  }

  /// Shows `text` after `done` of `total` units; `last` prints it in any case.
  void show(const std::string& text, bool last = false) {
    if (verbosity() == Verbosity::quiet) return;
    const auto now = Clock::now();
    const double pause = std::chrono::duration<double>(now - shown_).count();
    const bool is_due = last || !started_ || verbosity() == Verbosity::verbose;
    if (!is_due && pause < (terminal_ ? 0.2 : 10.0)) return;
    started_ = true;
    shown_ = now;
    if (terminal_)
      std::fprintf(stderr, "\r\033[K%s%s", text.c_str(), last ? "\n" : "");
    else
      std::fprintf(stderr, "%s\n", text.c_str());
    std::fflush(stderr);
  }

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_ = false;
  bool started_ = false;
  Clock::time_point shown_{};
};

/// Prints the progress of a measurement of many pictures. for_each_in_order() counts several pictures at
/// once; between those counts nothing is printed, because the estimate of the remaining time would be wrong.
class MeasuringProgress {
 public:
  explicit MeasuringProgress(std::size_t pictures) : pictures_(pictures) {}

  void count(const std::string& texture) {
    ++done_;
    if (done_ % items_at_a_time() != 0 && done_ != pictures_) return;
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    const double left = seconds / static_cast<double>(done_) * static_cast<double>(pictures_ - done_);
    line_.show("measuring " + texture + ": picture " + std::to_string(done_) + " of " +
                   std::to_string(pictures_) + ", " + duration_text(left) + " left",
               done_ == pictures_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::size_t pictures_, done_ = 0;
  Clock::time_point start_ = Clock::now();
  ProgressLine line_;
};
}  // namespace tapestry::shell
