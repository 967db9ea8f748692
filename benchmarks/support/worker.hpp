#pragma once
#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include "process.hpp"

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
  Worker(const std::vector<std::string>& command, const std::vector<std::string>& environment,
         const std::string& folder, const std::string& log)
      : log_(folder + "/" + log) {
    std::array<int, 2> requests{}, replies{};
    if (::pipe2(requests.data(), O_CLOEXEC) != 0 || ::pipe2(replies.data(), O_CLOEXEC) != 0)
      throw Error(ErrorKind::limit, std::string("cannot open a pipe: ") + std::strerror(errno));
    process_.emplace(command, environment, log_, ProcessPlace{folder, requests[0], replies[1]});
    ::close(requests[0]);
    ::close(replies[1]);
    requests_ = requests[1];
    replies_ = ::fdopen(replies[0], "r");
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    ::close(requests_);
    std::fclose(replies_);
    process_->end();
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
  std::string log_;
  std::optional<Process> process_;
  int requests_ = -1;
  std::FILE* replies_ = nullptr;
};
}  // namespace tapestry::benchmarks
