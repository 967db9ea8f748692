#pragma once

#include <atomic>
#include <list>
#include <set>

#include "file_status.hpp"
#include "signals.hpp"

namespace tapestry::shell {

/// What an OutputClaim claims.
enum class Claimed { folder, file };

/// A claim of a folder or a file that this program writes, by an io::RunLock. Every program claims all of its
/// outputs by this class: a signal that ends the program deletes its lock files, too. Claims are made and
/// released by one thread.
class OutputClaim {
 public:
  /// Claims a folder, which must exist, or a file, which need not.
  /// \throws FileError as io::RunLock; Error (limit) for more than 16 claims at a time
  OutputClaim(Claimed kind, const std::string& path) : lock_(locked(kind, path)), place_(free_place()) {
    *place_ = lock_.path().c_str();
    end_deferral();
  }
  OutputClaim(const OutputClaim&) = delete;
  OutputClaim& operator=(const OutputClaim&) = delete;
  ~OutputClaim() { release(); }

  /// Releases the claim before the object is destroyed.
  void release() noexcept {
    is_changing = true;
    if (place_ != nullptr) *place_ = nullptr;
    place_ = nullptr;
    lock_.release();
    end_deferral();
  }

  /// Handler of signals: deletes the lock files of this process, and ends it by the signal.
  static void end_by(int signal) {
    if (is_changing) {
      deferred = signal;
      std::signal(signal, end_by);  // which Windows forgets
      return;
    }
    for (const auto& lock_file : lock_files)
      if (const char* const path = lock_file; path != nullptr) platform::remove_file(path);
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }

 private:
  /// Takes the lock. A signal that comes from now on waits for end_deferral().
  static io::RunLock locked(Claimed kind, const std::string& path) {
    is_changing = true;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR1, SIGPIPE})
      if (const auto now = std::signal(signal, end_by); now != SIG_DFL) std::signal(signal, now);
    try {
      return kind == Claimed::folder ? io::RunLock(path) : io::RunLock::of_file(path);
    } catch (...) {
      end_deferral();
      throw;
    }
  }

  static std::atomic<const char*>* free_place() {
    for (auto& lock_file : lock_files)
      if (lock_file == nullptr) return &lock_file;
    end_deferral();
    throw Error(ErrorKind::limit, "a program claims at most 16 outputs at a time");
  }

  static void end_deferral() noexcept {
    is_changing = false;
    if (const int signal = deferred.exchange(0); signal != 0) std::raise(signal);
  }

  // Handlers of signals reach static objects only.
  static inline std::array<std::atomic<const char*>, 16> lock_files{};
  static inline std::atomic<bool> is_changing{false};  ///< a signal now would find a lock that is not listed
  static inline std::atomic<int> deferred{0};          ///< a signal that came meanwhile

  io::RunLock lock_;
  std::atomic<const char*>* place_ = nullptr;  ///< among lock_files
};

/// Claims files that a program writes, each once for all its names; ignores empty names.
/// \throws Error as OutputClaim
[[nodiscard]] inline std::list<OutputClaim> claimed_files(const std::vector<std::string>& paths) {
  std::set<std::filesystem::path> known;
  std::list<OutputClaim> claims;
  for (const auto& path : paths)
    if (!path.empty() && known.insert(place_of(path)).second) {
      claims.emplace_back(Claimed::file, path);
      io::remove_abandoned_parts(io::path_of(path).parent_path().string());
    }
  return claims;
}

}  // namespace tapestry::shell
