#pragma once
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <limits>
#include <mutex>
#include <system_error>
#include <tapestry/core/detail/platform/thread.hpp>
#include <thread>
#include <vector>

namespace tapestry::detail {
/// Threads that help callers of parallel_for() with their loops. They start when they are first needed, sleep
/// while there is nothing to do, and stay until the program ends.
///
/// A caller works on its own loop and waits only for indices that a helper has begun. Helpers that the system
/// has not woken yet, as beside other busy processes, do not delay it, unlike at a barrier.
class ThreadPool {
 public:
  /// Calls of one loop: call(context, i) for i = 0 … count − 1.
  struct Loop {
    void (*call)(void* context, std::size_t index) = nullptr;
    void* context = nullptr;
    std::size_t count = 0;
  };

  /// The pool of this program, one for all its shared libraries, including those that hide their symbols. It
  /// is never destroyed, since loops may run during destruction of other objects.
  [[nodiscard, gnu::visibility("default")]] static ThreadPool& instance() {
    static ThreadPool& pool = *new ThreadPool;
    return pool;
  }

  /// Whether the calling thread is within a loop already.
  [[nodiscard, gnu::visibility("default")]] static bool& is_inside() {
    static thread_local bool inside = false;
    return inside;
  }

  /// Loops that were shared among threads so far.
  [[nodiscard]] std::size_t loop_count() const { return posted_.load(std::memory_order_relaxed); }

  /// Runs a loop on the calling thread and up to `helpers` others. When calls throw, the exception of the
  /// smallest index reaches the caller; the others are dropped.
  void run(const Loop& loop, std::size_t helpers) {
    Job job{loop, helpers};
    adapt_patience();
    {
      const std::lock_guard lock(mutex_);
      start_threads(helpers);
      jobs_.push_back(&job);
      posted_.fetch_add(1, std::memory_order_release);
      for (std::size_t i = std::min(helpers, sleeping_); i > 0; --i) wake_.notify_one();
    }
    is_inside() = true;
    work_on(job);
    is_inside() = false;
    std::unique_lock lock(mutex_);
    std::erase(jobs_, &job);
    if (job.helpers > 0) {
      lock.unlock();
      spin_until([&] { return job.helpers.load(std::memory_order_acquire) == 0; });
      lock.lock();
      done_.wait(lock, [&] { return job.helpers == 0; });
    }
    lock.unlock();
    if (job.failure) std::rethrow_exception(job.failure);
  }

 private:
  struct Job {
    Job(const Loop& of, std::size_t wanted) : loop(of), places(wanted) {}
    Loop loop;
    std::size_t places;                   ///< for further helpers
    std::atomic<std::size_t> next{0};     ///< next index to begin
    std::atomic<std::size_t> helpers{0};  ///< at work
    std::mutex failing{};
    std::exception_ptr failure{};
    std::size_t failed_at = std::numeric_limits<std::size_t>::max();
  };

  /// Turns that a thread spins before it sleeps, about 10 or 40 microseconds. Loops often follow one another
  /// closely, and waking takes longer than that. The shorter time is for busy machines, where a spinning
  /// thread takes a processor from threads that work.
  static constexpr int short_patience = 500, long_patience = 2000;
  static constexpr int loops_between_looks = 32, calm_looks = 16;

  template <class Condition>
  void spin_until(Condition condition) const {
    const int patience = patience_.load(std::memory_order_relaxed);
    for (int turn = 0; turn < patience && !condition(); ++turn) {
#if defined(__x86_64__) || defined(__i386__)
      __builtin_ia32_pause();
#endif
    }
  }

  /// Shortens patience when the system has taken the processor from a calling thread, and restores it after a
  /// while without that.
  void adapt_patience() {
    static thread_local int loops = 0, calm = 0;
    static thread_local long interruptions = 0;
    if (++loops % loops_between_looks != 0) return;
    const long now = platform::interruptions_of_thread();
    if (now < 0) return;
    calm = now == interruptions ? std::min(calm + 1, calm_looks) : 0;
    interruptions = now;
    patience_.store(calm == calm_looks ? long_patience : short_patience, std::memory_order_relaxed);
  }

  /// Starts threads up to `wanted`; where the system refuses one, loops run on fewer.
  void start_threads(std::size_t wanted) {
    while (thread_count_ < wanted) {
      try {
        std::thread([this] { help(); }).detach();
      } catch (const std::system_error&) {
        return;
      }
      ++thread_count_;
    }
  }

  void help() {
    is_inside() = true;
    std::unique_lock lock(mutex_);
    for (;;) {
      Job* const job = open_job();
      if (job == nullptr) {
        wait_for_work(lock);
        continue;
      }
      --job->places;
      ++job->helpers;
      lock.unlock();
      work_on(*job);
      lock.lock();
      if (--job->helpers == 0) done_.notify_all();
    }
  }

  void wait_for_work(std::unique_lock<std::mutex>& lock) {
    const std::size_t seen = posted_.load(std::memory_order_relaxed);
    lock.unlock();
    spin_until([&] { return posted_.load(std::memory_order_acquire) != seen; });
    lock.lock();
    if (posted_.load(std::memory_order_relaxed) != seen) return;
    ++sleeping_;
    wake_.wait(lock);
    --sleeping_;
  }

  [[nodiscard]] Job* open_job() {
    for (Job* const job : jobs_)
      if (job->places > 0 && job->next.load(std::memory_order_relaxed) < job->loop.count) return job;
    return nullptr;
  }

  static void work_on(Job& job) {
    for (;;) {
      const std::size_t index = job.next.fetch_add(1, std::memory_order_relaxed);
      if (index >= job.loop.count) return;
      try {
        job.loop.call(job.loop.context, index);
      } catch (...) {
        const std::lock_guard lock(job.failing);
        if (index >= job.failed_at) continue;
        job.failed_at = index;
        job.failure = std::current_exception();
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::vector<Job*> jobs_;
  std::atomic<std::size_t> posted_{0};  ///< loops so far
  std::size_t thread_count_ = 0;
  std::size_t sleeping_ = 0;
  std::atomic<int> patience_{short_patience};
};
}  // namespace tapestry::detail
