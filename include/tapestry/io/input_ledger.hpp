#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <vector>

namespace tapestry::io {
class RegularFile;

/// A file that was read: its path as it was opened, its size in bytes, the SHA-256 of its content, and what
/// it was read as, see InputLedger::Role.
struct FileRecord {
  std::string path{};
  std::uint64_t size = 0;
  std::string sha256{};
  std::vector<std::string> roles{};  ///< in alphabetical order, each once

  [[nodiscard]] bool operator==(const FileRecord&) const = default;
};

/// Records every file that this process opens for reading while the ledger lives, by the bytes that the
/// reader gets: a file is hashed through the descriptor that it is read from, and refused if it changes
/// before the reader has finished. A path that is opened again must still hold the same bytes. So a result
/// can state its inputs; the readers need no list of them.
///
/// A file costs one more pass over its bytes when it is first opened, and again only if its time stamp
/// changes. Threads may open files at once. At most one ledger lives at a time.
class InputLedger {
 public:
  /// \throws DomainError if another ledger lives
  InputLedger();
  InputLedger(const InputLedger&) = delete;
  InputLedger& operator=(const InputLedger&) = delete;
  ~InputLedger();

  /// Names, while it lives, the role of files read by this thread, as "detector". The innermost role counts.
  class Role {
   public:
    explicit Role(std::string words);
    Role(const Role&) = delete;
    Role& operator=(const Role&) = delete;
    ~Role();

   private:
    std::string words_;
    const std::string* outer_;
  };

  /// Leaves out files directly in this folder: a program's own results are no inputs. An empty name is none.
  void leave_out(const std::string& folder);

  /// Records a file that will be read later. It then has to hold the same bytes.
  /// \throws FileError as RegularFile
  static void note(const std::string& path);

  /// Everything recorded so far, in the order of the paths.
  [[nodiscard]] std::vector<FileRecord> records() const;

  /// SHA-256 over all paths and hashes: equal for processes that read the same.
  [[nodiscard]] std::string digest() const;

  /// The ledger that lives, or null.
  [[nodiscard]] static InputLedger* active();

 private:
  friend class RegularFile;

  struct Entry {
    FileRecord record{};
    std::string stamp{};  ///< RegularFile's stamp when the file was hashed
  };

  /// \throws FileError (mismatch) if the path held other bytes before
  void record(const RegularFile& file);

  [[nodiscard]] bool is_left_out(const std::string& path) const;

  mutable std::mutex mutex_{};
  std::map<std::string, Entry> entries_{};
  std::vector<std::string> left_out_{};
};
}  // namespace tapestry::io
