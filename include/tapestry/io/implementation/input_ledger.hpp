#pragma once
#include <atomic>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/input_ledger.hpp>

namespace tapestry::io {
namespace detail {

std::atomic<InputLedger*>& active_ledger() {
  static std::atomic<InputLedger*> ledger{nullptr};
  return ledger;
}

/// The innermost role of this thread; null without one.
const std::string*& current_role() {
  thread_local const std::string* role = nullptr;
  return role;
}

/// Adds the current role, if there is one and it is not there yet.
void add_current_role(FileRecord& record) {
  if (current_role() == nullptr) return;
  const auto place = std::ranges::lower_bound(record.roles, *current_role());
  if (place == record.roles.end() || *place != *current_role()) record.roles.insert(place, *current_role());
}

}  // namespace detail

InputLedger::Role::Role(std::string words)
    : words_(std::move(words)), outer_(std::exchange(detail::current_role(), &words_)) {}

InputLedger::Role::~Role() { detail::current_role() = outer_; }

InputLedger::InputLedger() {
  InputLedger* none = nullptr;
  if (!detail::active_ledger().compare_exchange_strong(none, this))
    throw DomainError("InputLedger: another ledger records already");
}

InputLedger::~InputLedger() { detail::active_ledger() = nullptr; }

InputLedger* InputLedger::active() { return detail::active_ledger(); }

void InputLedger::leave_out(const std::string& folder) {
  if (folder.empty()) return;
  const std::lock_guard lock(mutex_);
  left_out_.push_back((path_of(folder) / "").lexically_normal().string());
}

bool InputLedger::is_left_out(const std::string& path) const {
  const auto folder = (path_of(path).parent_path() / "").lexically_normal().string();
  for (const std::string& left_out : left_out_)
    if (folder == left_out) return true;
  return false;
}

void InputLedger::note(const std::string& path) {
  const RegularFile file(path);
  file.require_unchanged();
}

void InputLedger::record(const RegularFile& file) {
  std::unique_lock lock(mutex_);
  if (is_left_out(file.path())) return;
  const auto known = entries_.find(file.path());
  if (known != entries_.end() && known->second.stamp == file.stamp())
    return detail::add_current_role(known->second.record);
  lock.unlock();
  const std::string sha256 = file.sha256();
  file.require_unchanged();
  lock.lock();
  auto& [record, stamp] =
      entries_.try_emplace(file.path(), Entry{{file.path(), file.size(), sha256}, {}}).first->second;
  if (record.sha256 != sha256)
    throw FileError(ErrorKind::mismatch, {file.path(), "", "the file has changed since it was first read",
                                          "SHA-256 " + record.sha256, "SHA-256 " + sha256});
  stamp = file.stamp();
  detail::add_current_role(record);
}

std::vector<FileRecord> InputLedger::records() const {
  const std::lock_guard lock(mutex_);
  std::vector<FileRecord> records;
  for (const auto& [path, entry] : entries_) records.push_back(entry.record);
  return records;
}

std::string InputLedger::digest() const {
  std::string text;
  for (const FileRecord& record : records()) text += record.path + '\n' + record.sha256 + '\n';
  return sha256(text);
}

}  // namespace tapestry::io
