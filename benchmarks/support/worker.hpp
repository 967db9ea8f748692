#pragma once
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

extern char** environ;

namespace tapestry::benchmarks {

/// The last line that a program wrote into its log.
[[nodiscard]] inline std::string last_line(const std::string& path) {
  std::ifstream log(path);
  std::string last;
  for (std::string line; std::getline(log, line);)
    if (!line.empty()) last = line;
  return last;
}

/// A program that runs beside the driver and waits for requests; see serve(). It ends with this object, and
/// by itself when the driver does.
class Worker {
 public:
  /// \param command      program and arguments
  /// \param environment  variables set for it, NAME=value
  /// \param folder       where it runs, so that files it leaves unasked are there; absolute
  /// \param log          file in it that takes its error stream
  /// \throws Error  if it does not start
  Worker(const std::vector<std::string>& command, const std::vector<std::string>& environment,
         const std::string& folder, const std::string& log)
      : folder_(folder), log_(folder + "/" + log) {
    std::array<int, 2> requests{};
    std::array<int, 2> replies{};
    if (::pipe2(requests.data(), O_CLOEXEC) != 0 || ::pipe2(replies.data(), O_CLOEXEC) != 0)
      throw Error(ErrorKind::limit, std::string("cannot open a pipe: ") + std::strerror(errno));
    const int failure = spawn(command, environment, requests[0], replies[1]);
    ::close(requests[0]);
    ::close(replies[1]);
    requests_ = requests[1];
    replies_ = ::fdopen(replies[0], "r");
    if (failure != 0) {
      close_pipes();
      throw Error(ErrorKind::usage, "cannot start " + command.front() + ": " + std::strerror(failure));
    }
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    close_pipes();
    ::kill(process_, SIGTERM);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }

  /// The next line it sends.
  /// \throws Error with the last line of its log if it has ended
  [[nodiscard]] nlohmann::json reply() {
    std::string line;
    for (int c = std::fgetc(replies_); c != '\n'; c = std::fgetc(replies_)) {
      if (c == EOF) throw Error(ErrorKind::malformed, last_line(log_));
      line += static_cast<char>(c);
    }
    return nlohmann::json::parse(line);
  }

  [[nodiscard]] nlohmann::json ask(const std::string& request) {
    const std::string line = request + "\n";
    std::string_view rest = line;
    while (!rest.empty()) {
      const ::ssize_t count = ::write(requests_, rest.data(), rest.size());
      if (count < 0 && errno != EINTR) break;  // it has ended, and reply() throws why
      if (count > 0) rest.remove_prefix(static_cast<std::size_t>(count));
    }
    return reply();
  }

 private:
  int spawn(const std::vector<std::string>& command, const std::vector<std::string>& environment, int in,
            int out) {
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    std::vector<char*> variables;
    for (const std::string& variable : environment) variables.push_back(const_cast<char*>(variable.c_str()));
    for (char** inherited = environ; *inherited != nullptr; ++inherited) variables.push_back(*inherited);
    variables.push_back(nullptr);
    ::posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addchdir_np(&actions, folder_.c_str());
    ::posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
    ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                       0644);
    const int failure =
        ::posix_spawn(&process_, arguments[0], &actions, nullptr, arguments.data(), variables.data());
    ::posix_spawn_file_actions_destroy(&actions);
    return failure;
  }

  void close_pipes() {
    ::close(requests_);
    std::fclose(replies_);
  }

  std::string folder_;
  std::string log_;
  ::pid_t process_ = -1;
  int requests_ = -1;
  std::FILE* replies_ = nullptr;
};

}  // namespace tapestry::benchmarks
