#pragma once
#include <tapestry/io/input_ledger.hpp>
#include <tapestry/io/json.hpp>
#include "output_claim.hpp"

namespace tapestry::shell {
using Json = nlohmann::ordered_json;

void write_text(const std::string& path, const std::string& text);

/// Creates a folder, removes temporaries of killed processes from it, and checks that files can be written
/// into it.
void make_writable_folder(const std::string& folder);

/// Checks that make_writable_folder() would succeed, and leaves nothing behind.
void require_makeable_folder(const std::string& folder);

/// The folder of a run, claimed for this process. A folder made for the run is removed again if the run ends
/// before it writes anything.
class RunFolder {
 public:
  /// \param is_new whether the folder was created for this run
  RunFolder(std::string path, bool is_new);
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  ~RunFolder();

 private:
  std::string path_;
  bool is_new_;
  OutputClaim claim_;
};

/// Makes the first of `base`-001, `base`-002, … that does not exist; never the same folder for two processes.
[[nodiscard]] std::string make_next_folder(const std::string& base);

/// A report as JSON. File names need not be UTF-8; other bytes become U+FFFD.
[[nodiscard]] std::string report_text(const Json& json);

/// Exact text of JSON that will be read again.
/// \throws Error (usage) naming text that is not UTF-8
[[nodiscard]] std::string exact_text(const Json& json, int indent = 2);

[[nodiscard]] Json computed_by_json();

/// Requires a file in a folder that others have written.
/// \param maker  program, with its options, that writes such a folder
/// \throws FileError (malformed) if it lacks; names a folder within that has one
void require_file_of(const std::string& folder, const std::string& file, const std::string& maker);

/// Reads a JSON file of at most 128 MiB, as io::read_json() does: a manifest of half a million inputs.
[[nodiscard]] Json read_json_file(const std::string& path);

/// Every file that the program's ledger has recorded so far, in the order of the paths, with size, SHA-256
/// and roles, see io::InputLedger::Role.
[[nodiscard]] Json recorded_inputs();
}  // namespace tapestry::shell
