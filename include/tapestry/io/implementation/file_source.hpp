#pragma once
#include <cerrno>
#include <cstring>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/input_ledger.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::io {
bool stays_below(const std::string& name) {
  const auto relative = path_of(name).lexically_normal();
  return !relative.has_root_path() && (relative.empty() || *relative.begin() != "..");
}

std::string path_remedy(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path whole = path_of(path);
  fs::path there = whole.root_path();  // "C:" alone is no folder on Windows
  for (const fs::path& part : whole.relative_path()) {
    if (fs::exists(there / part, error)) {
      there /= part;
      continue;
    }
    std::vector<std::string> names;
    fs::directory_iterator entry(there.empty() ? "." : there, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error))
      names.push_back(entry->path().filename().string());
    std::ranges::sort(names);
    const std::string nearest = nearest_word(part.string(), names);
    return nearest.empty() ? "" : "; did you mean " + printable((there / path_of(nearest)).string()) + "?";
  }
  return "";
}

RegularFile::RegularFile(std::string path, std::uint64_t limit) : path_(std::move(path)) {
  if (path_.find('\0') != std::string::npos) fail(ErrorKind::malformed, "file name holds a zero byte");
  if (const int reason = file_.open(path_, platform::Access::read); reason != 0)
    fail(ErrorKind::malformed, std::string("cannot open: ") + std::strerror(reason) + path_remedy(path_));
  platform::FileState now = state();
  using platform::FileKind;
  if (now.kind != FileKind::regular)
    fail(ErrorKind::malformed,
         now.kind == FileKind::folder ? "not a regular file but a folder" : "not a regular file");
  size_ = now.size;
  stamp_ = std::move(now.stamp);
  if (size_ > limit)
    throw FileError(ErrorKind::limit,
                    {path_, "", "file too large", "at most " + std::to_string(limit) + " bytes",
                     std::to_string(size_) + " bytes"});
  record();
}

void RegularFile::read_at(std::uint64_t offset, std::span<std::byte> bytes) const {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const std::ptrdiff_t count = file_.read_at(offset + done, bytes.subspan(done));
    if (count < 0) fail(ErrorKind::malformed, std::string("cannot read: ") + std::strerror(errno));
    if (count == 0)
      throw malformed_file({path_, "@" + std::to_string(offset + done), "file ends early",
                            std::to_string(bytes.size() - done) + " more bytes", "none"});
    done += static_cast<std::size_t>(count);
  }
}

void RegularFile::require_unchanged() const {
  const platform::FileState now = state();
  if (now.size != size_)
    throw malformed_file({path_, "", "file changed while it was read", std::to_string(size_) + " bytes",
                          std::to_string(now.size) + " bytes"});
  if (now.stamp != stamp_) fail(ErrorKind::malformed, "file changed while it was read: it was written to");
}

std::uint64_t RegularFile::name_count() const { return state().name_count; }

platform::FileState RegularFile::state() const {
  platform::FileState state;
  if (const int reason = file_.inspect(state); reason != 0)
    fail(ErrorKind::malformed, std::string("cannot inspect: ") + std::strerror(reason));
  return state;
}

std::string RegularFile::sha256() const {
  Sha256 hash;
  std::vector<std::byte> piece;
  for (std::uint64_t at = 0; at < size_; at += piece.size()) {
    piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(size_ - at, 1U << 20U)));
    read_at(at, piece);
    hash.add(piece);
  }
  return hash.hex();
}

void RegularFile::record() const {
  if (InputLedger* const ledger = InputLedger::active()) ledger->record(*this);
}

std::vector<std::byte> read_file(const std::string& path, std::uint64_t limit) {
  const RegularFile file(path, limit);
  std::vector<std::byte> bytes(static_cast<std::size_t>(file.size()));
  file.read_at(0, bytes);
  file.require_unchanged();
  return bytes;
}

std::string read_text_file(const std::string& path, std::uint64_t limit) {
  const RegularFile file(path, limit);
  std::string text(static_cast<std::size_t>(file.size()), '\0');
  file.read_at(0, std::as_writable_bytes(std::span<char>(text.data(), text.size())));
  file.require_unchanged();
  return text;
}

std::string_view recognised_format(std::span<const std::byte> beginning) {
  const std::string_view text(reinterpret_cast<const char*>(beginning.data()), beginning.size());
  const auto starts = [&](std::string_view magic) { return text.substr(0, magic.size()) == magic; };
  using namespace std::string_view_literals;
  // Tested first: its length field may look like the magic number of any other format.
  if (text.size() > 9 && text[8] == '{' && text.substr(3, 5) == "\0\0\0\0\0"sv)
    return "a safetensors file; convert_weights makes an ONNX model of a detector in one";
  if (starts("version https://git-lfs"sv)) return "a Git LFS pointer, not the file it stands for";
  if (starts("\x1f\x8b"sv)) return "a gzip archive";
  constexpr std::string_view pytorch = "a PyTorch file; export it to ONNX (torch.onnx.export) and give that";
  // The name of a zip archive's first member begins at byte 30; its length stands at byte 26.
  if (starts("PK\x03\x04"sv) && text.size() > 30)
    if (text.substr(30, static_cast<unsigned char>(text[26])).ends_with("/data.pkl")) return pytorch;
  if (starts("\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19"sv)) return pytorch;  // before 1.6
  if (starts("PK\x03\x04"sv)) return "a zip archive (npz, or a PyTorch checkpoint)";
  if (starts("\x80\x02"sv) || starts("\x80\x03"sv) || starts("\x80\x04"sv)) return "a Python pickle";
  if (starts("\x93NUMPY"sv)) return "a NumPy array";
  if (starts("\x89PNG"sv)) return "a PNG image";
  if (starts("\xff\xd8\xff"sv)) return "a JPEG image";
  if (starts("%PDF"sv)) return "a PDF document";
  if (starts("\x7f"
             "ELF"sv))
    return "a program";
  if (starts("\x08"sv) && text.size() > 3 && text[1] > 0 && text[1] < 16 &&
      (text[2] == 0x12 || text[2] == 0x1a))
    return "an ONNX model";
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '<') return "an HTML or XML page";
  return {};
}

void Sha256::add(std::span<const std::byte> bytes) {
  length_ += bytes.size();
  while (!bytes.empty()) {
    const std::size_t taken = std::min(bytes.size(), block_.size() - filled_);
    std::memcpy(block_.data() + filled_, bytes.data(), taken);
    bytes = bytes.subspan(taken);
    filled_ += taken;
    if (filled_ == block_.size()) mix();
  }
}

std::string Sha256::hex() {
  const std::uint64_t bits = length_ * 8;
  const std::array<std::byte, 64> padding{std::byte{0x80}};
  add(std::span(padding).first(1 + (119 - filled_) % 64));
  std::array<std::byte, 8> length{};
  for (std::size_t i = 0; i < 8; ++i) length[i] = static_cast<std::byte>(bits >> (56 - 8 * i) & 0xFFU);
  add(length);
  std::string text;
  for (const std::uint32_t word : state_)
    for (unsigned shift = 32; shift > 0; shift -= 4) text += "0123456789abcdef"[word >> (shift - 4) & 15U];
  return text;
}

void Sha256::mix() {
  filled_ = 0;
  std::array<std::uint32_t, 64> w{};
  for (std::size_t t = 0; t < 16; ++t)
    for (std::size_t i = 0; i < 4; ++i) w[t] = w[t] << 8U | std::to_integer<std::uint32_t>(block_[4 * t + i]);
  for (std::size_t t = 16; t < 64; ++t) {
    const std::uint32_t s0 = std::rotr(w[t - 15], 7) ^ std::rotr(w[t - 15], 18) ^ w[t - 15] >> 3U;
    const std::uint32_t s1 = std::rotr(w[t - 2], 17) ^ std::rotr(w[t - 2], 19) ^ w[t - 2] >> 10U;
    w[t] = w[t - 16] + s0 + w[t - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state_;
  for (std::size_t t = 0; t < 64; ++t) {
    const std::uint32_t sum1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const std::uint32_t t1 = h + sum1 + ((e & f) ^ (~e & g)) + constants[t] + w[t];
    const std::uint32_t sum0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const std::uint32_t t2 = sum0 + ((a & b) ^ (a & c) ^ (b & c));
    h = std::exchange(g, std::exchange(f, std::exchange(e, d + t1)));
    d = std::exchange(c, std::exchange(b, std::exchange(a, t1 + t2)));
  }
  const std::array<std::uint32_t, 8> added{a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < 8; ++i) state_[i] += added[i];
}

std::string sha256(std::string_view bytes) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span<const char>(bytes.data(), bytes.size())));
  return hash.hex();
}

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
  return std::ranges::find(left_out_, folder) != left_out_.end();
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
    throw file_mismatch({file.path(), "", "the file has changed since it was first read",
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
