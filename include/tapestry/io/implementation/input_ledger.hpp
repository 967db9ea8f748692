#pragma once
#include <atomic>
#include <filesystem>
#include <mutex>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/input_ledger.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {
namespace detail {

std::atomic<InputLedger*>& active_ledger() {
  static std::atomic<InputLedger*> ledger{nullptr};
  return ledger;
}

}  // namespace detail

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
  left_out_.push_back((std::filesystem::path(folder) / "").lexically_normal().string());
}

bool InputLedger::is_left_out(const std::string& path) const {
  const auto folder = (std::filesystem::path(path).parent_path() / "").lexically_normal().string();
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
  if (known != entries_.end() && known->second.stamp == file.stamp()) return;
  lock.unlock();
  FileRecord record{file.path(), file.size(), file.sha256()};
  file.require_unchanged();
  lock.lock();
  const auto [entry, is_new] = entries_.try_emplace(file.path(), Entry{record, file.stamp()});
  if (!is_new && entry->second.record != record)
    throw FileError(ErrorKind::mismatch,
                    {file.path(), "", "the file has changed since it was first read",
                     "SHA-256 " + entry->second.record.sha256, "SHA-256 " + record.sha256});
  entry->second.stamp = file.stamp();
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
