#pragma once
#include <atomic>
#include <csignal>
#include <list>
#include <new>
#include <set>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::shell {
#if defined(_WIN32)
/// Signals that Windows lacks: closing the console takes the place of a hang-up, and none that of others.
inline constexpr int SIGHUP = SIGBREAK, SIGXCPU = 0, SIGUSR1 = 0, SIGPIPE = 0, SIGXFSZ = 0;
#endif

/// Whether a file may be a frame by its name, see io::frame_paths().
inline bool is_frame_file(const std::filesystem::path& path) {
  return path.extension() == ".npz" || path.extension() == ".json";
}

using io::is_folder, io::is_there, io::status_of;

/// File that a path leads to, without links and dots; the path itself if that cannot be resolved.
inline std::filesystem::path place_of(const std::string& path) {
  std::error_code failure;
  auto place = std::filesystem::weakly_canonical(io::path_of(path), failure);
  if (failure == std::errc::not_enough_memory) throw std::bad_alloc();
  return failure ? io::path_of(path) : place;
}

/// Checks that files can be written into a folder, before hours of work. The file that it writes for the
/// check has the name of a temporary: if it cannot be removed, the next run in the folder removes it.
inline void require_writable_folder(const std::string& folder) {
  const std::string probe = io::detail::part_path(folder + "/.tapestry-probe", 0);
  const auto remove_probe = [&] {
    std::error_code failure;
    for (int attempt = 0; attempt < 2; ++attempt)
      if (std::filesystem::remove(io::path_of(probe), failure) || !failure) return;
  };
  try {
    io::write_file_atomically(probe, std::string_view("tapestry\n"));
  } catch (const FileError&) {
    remove_probe();  // the file exists if flushing its folder failed
    throw;
  }
  remove_probe();
}

/// Checks that a file can be written, before hours of work; removes temporaries of killed processes beside
/// it.
inline void require_writable_file(const std::string& path) {
  using std::filesystem::file_type;
  const std::string folder = io::path_of(path).parent_path().string();
  if (!is_folder(folder.empty() ? "." : folder, ErrorKind::write))
    throw FileError(ErrorKind::write, {path, "", "its folder does not exist"});
  const file_type type = status_of(path, ErrorKind::write).type();
  if (type != file_type::not_found && type != file_type::regular)
    throw FileError(ErrorKind::write, {path, "", "exists and is not a regular file"});
  io::remove_abandoned_parts(folder);
  require_writable_folder(folder.empty() ? "." : folder);
}

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
