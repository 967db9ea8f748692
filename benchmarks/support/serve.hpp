#pragma once
#include <fcntl.h>
#include <unistd.h>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include "numbers_file.hpp"

namespace tapestry::benchmarks {
/// Something that a benchmark times: one library, set up for one task. write_numbers() takes its answer.
template <class E>
concept Engine = requires(E& engine, const std::string& path) {
  { engine.name() } -> std::convertible_to<std::string>;
  engine.run();
  write_numbers(path, engine.answer());
};

/// Replies to the driver. Takes the standard output for itself: what a library prints there goes to the error
/// stream from then on. Make one before the libraries start.
class Replies {
 public:
  Replies() : stream_(::fdopen(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3), "w")) {
    ::dup2(STDERR_FILENO, STDOUT_FILENO);
    if (stream_ == nullptr) throw Error(ErrorKind::write, "cannot write to the standard output");
  }
  Replies(const Replies&) = delete;
  Replies& operator=(const Replies&) = delete;
  ~Replies() { std::fclose(stream_); }

  void send(const nlohmann::json& reply) {
    const std::string line = reply.dump() + "\n";
    if (std::fputs(line.c_str(), stream_) < 0 || std::fflush(stream_) != 0)
      throw Error(ErrorKind::write, "cannot write to the standard output");
  }

 private:
  std::FILE* stream_;
};

/// Largest memory that this process has had in use, in MiB. Unlike getrusage() it leaves out what the process
/// was before it became this program.
[[nodiscard]] inline double peak_memory_mib() {
  std::ifstream status("/proc/self/status");
  std::string word;
  double kib = 0;
  while (status >> word)
    if (word == "VmHWM:") status >> kib;
  return kib / 1024;
}

/// Seconds of single passes: one that is not counted, for the caches, then as many as fill `seconds`.
template <Engine E>
[[nodiscard]] std::vector<double> take_turn(E& engine, double seconds) {
  using Clock = std::chrono::steady_clock;
  engine.run();
  std::vector<double> times;
  for (double used = 0; used < seconds || times.empty(); used += times.back()) {
    const auto start = Clock::now();
    engine.run();
    times.push_back(std::chrono::duration<double>(Clock::now() - start).count());
  }
  return times;
}

template <Engine E>
[[nodiscard]] nlohmann::json timed_reply(E& engine, double seconds) {
  const auto times = take_turn(engine, seconds);
  return {{"seconds", times}, {"peak_memory_mib", peak_memory_mib()}};
}

/// Introduces itself, then answers requests until the standard input ends, one a line:
///
///   turn SECONDS  →  {"seconds": [of each pass], "peak_memory_mib": …}
///   save PATH     →  {}, after writing the last pass's answer
///   memory        →  {"working_mib": …}, which a pass needs beyond its input; {} if it is not known
template <Engine E>
void serve(E& engine, Replies& replies) {
  engine.run();
  replies.send({{"name", engine.name()}});
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream request(line);
    std::string verb;
    request >> verb >> std::ws;
    if (verb == "turn") {
      double seconds = 0;
      request >> seconds;
      replies.send(timed_reply(engine, seconds));
    } else if (verb == "save") {
      std::string path;
      std::getline(request, path);
      write_numbers(path, engine.answer());
      replies.send(nlohmann::json::object());
    } else if (verb == "memory") {
      auto reply = nlohmann::json::object();
      if constexpr (requires { engine.working_mib(); }) reply["working_mib"] = engine.working_mib();
      replies.send(reply);
    } else {
      throw Error(ErrorKind::usage, "unknown request '" + line + "'");
    }
  }
}

/// The work of a worker's main function: runs for so many seconds, prints the times and leaves, or serves if
/// 0.
template <Engine E>
void run_or_serve(E& engine, Replies& replies, double seconds) {
  if (seconds == 0) return serve(engine, replies);
  replies.send(timed_reply(engine, seconds));
}
}  // namespace tapestry::benchmarks
