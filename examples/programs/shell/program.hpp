#pragma once
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/platform/memory.hpp>
#include "command_line.hpp"
#include "formatted.hpp"
#include "output_claim.hpp"
#include "ranks.hpp"
#include "verbosity.hpp"

namespace tapestry::shell {
inline constexpr int exit_internal_fault = 1;

/// Bytes that the process was limited to; 0 where those of the machine are unknown.
inline std::uint64_t memory_limit = 0;

/// Limits the memory of the process, and lets what the pool keeps go before any allocation fails. \param mib
/// 0: seven eighths of the machine's, for others need some, too
inline void limit_memory(std::uint64_t mib) {
  memory_limit = mib > 0 ? mib << 20U : platform::machine_memory() / 8 * 7;
  if (memory_limit > 0) platform::limit_memory(memory_limit, static_cast<unsigned>(tapestry::thread_count()));
  static auto& pool = platform::PagePool::shared();  // made before an allocation can fail
  std::set_new_handler([] {
    if (pool.use().kept == 0) throw std::bad_alloc();
    pool.release();
  });
}

/// Throws Error (write) unless everything printed so far has reached the standard output.
inline void flush_standard_output() {
  std::cout.flush();
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout)
    throw Error(ErrorKind::write, "cannot write to the standard output");
}

/// Message of an error as a line for the terminal; of a bundled file that lacks, with the remedy.
std::string line_of(const Error& error);

/// One line a warning on the error stream.
inline void print_warnings(const std::vector<std::string>& warnings) {
  for (const auto& warning : warnings) std::cerr << "warning: " << for_terminal(warning) << '\n';
}

/// Runs a program's body, unless the command line already decides the exit code. Errors thrown become one
/// line on the error stream and an exit code, and end all ranks. Exceeding the system's limit on file size is
/// an ordinary write error, not a signal.
template <class Body>
int run_program(CLI::App& app, int argc, char** argv, Body body) {
  std::signal(SIGXFSZ, SIG_IGN);
  const Ranks& ranks = Ranks::all();
  const auto fail = [&](const std::string& what, int code) {
    if (ranks.is_first())
      std::cerr << "error: " + what + "\n";  // one write: another rank may report an error, too
    else
      platform::print_to(ranks.error_stream(),
                         "error: rank " + std::to_string(ranks.index()) + ": " + what + "\n");
    ranks.abandon(code);
    return code;
  };
  try {
    limit_memory(0);
    const int settled = parse_arguments(app, argc, argv);
    const auto start = std::chrono::steady_clock::now();
    const int code = settled >= 0 ? settled : body();
    flush_standard_output();
    tell_process_cost(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return code;
  } catch (const Error& error) {
    return fail(line_of(error), static_cast<int>(error.kind()));
  } catch (const std::bad_alloc&) {
    const std::string needed = memory_limit == 0 ? "more is needed than the system gives"
                                                 : "more than " + std::to_string(memory_limit >> 20U) +
                                                       " MiB are needed (limit of --memory-mib, else of this "
                                                       "machine)";
    return fail("out of memory: " + needed + "; fewer texels, a smaller batch or less --keep-mib take less",
                static_cast<int>(ErrorKind::limit));
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(for_terminal(error.what()), static_cast<int>(ErrorKind::malformed));
  } catch (const std::exception& error) {
    if (const auto fault = json_fault(error.what()); !fault.empty())
      return fail("a JSON file does not hold what our programs write: " + for_terminal(fault),
                  static_cast<int>(ErrorKind::malformed));
    return fail("internal fault: " + for_terminal(error.what()), exit_internal_fault);
  }
}
}  // namespace tapestry::shell
