#pragma once
#include <stdexcept>
#include <string>
#include <tapestry/version.hpp>
#include <utility>

namespace tapestry {

/// Kind of an error; its value is the exit code that Tapestry's programs return for it.
enum class ErrorKind {
  usage = 2,      ///< an option or argument that makes no sense
  malformed = 3,  ///< input unreadable, or not in the format that it claims
  mismatch = 4,   ///< inputs well-formed, but they do not fit each other
  write = 5,      ///< output cannot be written
  numeric = 6,    ///< a value that is not finite where one is needed
  in_use = 7,     ///< output folder in use, or of another run
  limit = 8,      ///< larger than a stated limit on memory, size or time
};

/// The root of every exception that Tapestry throws.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  /// The kind of this error.
  [[nodiscard]] ErrorKind kind() const noexcept { return kind_; }

 private:
  ErrorKind kind_;
};

/// An argument has extents that the operation cannot accept.
class ShapeError : public Error {
 public:
  explicit ShapeError(const std::string& message) : Error(ErrorKind::mismatch, message) {}
};

/// An argument lies outside what the operation is defined for.
class DomainError : public Error {
 public:
  explicit DomainError(const std::string& message) : Error(ErrorKind::usage, message) {}
};

/// A value that should be finite is not.
class NumericError : public Error {
 public:
  explicit NumericError(const std::string& message) : Error(ErrorKind::numeric, message) {}
};

/// Something is wrong with a file. The message reads
/// `<path>:<position>: <what>; expected <expected>, found <found>`, each part left out when empty.
class FileError : public Error {
 public:
  /// The parts of the message, for callers that show them in their own way.
  struct Details {
    std::string path;        ///< as the user gave it
    std::string position{};  ///< "12" for a line, "@20" for a byte offset
    std::string what{};      ///< the complaint, lower case, without a full stop
    std::string expected{};
    std::string found{};
  };

  FileError(ErrorKind kind, Details details)
      : Error(kind, message_of(details)), details_(std::move(details)) {}
  [[nodiscard]] const Details& details() const noexcept { return details_; }

 private:
  static std::string message_of(const Details& details) {
    std::string text = details.path;
    if (!details.position.empty()) text += ":" + details.position;
    text += ": " + details.what;
    if (!details.expected.empty()) text += "; expected " + details.expected;
    if (!details.found.empty()) text += (details.expected.empty() ? "; found " : ", found ") + details.found;
    return text;
  }

  Details details_;
};

namespace detail {
template <class Extents>
std::string to_text(const Extents& extents) {
  std::string text = "[";
  for (const auto extent : extents) text += (text.size() > 1 ? ", " : "") + std::to_string(extent);
  return text + "]";
}
}  // namespace detail

/// Throws ShapeError, naming the operation and both extents, unless `array` has the `expected` extents.
template <class Array>
void require_shape(const char* operation, const char* argument, const Array& array,
                   const typename Array::shape_type& expected) {
  if (array.shape() != expected) {
    throw ShapeError(std::string(operation) + ": " + argument + " is " + detail::to_text(array.shape()) +
                     ", expected " + detail::to_text(expected));
  }
}

}  // namespace tapestry
