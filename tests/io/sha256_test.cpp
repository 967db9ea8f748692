#include <tapestry/io/file_source.hpp>

#include "../support/catch.hpp"
#include "../support/temporary_folder.hpp"

namespace io = tapestry::io;

// The examples that NIST publishes for FIPS 180-4.
TEST_CASE("sha256 gives the published digests", "[io][sha256]") {
  CHECK(io::sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(io::sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(io::sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(io::sha256(std::string(1000000, 'a')) ==
        "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("sha256 does not depend on how the bytes are cut", "[io][sha256]") {
  const std::string bytes(200, 'x');
  for (std::size_t length = 50; length < 140; ++length) {
    io::Sha256 hash;
    const auto all = std::as_bytes(std::span<const char>(bytes.data(), length));
    for (std::size_t at = 0; at < length; at += 7)
      hash.add(all.subspan(at, std::min<std::size_t>(7, length - at)));
    CHECK(hash.hex() == io::sha256(bytes.substr(0, length)));
  }
  const tapestry::test::TemporaryFolder folder;
  const std::string large(3000000, 'y');
  CHECK(io::RegularFile(folder.write("a", large)).sha256() == io::sha256(large));
}
