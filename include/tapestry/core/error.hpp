#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
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

/// A part of a message: text, a number, or extents, which read [2, 3].
class MessagePart {
 public:
  MessagePart(std::string_view text) : kind_(Kind::text), text_(text.data()), size_(text.size()) {}
  MessagePart(const char* text) : MessagePart(std::string_view(text)) {}
  MessagePart(const std::string& text) : MessagePart(std::string_view(text)) {}
  template <std::signed_integral Integer>
  MessagePart(Integer number) : kind_(Kind::integer), integer_(number) {}
  template <std::unsigned_integral Integer>
  MessagePart(Integer number) : kind_(Kind::count), count_(number) {}
  template <std::floating_point F>
  MessagePart(F number) : kind_(Kind::number), number_(static_cast<double>(number)) {}
  template <class Extents>
  requires requires(const Extents& e) {
    { e.data() } -> std::convertible_to<const std::size_t*>;
  }
  MessagePart(const Extents& extents)
      : kind_(Kind::extents), extents_(extents.data()), size_(extents.size()) {}
  MessagePart(char) = delete;  // a letter or a number?

  void append_to(std::string& message) const {
    if (kind_ == Kind::text) message.append(text_, size_);
    if (kind_ == Kind::integer) message += std::to_string(integer_);
    if (kind_ == Kind::count) message += std::to_string(count_);
    if (kind_ == Kind::number) message += std::to_string(number_);
    if (kind_ != Kind::extents) return;
    message += '[';
    for (std::size_t i = 0; i < size_; ++i) message += (i > 0 ? ", " : "") + std::to_string(extents_[i]);
    message += ']';
  }

 private:
  enum class Kind { text, integer, count, number, extents };
  Kind kind_;
  union {
    const char* text_;
    std::int64_t integer_;
    std::uint64_t count_;
    double number_;
    const std::size_t* extents_;
  };
  std::size_t size_ = 0;
};

/// Message of an exception: a text, or parts, as in `ShapeError({"b is ", b.shape(), ", expected ", 3})`.
class ErrorMessage {
 public:
  ErrorMessage(std::string text) : text_(std::move(text)) {}
  ErrorMessage(const char* text) : text_(text) {}
  [[gnu::cold]] ErrorMessage(std::initializer_list<MessagePart> parts) {
    for (const MessagePart& part : parts) part.append_to(text_);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// The root of every exception that Tapestry throws.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const ErrorMessage& message) : std::runtime_error(message.text()), kind_(kind) {}
  /// The kind of this error.
  [[nodiscard]] ErrorKind kind() const noexcept { return kind_; }

 private:
  ErrorKind kind_;
};

/// An argument has extents that the operation cannot accept.
class ShapeError : public Error {
 public:
  explicit ShapeError(const ErrorMessage& message) : Error(ErrorKind::mismatch, message) {}
};

/// An argument lies outside what the operation is defined for.
class DomainError : public Error {
 public:
  explicit DomainError(const ErrorMessage& message) : Error(ErrorKind::usage, message) {}
};

/// A value that should be finite is not.
class NumericError : public Error {
 public:
  explicit NumericError(const ErrorMessage& message) : Error(ErrorKind::numeric, message) {}
};

/// Something is wrong with a file. The message reads
/// `<path>:<position>: <what>; expected <expected>, found <found>`, each part left out when empty.
class FileError : public Error {
 public:
  /// The parts of the message, for callers that show them in their own way.
  struct Details {
    std::string path;        ///< as the user gave it
    std::string position{};  ///< "12" for a line, "12:5" with a column, "@20" for a byte
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

/// An error of a file that is unreadable, or not in the format that it claims.
[[nodiscard]] inline FileError malformed_file(FileError::Details details) {
  return {ErrorKind::malformed, std::move(details)};
}

/// An error of a file that is well-formed, but does not fit another.
[[nodiscard]] inline FileError file_mismatch(FileError::Details details) {
  return {ErrorKind::mismatch, std::move(details)};
}

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
    throw ShapeError({operation, ": ", argument, " is ", array.shape(), ", expected ", expected});
  }
}
}  // namespace tapestry
