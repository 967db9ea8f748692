#pragma once
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::benchmarks {
/// Cost of one run of a program, with all its own processes that it waited for.
struct ProcessCost {
  bool succeeded = false;
  double seconds = 0;
  double user_seconds = 0, system_seconds = 0;
  double switches = 0;         ///< times that a thread gave its processor up to wait
  double peak_memory_mib = 0;  ///< of the largest process
};

/// Where a program runs and what its streams are, if not this program's folder, its input and the log.
struct ProcessPlace {
  std::filesystem::path folder = ".";
  int in = STDIN_FILENO, out = -1;
};

/// A program that has been started.
class Process {
 public:
  /// \param command      the program, found on PATH, then its arguments
  /// \param environment  added to this one's, as NAME=VALUE
  /// \param log          takes what it prints, or why it does not start
  Process(const std::vector<std::string>& command, const std::vector<std::string>& environment,
          const std::filesystem::path& log, const ProcessPlace& place = {})
      : start_(std::chrono::steady_clock::now()) {
    std::vector<char*> words;
    for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    id_ = ::fork();
    if (id_ < 0) throw Error(ErrorKind::limit, "cannot start " + command.front());
    if (id_ > 0) return;
    const int file = ::open(log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0666);
    if (file >= 0 && ::dup2(place.in, 0) == 0 && ::dup2(place.out < 0 ? file : place.out, 1) == 1 &&
        ::dup2(file, 2) == 2 && ::chdir(place.folder.c_str()) == 0) {
      for (const auto& word : environment) ::putenv(const_cast<char*>(word.c_str()));
      ::execvp(words[0], words.data());
    }
    ::dprintf(2, "cannot start %s: %s\n", words[0], std::strerror(errno));
    ::_exit(127);
  }

  /// Waits until it has ended; to be called once.
  [[nodiscard]] ProcessCost wait() const {
    int status = 0;
    rusage usage{};
    if (::wait4(id_, &status, 0, &usage) != id_) throw Error(ErrorKind::limit, "cannot wait for a program");
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start_;
    const auto in_seconds = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    return {status == 0,
            seconds.count(),
            in_seconds(usage.ru_utime),
            in_seconds(usage.ru_stime),
            static_cast<double>(usage.ru_nvcsw),
            static_cast<double>(usage.ru_maxrss) / 1024};
  }

  /// Ends it, and waits for that; to be called once, instead of wait().
  void end() const {
    ::kill(id_, SIGTERM);
    while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }

 private:
  std::chrono::steady_clock::time_point start_;
  pid_t id_ = -1;
};
}  // namespace tapestry::benchmarks
