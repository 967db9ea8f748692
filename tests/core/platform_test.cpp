#include <tapestry/core/platform.hpp>
#include <tapestry/core/platform/memory.hpp>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "../support/catch.hpp"

// Uses nothing of POSIX itself, so that tests/reach.sh runs it on other systems, too.

namespace platform = tapestry::platform;
using platform::Access, platform::FileKind, platform::FileState, platform::OpenFile;

namespace {
/// A folder for one test, with no file in it.
std::string empty_folder() {
  const auto folder = std::filesystem::temp_directory_path() /
                      ("tapestry-platform-" + std::to_string(platform::process_number()));
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  return folder.string();
}

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span<const char>(text.data(), text.size()));
}

std::string text_at(const OpenFile& file, std::uint64_t offset) {
  std::string text(100, '\0');
  const auto count = file.read_at(offset, std::as_writable_bytes(std::span<char>(text.data(), text.size())));
  REQUIRE(count >= 0);
  text.resize(static_cast<std::size_t>(count));
  return text;
}
}  // namespace

TEST_CASE("a file is made once, and renamed over another", "[core][platform]") {
  const std::string folder = empty_folder(), first = folder + "/first", second = folder + "/second";
  for (const auto& [path, text] : {std::pair{first, "one"}, std::pair{second, "two, longer"}}) {
    OpenFile file;
    CHECK(file.open(path, Access::create) == 0);
    CHECK(file.write(bytes_of(text)) == 0);
    CHECK(file.flush() == 0);
    OpenFile again;
    CHECK(again.open(path, Access::create) == EEXIST);
    CHECK_FALSE(again.is_open());
  }
  CHECK(platform::replace_file(second, first) == 0);
  CHECK(platform::flush_folder(folder) == 0);
  CHECK_FALSE(std::filesystem::exists(second));
  OpenFile file;
  REQUIRE(file.open(first, Access::read) == 0);
  CHECK(text_at(file, 0) == "two, longer");
  CHECK(text_at(file, 5) == "longer");
  CHECK(text_at(file, 50).empty());
  file.close();
  CHECK(platform::remove_file(first.c_str()) == 0);
  CHECK(platform::remove_file(first.c_str()) == ENOENT);
  CHECK(file.open(first, Access::read) == ENOENT);
  CHECK(file.open(folder + "/absent/file", Access::create) == ENOENT);
  std::filesystem::remove_all(folder);
}

TEST_CASE("the state of an open file changes when it is written to", "[core][platform]") {
  const std::string folder = empty_folder(), path = folder + "/file";
  std::ofstream(path) << "abc";
  OpenFile file;
  REQUIRE(file.open(path, Access::read) == 0);
  FileState before, after;
  CHECK(file.inspect(before) == 0);
  CHECK(before.kind == FileKind::regular);
  CHECK(before.size == 3);
  CHECK(before.name_count == 1);
  CHECK(file.inspect(after) == 0);
  CHECK(after.stamp == before.stamp);
  std::ofstream(path, std::ios::app) << "d";
  CHECK(file.inspect(after) == 0);
  CHECK(after.size == 4);
  CHECK(after.stamp != before.stamp);
  file.close();
#if !defined(__EMSCRIPTEN__)  // every file counts as regular there
  CHECK(file.open(folder, Access::read) == 0);
  CHECK(file.inspect(after) == 0);
  CHECK(after.kind == FileKind::folder);
  file.close();
#endif
  std::filesystem::remove_all(folder);
}

#if !defined(__EMSCRIPTEN__)  // no locks there
TEST_CASE("one open file has the lock, until it is closed or its file deleted", "[core][platform]") {
  const std::string folder = empty_folder(), path = folder + "/lock";
  std::ofstream(path) << "an earlier owner";
  OpenFile first, second;
  REQUIRE(first.open(path, Access::share) == 0);
  REQUIRE(second.open(path, Access::share) == 0);
  CHECK(first.lock() == 0);
  CHECK(second.lock() == EWOULDBLOCK);
  CHECK(first.replace(bytes_of("owner")) == 0);
  CHECK(text_at(second, 0) == "owner");
  OpenFile moved = std::move(first);
  CHECK(second.lock() == EWOULDBLOCK);
  CHECK(moved.is_still_at(path));
  CHECK(platform::remove_file(path.c_str()) == 0);
  CHECK_FALSE(moved.is_still_at(path));
  CHECK_FALSE(second.is_still_at(path));
  moved.close();
  std::ofstream(folder + "/other") << "x";
  REQUIRE(second.open(folder + "/other", Access::share) == 0);
  CHECK(second.lock() == 0);
  second.close();
  REQUIRE(second.open(folder + "/other", Access::share) == 0);
  CHECK(second.lock() == 0);
  CHECK(second.is_still_at(folder + "/other"));
  CHECK_FALSE(second.is_still_at(folder));
  second.close();
  std::filesystem::remove_all(folder);
}

TEST_CASE("a process is known to the system", "[core][platform]") {
  CHECK(std::filesystem::is_regular_file(platform::program_path()));
  CHECK(platform::process_number() > 0);
  CHECK_FALSE(platform::host_name().empty());
  const double before = platform::process_cost().peak_mib;
  std::vector<char> memory(std::size_t(64) << 20U, 'x');
  CHECK(platform::process_cost().peak_mib >= before + (memory.back() == 'x' ? 32 : 0));
  CHECK_FALSE(platform::processor_name().empty());
}
#endif

TEST_CASE("pages are aligned as their size asks for, to the last byte", "[core][platform]") {
  for (const std::size_t size : {1U, 100U, (2U << 20U) - 1U, 2U << 20U, (5U << 20U) + 3U}) {
    void* const memory = platform::allocate_pages(size);
    CHECK(reinterpret_cast<std::uintptr_t>(memory) % (size < 2U << 20U ? 64U : 2U << 20U) == 0);
    std::memset(memory, 1, size);
    platform::FreePages{size}(memory);
  }
}

TEST_CASE("a pool hands released blocks out again and holds a quarter more than was once in use",
          "[core][platform]") {
  platform::PagePool pool;
  constexpr std::size_t mib = std::size_t(1) << 20U;
  void* const first = pool.take(3 * mib);
  void* const second = pool.take(mib);
  CHECK(pool.use().in_use == 4 * mib);
  pool.give(first, 3 * mib);
  pool.give(second, mib);
  CHECK(pool.use().in_use == 0);
  CHECK(pool.use().kept == (platform::PagePool::keeps_blocks ? 4 * mib : 0));
  if (!platform::PagePool::keeps_blocks) return;

  CHECK(pool.take(3 * mib - 1) == first);  // of the same class
  void* const other = pool.take(2 * mib);  // none is kept of this class: the one of 1 MiB leaves
  CHECK(pool.use().kept == 0);
  CHECK(pool.use().peak == 5 * mib);
  pool.give(first, 3 * mib - 1);
  pool.give(other, 2 * mib);
  CHECK(pool.use().kept == 5 * mib);
  void* const small = pool.take(mib / 2);  // 5 and a half are within a quarter more
  CHECK(pool.use().kept == 5 * mib);
  pool.give(small, mib / 2);
  // A size that a loop asks for each time stays; others leave for each other.
  for (std::size_t size = mib; size < 2 * mib; size += mib / 8) {
    CHECK(pool.take(3 * mib) == first);
    pool.give(first, 3 * mib);
    pool.give(pool.take(size), size);
    CHECK(pool.use().kept <= 25 * mib / 4);
  }
  pool.release();
  CHECK(pool.use().kept == 0);
  CHECK(pool.use().peak == 0);
}

TEST_CASE("a pool's blocks hold what was asked for, up to sizes that no system has", "[core][platform]") {
  platform::PagePool pool;
  for (std::size_t size = platform::PagePool::smallest; size < (std::size_t(8) << 20U);
       size += size / 7 + 1) {
    void* const memory = pool.take(size);
    CHECK(reinterpret_cast<std::uintptr_t>(memory) % platform::alignment_for(size) == 0);
    CHECK(pool.use().in_use >= size);
    CHECK(pool.use().in_use <= size + size / 8 + 1);
    std::memset(memory, 1, size);
    pool.give(memory, size);
  }
  pool.release();
  constexpr std::size_t most = std::numeric_limits<std::size_t>::max();
  CHECK_THROWS_AS(pool.take(most), std::bad_alloc);
  if (platform::PagePool::keeps_blocks)  // AddressSanitizer ends the program instead
    CHECK_THROWS_AS(pool.take(most / 2), std::bad_alloc);
  CHECK_THROWS_AS(platform::PageAllocator<double>().allocate(most / 4), std::bad_alloc);
  CHECK(pool.use().in_use == 0);
}
