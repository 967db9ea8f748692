#pragma once
#include <tapestry/core/error.hpp>
#include <vector>
#include "catch.hpp"

namespace tapestry::test {
/// A file that must be refused.
struct BadFile {
  std::string row;  ///< of the table of bad input, for messages
  std::string content;
  ErrorKind kind;
  std::string position;  ///< "line", "line:column", "@offset" or, of the whole file, ""
  std::string message;   ///< part of it
};

/// Checks that reading each content throws a FileError of its kind that names `path` and the position.
template <class Read>
void check_bad_files(const std::vector<BadFile>& files, const std::string& path, Read read) {
  for (const BadFile& bad : files) {
    INFO(bad.row);
    try {
      read(bad.content);
      FAIL_CHECK("accepted");
    } catch (const FileError& error) {
      INFO(error.what());
      CHECK(static_cast<int>(error.kind()) == static_cast<int>(bad.kind));
      CHECK(error.details().path == path);
      CHECK(error.details().position == bad.position);
      CHECK_THAT(error.what(), contains(bad.message));
    }
  }
}
}  // namespace tapestry::test
