#pragma once
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
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

/// A program that has been started.
class Process {
 public:
  /// \param command      the program, found on PATH, then its arguments
  /// \param environment  added to this one's, as NAME=VALUE
  /// \param log          takes what it prints
  Process(const std::vector<std::string>& command, const std::vector<std::string>& environment,
          const std::filesystem::path& log)
      : start_(std::chrono::steady_clock::now()) {
    std::vector<char*> words;
    for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    id_ = ::fork();
    if (id_ < 0) throw Error(ErrorKind::limit, "cannot start " + command.front());
    if (id_ > 0) return;
    const int file = ::open(log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0666);
    if (file >= 0 && ::dup2(file, 1) == 1 && ::dup2(file, 2) == 2) {
      for (const auto& word : environment) ::putenv(const_cast<char*>(word.c_str()));
      ::execvp(words[0], words.data());
    }
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

 private:
  std::chrono::steady_clock::time_point start_;
  pid_t id_ = -1;
};

}  // namespace tapestry::benchmarks
