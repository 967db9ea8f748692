#pragma once
#include <tapestry/core/error.hpp>
#include "catch.hpp"

namespace tapestry::test {
/// A row of a table of refused contents.
struct BadContent {
  const char* id;  ///< of the table of bad input, for messages
  std::string file;
  ErrorKind kind;
  const char* text;  ///< part of the message
};

/// Checks that the action throws a tapestry::Error of this kind whose message holds this text.
template <class Action>
void check_refused(ErrorKind kind, const std::string& text, Action action) {
  try {
    action();
    FAIL_CHECK("was accepted; expected a refusal with '" << text << "'");
  } catch (const Error& error) {
    INFO(error.what());
    CHECK(static_cast<int>(error.kind()) == static_cast<int>(kind));
    CHECK(std::string(error.what()).find(text) != std::string::npos);
  }
}
}  // namespace tapestry::test
