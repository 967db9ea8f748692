#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <utility>
#include <vector>

/// \file
/// The operating system: the only place that includes its headers, in core/implementation/platform/, once for
/// POSIX, once for Windows and once for neither. There files have one name and nobody else uses them.
///
/// Functions that return an int return 0, or the errno of a failure, on Windows, too. Paths are UTF-8.
namespace tapestry::platform {
/// Characters between the folders of a path.
#if defined(_WIN32)
inline constexpr const char* separators = "/\\";
#else
inline constexpr const char* separators = "/";
#endif

/// Kind of an open file.
enum class FileKind { regular, folder, other };

/// State of an open file.
struct FileState {
  FileKind kind = FileKind::regular;
  std::uint64_t size = 0;        ///< in bytes
  std::uint64_t name_count = 1;  ///< hard links; 0 for a deleted file
  std::string stamp{};  ///< place, size and time of the last change: equal if nothing was written between
};

/// Purpose for which a file is opened.
enum class Access {
  read,    ///< an existing file; a FIFO is not waited for
  create,  ///< a new file, for writing
  share    ///< for reading and writing; made if there is none; a link is refused
};

/// An open file, or none. Closed when the object is destroyed; closing releases its lock.
class OpenFile {
 public:
  OpenFile() = default;
  OpenFile(OpenFile&& other) noexcept : handle_(std::exchange(other.handle_, none)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~OpenFile() { close(); }

  [[nodiscard]] int open(const std::string& path, Access access);
  void close() noexcept;
  [[nodiscard]] bool is_open() const { return handle_ != none; }

  /// Locks the file for this object, without waiting. \returns EWOULDBLOCK if another one has it
  [[nodiscard]] int lock() const;

  /// Reads from byte `offset` on. \returns the bytes read, 0 at the end, −1 with errno for a failure
  [[nodiscard]] std::ptrdiff_t read_at(std::uint64_t offset, std::span<std::byte> bytes) const;

  /// Writes all of the bytes behind those written before.
  [[nodiscard]] int write(std::span<const std::byte> bytes) const;

  /// Replaces the content of a file, which was not written to so far, by a short text.
  [[nodiscard]] int replace(std::span<const std::byte> bytes) const;

  /// Writes what the system holds back to the device.
  [[nodiscard]] int flush() const;
  [[nodiscard]] int inspect(FileState& state) const;

  /// True if `path` still leads to this regular file.
  [[nodiscard]] bool is_still_at(const std::string& path) const;

 private:
  static constexpr std::intptr_t none = -1;
  std::intptr_t handle_ = none;
};

/// Renames a file in one step, over another if there is one.
[[nodiscard]] int replace_file(const std::string& from, const std::string& to);

/// Makes a rename within a folder durable. \returns 0 on file systems that cannot do so
[[nodiscard]] int flush_folder(const std::string& folder);

/// Deletes a file. Handlers of signals may call it.
int remove_file(const char* path) noexcept;

/// Number of this process.
[[nodiscard]] long process_number();

/// Name of this machine; "?" if it has none.
[[nodiscard]] std::string host_name();

/// Path of the running program; empty if it is unknown.
[[nodiscard]] std::string program_path();

/// Words of the command line, of which main() has those of an old encoding on Windows.
[[nodiscard]] std::vector<std::string> command_line_words(int argc, char** argv);

/// Sets a variable of the environment.
void set_variable(const char* name, const std::string& value);

/// Brand name of the processor; its kind if there is none.
[[nodiscard]] std::string processor_name();

/// Use of the system by this process so far; 0 where nothing is counted.
struct ProcessCost {
  double peak_mib = 0;
  long waits = 0;  ///< of its threads, for something
  long page_faults = 0;
};
[[nodiscard]] ProcessCost process_cost();  ///< since its start

/// Bytes of memory that this process may fill: the machine's, or those of its container; 0 if unknown.
[[nodiscard]] std::uint64_t machine_memory();

/// Lets this process fail to allocate, where the system would otherwise kill it, once its memory exceeds so
/// many bytes; on Windows nothing, for there it fails by itself.
/// \param threads  whose stacks come on top
void limit_memory(std::uint64_t bytes, std::uint64_t threads);

/// True if the error stream is a terminal.
[[nodiscard]] bool is_error_stream_a_terminal();

/// Opens empty standard streams for a program that was started without them. Otherwise the next file opened
/// would take their place and receive the printed text. On Windows, gives them the bytes of other systems.
void open_standard_streams();

/// Silences the standard streams. \returns descriptor of the error stream, for print_to()
[[nodiscard]] int silence_standard_streams();

/// Writes a text at once to a descriptor.
void print_to(int descriptor, const std::string& text);
}  // namespace tapestry::platform
