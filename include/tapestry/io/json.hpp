#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

/// \file
/// The only public header that includes nlohmann's JSON library, which takes a compiler seconds. tapestry.hpp
/// does not include it; of the library's own files, only those in implementation/ do.

namespace tapestry::io {
inline constexpr std::size_t largest_member_count = std::size_t(1) << 17U;  ///< of a JSON object

/// A JSON text that was read.
struct JsonText {
  nlohmann::json value{};
  std::map<std::string, std::string> positions{};  ///< of the values of the outermost object's members, as
                                                   ///< messages state them
};

/// Reads a JSON text from an untrusted file. Beside what nlohmann's parser refuses by RFC 8259, it refuses
/// duplicate keys, a zero byte, and too many levels or members.
/// Takes memory of at most 48 times the file and 1 MiB.
///
/// \param text     the whole text
/// \param path     the file's name, for messages
/// \param offset   byte where the text begins within another file; 0: it is a file of its own
/// \param deepest largest number of arrays and objects within each other
/// \throws FileError  malformed, where the faulty token begins or goes wrong: "line:column" of a file of its
///                  own, else "@byte"; limit above 131,072 members of an object
[[nodiscard]] JsonText read_json(std::string_view text, const std::string& path, std::uint64_t offset = 0,
                                 std::size_t deepest = 64);
}  // namespace tapestry::io
