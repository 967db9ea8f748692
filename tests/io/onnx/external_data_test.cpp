#include <tapestry/io/detail/onnx/external_data.hpp>

#include <tapestry/io/input_ledger.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../../support/onnx_builder.hpp"
#include "../../support/refusal.hpp"
#include "../../support/temporary_folder.hpp"

namespace fs = std::filesystem;
using namespace tapestry;
using namespace tapestry::test;

namespace {
using Entries = std::vector<std::pair<std::string, std::string>>;

/// A model whose constant "far" of two floats lies elsewhere.
std::string model_with(const Entries& entries, const std::string& more = "") {
  onnx::ModelParts parts = onnx::small_model();
  parts.initialisers.push_back(onnx::tensor("far", onnx::float32, {2}, onnx::external(entries) + more));
  return onnx::model(parts);
}

std::vector<float> read_far(const std::string& path, const io::OnnxLimits& limits = {}) {
  return std::get<std::vector<float>>(io::read_onnx(path, limits).constants.at("far").values);
}
}  // namespace

TEST_CASE("elements are read from files beside the model", "[io][onnx][posix]") {
  const TemporaryFolder folder;
  fs::create_directory(folder.path("parts"));
  folder.write("parts/weights.bin", "12345678" + onnx::raw_floats({1.5F, -2.0F}) + "9");
  folder.write("exact.bin", onnx::raw_floats({3, 4}));
  const std::vector<float> within = {1.5F, -2.0F};
  CHECK(read_far(folder.write("a.onnx", model_with({{"location", "parts/weights.bin"},
                                                    {"offset", "8"},
                                                    {"length", "8"},
                                                    {"checksum", "unknown keys pass"}}))) == within);
  CHECK(read_far(folder.write("a.onnx", model_with({{"location", "./exact.bin"}}))) ==
        std::vector<float>{3, 4});
  fs::create_symlink("parts/weights.bin", folder.path("link.bin"));
  fs::create_directory_symlink("parts", folder.path("again"));
  for (const char* location : {"link.bin", "again/weights.bin"})
    CHECK(read_far(folder.write(
              "a.onnx", model_with({{"location", location}, {"offset", "8"}, {"length", "8"}}))) == within);
}

TEST_CASE("the layout of model hubs is read: links to blobs beside each other", "[io][onnx][posix]") {
  const TemporaryFolder hub;
  for (const char* name : {"blobs", "snapshots", "snapshots/main", "snapshots/main/onnx"})
    fs::create_directory(hub.path(name));
  hub.write("blobs/0123", model_with({{"location", "model.onnx_data"}}));
  hub.write("blobs/4567", onnx::raw_floats({3, 4}));
  fs::create_symlink("../../../blobs/0123", hub.path("snapshots/main/onnx/model.onnx"));
  fs::create_symlink("../../../blobs/4567", hub.path("snapshots/main/onnx/model.onnx_data"));
  CHECK(read_far(hub.path("snapshots/main/onnx/model.onnx")) == std::vector<float>{3, 4});
}

TEST_CASE("X17: a linked model opens nothing but its folder and the files beside it",
          "[io][onnx][posix][bad_input]") {
  const TemporaryFolder hub;
  for (const char* name : {"blobs", "blobs/below", "other", "model", "plain"})
    fs::create_directory(hub.path(name));
  hub.write("blobs/below/secret", onnx::raw_floats({1, 2}));
  hub.write("other/secret", onnx::raw_floats({1, 2}));
  hub.write("blobs/0123", model_with({{"location", "far"}}));
  hub.write("blobs/4567", onnx::raw_floats({3, 4}));
  fs::create_symlink("../blobs/0123", hub.path("model/a.onnx"));
  const std::string refused = "external data 'far' is a link that leads out of the folder";
  for (const char* target : {"../other/secret", "../blobs/below/secret"}) {
    fs::create_symlink(target, hub.path("model/far"));
    check_refused(ErrorKind::malformed, refused, [&] { (void)read_far(hub.path("model/a.onnx")); });
    fs::remove(hub.path("model/far"));
  }
  // Without a link beside the model there is no such file; a model that is no link has its own folder alone.
  check_refused(ErrorKind::malformed, "external data 'far' cannot be opened",
                [&] { (void)read_far(hub.path("model/a.onnx")); });
  fs::create_symlink("../blobs/4567", hub.path("plain/far"));
  const auto plain = hub.write("plain/a.onnx", model_with({{"location", "far"}}));
  check_refused(ErrorKind::malformed, refused, [&] { (void)read_far(plain); });
}

TEST_CASE("a file with several names is refused, for the others may lie anywhere",
          "[io][onnx][posix][bad_input]") {
  const TemporaryFolder folder, elsewhere;  // X17
  const auto secret = elsewhere.write("secret.bin", onnx::raw_floats({3, 4}));
  const auto model = folder.write("a.onnx", model_with({{"location", "exact.bin"}}));
  std::error_code failure;
  fs::create_hard_link(secret, folder.path("exact.bin"), failure);
  if (failure) {
    WARN("skipped: no hard links here");
    return;
  }
  check_refused(ErrorKind::malformed,
                "external data 'exact.bin' is a hard link, whose other names may lie outside of the folder; "
                "expected a file of one name, such as a copy, found 2 names",
                [&] { (void)read_far(model); });
  fs::remove(secret);
  CHECK(read_far(model) == std::vector<float>{3, 4});
}

TEST_CASE("a ledger holds the files that a model's elements lie in", "[io][onnx][input_ledger]") {
  const TemporaryFolder folder;
  const auto far = folder.write("exact.bin", onnx::raw_floats({3, 4}));
  const auto model = folder.write("a.onnx", model_with({{"location", "exact.bin"}}));
  const io::InputLedger ledger;
  (void)io::read_onnx(model);
  const auto records = ledger.records();
  REQUIRE(records.size() == 2);
  CHECK(records[0].path == model);
  CHECK(records[1].path == far);
  CHECK(records[1].sha256 == io::sha256(onnx::raw_floats({3, 4})));
}

TEST_CASE("a file of one tensor may have its elements beside it", "[io][onnx]") {
  const TemporaryFolder folder;
  folder.write("exact.bin", std::string("\1\0\0\0\0\0\0\0", 8));
  const std::string tensor = onnx::tensor("", onnx::int64, {1}, onnx::external({{"location", "exact.bin"}}));
  CHECK(io::read_onnx_tensor(folder.write("a.pb", tensor)).at(0) == 1);
}

TEST_CASE("a tensor without elements needs no more than a file", "[io][onnx]") {
  const TemporaryFolder folder;
  folder.write("empty.bin", "");
  const std::string tensor =
      onnx::tensor("", onnx::float32, {0}, onnx::external({{"location", "empty.bin"}}));
  CHECK(io::read_onnx_tensor(folder.write("a.pb", tensor)).size() == 0);
}

TEST_CASE("X17: files outside the model's folder, or unfit ones, are refused",
          "[io][onnx][posix][bad_input]") {
  const TemporaryFolder outside;
  const std::string secret = outside.write("secret.bin", onnx::raw_floats({1, 2}));
  const TemporaryFolder folder;
  fs::create_directory(folder.path("models"));
  fs::create_directory(folder.path("models/folder"));
  fs::create_directory(folder.path("models-too"));
  folder.write("above.bin", onnx::raw_floats({1, 2}));
  folder.write("models-too/a.bin", onnx::raw_floats({1, 2}));
  folder.write("models/short.bin", "1234");
  folder.write("models/long.bin", "123456789");
  folder.write("models/exact.bin", "12345678");
  fs::create_symlink(secret, folder.path("models/link.bin"));
  fs::create_directory_symlink(outside.path(), folder.path("models/linked"));
  fs::create_symlink("../models-too/a.bin", folder.path("models/neighbour.bin"));
  fs::create_symlink("loop.bin", folder.path("models/loop.bin"));
  const std::string inside = "expected a path inside the model's folder";
  struct Row {
    Entries entries;
    ErrorKind kind;
    std::string text;
  };
  const auto malformed = ErrorKind::malformed;
  const auto mismatch = ErrorKind::mismatch;
  const Row rows[] = {
      {{}, malformed, "initialiser 2 'far': external data '' names no file; " + inside},
      {{{"location", secret}}, malformed, "is an absolute path; " + inside},
      {{{"location", "../above.bin"}}, malformed, "'../above.bin' leaves its folder by '..'; " + inside},
      {{{"location", "folder/../exact.bin"}}, malformed, "leaves its folder by '..'"},
      {{{"location", std::string("exact.bin\0x", 11)}}, malformed, "names no file"},
      {{{"location", "link.bin"}}, malformed, "is a link that leads out of the folder; " + inside},
      {{{"location", "linked/secret.bin"}}, malformed, "is a link that leads out of the folder"},
      {{{"location", "neighbour.bin"}}, malformed, "is a link that leads out of the folder"},
      {{{"location", "loop.bin"}}, malformed, "external data 'loop.bin' cannot be opened"},
      {{{"location", "absent.bin"}}, malformed, "external data 'absent.bin' cannot be opened: No such file"},
      {{{"location", "folder"}}, malformed, "external data 'folder': not a regular file but a folder"},
      {{{"location", "."}}, malformed, "not a regular file but a folder"},
      {{{"location", "short.bin"}}, mismatch, "does not fit type and extents; expected 8 bytes, found 4"},
      {{{"location", "long.bin"}}, mismatch, "does not fit type and extents; expected 8 bytes, found 9"},
      {{{"location", "long.bin"}, {"length", "4"}}, mismatch, "expected 8 bytes, found 4"},
      {{{"location", "exact.bin"}, {"offset", "4"}}, mismatch, "expected 8 bytes, found 4"},
      {{{"location", "exact.bin"}, {"offset", "4"}, {"length", "8"}},
       mismatch,
       "ends early; expected 8 bytes from byte 4 on, found 8 bytes in all"},
      {{{"location", "exact.bin"}, {"offset", "4611686018427387904"}}, mismatch, "ends early"},
      {{{"location", "exact.bin"}, {"offset", "-1"}},
       malformed,
       "offset of external data; expected a whole number of bytes, found '-1'"},
      {{{"location", "exact.bin"}, {"offset", ""}}, malformed, "found ''"},
      {{{"location", "exact.bin"}, {"length", "8 "}}, malformed, "length of external data"},
      {{{"location", "exact.bin"}, {"length", "0x8"}}, malformed, "length of external data"},
      {{{"location", "exact.bin"}, {"length", "18446744073709551616"}}, malformed, "length of external data"},
      {{{"location", "exact.bin"}, {"length", "18446744073709551615"}}, malformed, "length of external data"},
  };
  for (const Row& row : rows) {
    const std::string path = folder.write("models/a.onnx", model_with(row.entries));
    INFO(row.text);
    check_refused(row.kind, row.text, [&] { (void)io::read_onnx(path); });
    check_refused(row.kind, path + ":@", [&] { (void)io::read_onnx(path); });
  }
}

TEST_CASE("files beside a model are read up to a limit for all of them", "[io][onnx][bad_input]") {  // X17
  const TemporaryFolder folder;
  folder.write("exact.bin", onnx::raw_floats({3, 4}));
  onnx::ModelParts parts = onnx::small_model();
  for (const char* name : {"a", "b", "c"})
    parts.initialisers.push_back(
        onnx::tensor(name, onnx::float32, {2}, onnx::external({{"location", "exact.bin"}})));
  const std::string path = folder.write("a.onnx", onnx::model(parts));
  CHECK(io::read_onnx(path, {.external_bytes = 24}).constants.size() == 6);
  check_refused(
      ErrorKind::limit,
      "initialiser 4 'c': external data 'exact.bin' is too much with that of other tensors; expected at "
      "most 23 bytes in all",
      [&] { (void)io::read_onnx(path, {.external_bytes = 23}); });
}

TEST_CASE("elements in the model do not count where it names another file", "[io][onnx]") {
  const TemporaryFolder folder;
  folder.write("exact.bin", onnx::raw_floats({3, 4}));
  const std::string both = onnx::bytes_field(9, onnx::raw_floats({5, 6, 7}));
  CHECK(read_far(folder.write("a.onnx", model_with({{"location", "exact.bin"}}, both))) ==
        std::vector<float>{3, 4});
}
