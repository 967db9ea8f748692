#include "run_folder.hpp"

#include <tapestry/io/text_lines.hpp>

#include "build_facts.hpp"
#include "formatted.hpp"

namespace tapestry::shell {
void write_text(const std::string& path, const std::string& text) { io::write_file_atomically(path, text); }

void make_writable_folder(const std::string& folder) {
  std::error_code failure;
  std::filesystem::create_directories(io::path_of(folder), failure);
  if (failure || !is_folder(folder, ErrorKind::write))
    throw FileError(
        ErrorKind::write,
        {folder, "", "cannot create the folder" + (failure ? ": " + failure.message() : std::string())});
  io::remove_abandoned_parts(folder);
  require_writable_folder(folder);
}

void require_makeable_folder(const std::string& folder) {
  auto there = io::path_of(folder);
  while (!there.empty() && !is_there(there.string(), ErrorKind::write)) there = there.parent_path();
  try {
    require_writable_folder(there.empty() ? "." : there.string());
  } catch (const FileError& error) {
    throw FileError(error.kind(), {folder, "", "cannot create the folder: " + error.details().what});
  }
}

namespace {
/// The first text of a JSON value that is not UTF-8; empty if there is none.
std::string text_not_utf8(const Json& json) {
  if (json.is_string()) {
    const auto& text = json.get_ref<const std::string&>();
    return io::utf8_prefix(text) == text.size() ? std::string() : text;
  }
  if (json.is_structured())
    for (const Json& member : json)
      if (std::string text = text_not_utf8(member); !text.empty()) return text;
  return {};
}
}  // namespace

RunFolder::RunFolder(std::string path, bool is_new)
    : path_(std::move(path)),
      is_new_(is_new),
      claim_(Claimed::folder, (make_writable_folder(path_), path_)) {}

RunFolder::~RunFolder() {
  claim_.release();
  std::error_code ignored;
  if (is_new_) std::filesystem::remove(io::path_of(path_), ignored);  // fails unless it is empty
}

std::string make_next_folder(const std::string& base) {
  make_writable_folder(io::path_of(base).parent_path().string());
  for (int number = 1;; ++number) {
    const std::string folder = base + formatted("-%03d", number);
    std::error_code failure;
    if (std::filesystem::create_directory(io::path_of(folder), failure)) return folder;
    if (failure && failure != std::errc::file_exists)
      throw FileError(ErrorKind::write, {folder, "", "cannot create the folder: " + failure.message()});
  }
}

std::string report_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string exact_text(const Json& json, int indent) {
  try {
    return json.dump(indent);
  } catch (const Json::type_error&) {
    throw Error(
        ErrorKind::usage,
        text_not_utf8(json) + ": the name is not UTF-8, so the manifest cannot hold it; rename the file");
  }
}

Json computed_by_json() {
  Json facts;
  for (const auto& [name, value] : computed_by()) facts[name] = value;
  return facts;
}

void require_file_of(const std::string& folder, const std::string& file, const std::string& maker) {
  if (is_there(folder + "/" + file, ErrorKind::malformed)) return;
  std::string within;
  std::error_code no_folder;
  for (const auto& entry : std::filesystem::directory_iterator(io::path_of(folder), no_folder))
    if (within.empty() && std::filesystem::exists(entry.path() / file, no_folder))
      within = ", such as " + entry.path().string();
  throw malformed_file(
      {folder, "", "no " + file + " in it", "a folder that " + maker + " has written" + within, ""});
}

Json read_json_file(const std::string& path) {
  return io::read_json(io::read_text_file(path, std::uint64_t(128) << 20U), path).value;
}

Json recorded_inputs() {
  Json inputs = Json::array();
  if (const auto* const ledger = io::InputLedger::active())
    for (const auto& record : ledger->records())
      inputs.push_back({{"path", record.path},
                        {"size", record.size},
                        {"sha256", record.sha256},
                        {"read_as", record.roles}});
  return inputs;
}
}  // namespace tapestry::shell
