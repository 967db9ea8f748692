#pragma once
#include <protozero/exception.hpp>
#include <protozero/pbf_reader.hpp>
#include <protozero/types.hpp>
#include <protozero/varint.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/detail/number_formats.hpp>
#include <type_traits>

namespace tapestry::io {
/// The content of a protobuf file, and the file's name for messages.
struct ProtobufFile {
  std::string path;
  std::string_view bytes;
};

/// One message of a protobuf file, read field by field. protozero's reader relies on its caller to read each
/// field by its wire type. This class refuses fields of another type, and fields that extend beyond their
/// message, and names the byte of the file. The file must outlive it.
/// Source: the encoding's description, https://protobuf.dev/programming-guides/encoding.
class ProtobufMessage {
 public:
  /// \param place name of the message in error messages: "node 3"
  ProtobufMessage(const ProtobufFile& file, std::string place)
      : ProtobufMessage(file, std::move(place), file.bytes) {}

  /// Moves to the next field, and skips one that was not read; false after the last.
  /// \throws FileError (malformed) if the bytes there are no field, or the field extends beyond the message
  [[nodiscard]] bool next() {
    if (std::exchange(is_unread_, false)) decoded([&] { reader_.skip(); });
    begin_ = offset_of(reader_.data().data());
    is_unread_ = decoded([&] { return reader_.next(); });
    if (is_unread_) require_whole_field();
    return is_unread_;
  }
  [[nodiscard]] std::uint32_t tag() const { return reader_.tag(); }

  /// Whether the field is bytes with a length: a message, a text or a packed list.
  [[nodiscard]] bool holds_bytes() const {
    return reader_.has_wire_type(protozero::pbf_wire_type::length_delimited);
  }
  /// The field as a varint of up to 64 bits, in two's complement.
  [[nodiscard]] std::int64_t integer(std::string_view field) {
    require(protozero::pbf_wire_type::varint, field);
    return decoded([&] { return reader_.get_int64(); });
  }
  [[nodiscard]] float number(std::string_view field) {
    require(protozero::pbf_wire_type::fixed32, field);
    return reader_.get_float();
  }
  [[nodiscard]] std::string_view bytes(std::string_view field) {
    require(protozero::pbf_wire_type::length_delimited, field);
    const protozero::data_view view = reader_.get_view();
    return {view.data(), view.size()};
  }
  [[nodiscard]] ProtobufMessage message(std::string_view field, std::string place) {
    return {*file_, std::move(place), bytes(field)};
  }

  /// Calls visit(std::int64_t) for each varint of a repeated field, packed or not.
  template <class Visit>
  void each_integer(std::string_view field, Visit visit) {
    if (reader_.has_wire_type(protozero::pbf_wire_type::varint)) return visit(integer(field));
    const std::string_view packed = bytes(field);
    const char* at = packed.data();
    const char* const end = at + packed.size();
    while (at != end)
      visit(decoded([&] { return static_cast<std::int64_t>(protozero::decode_varint(&at, end)); }));
  }
  /// Calls visit(Number) for each float or double of a repeated field, packed or not.
  template <class Number, class Visit>
  void each_number(std::string_view field, Visit visit) {
    using Word = std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>;
    const auto number_at = [](const char* at) {
      return std::bit_cast<Number>(little_endian_word<Word>(reinterpret_cast<const std::byte*>(at)));
    };
    if (reader_.has_wire_type(sizeof(Word) == 4 ? protozero::pbf_wire_type::fixed32
                                                : protozero::pbf_wire_type::fixed64)) {
      return visit(number_at(reader_.data().data()));
    }
    const std::string_view packed = bytes(field);
    if (packed.size() % sizeof(Word) != 0)
      fail("field " + std::string(field) + " is cut",
           "a multiple of " + std::to_string(sizeof(Word)) + " bytes",
           std::to_string(packed.size()) + " bytes");
    for (std::size_t i = 0; i < packed.size(); i += sizeof(Word)) visit(number_at(packed.data() + i));
  }

  [[nodiscard]] const std::string& place() const { return place_; }
  void set_place(std::string place) { place_ = std::move(place); }
  [[nodiscard]] const ProtobufFile& file() const { return *file_; }
  /// Byte of the file where the message begins.
  [[nodiscard]] std::uint64_t position() const { return message_begin_; }

  /// Throws FileError for the field that was read last.
  [[noreturn]] void fail(const std::string& what, const std::string& expected = "",
                         const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const {
    throw FileError(kind, {file_->path, "@" + std::to_string(begin_), place_ + ": " + what, expected, found});
  }
  /// Throws FileError for the message as a whole.
  [[noreturn]] void fail_whole(const std::string& what, const std::string& expected = "",
                               const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const {
    throw FileError(
        kind, {file_->path, "@" + std::to_string(message_begin_), place_ + ": " + what, expected, found});
  }

 private:
  ProtobufMessage(const ProtobufFile& file, std::string place, std::string_view bytes)
      : file_(&file),
        reader_(bytes.data(), bytes.size()),
        place_(std::move(place)),
        message_begin_(offset_of(bytes.data())),
        begin_(message_begin_) {}

  [[nodiscard]] std::uint64_t offset_of(const char* at) const {
    return static_cast<std::uint64_t>(at - file_->bytes.data());
  }

  [[nodiscard]] static std::string wire_name(protozero::pbf_wire_type type) {
    if (type == protozero::pbf_wire_type::varint) return "a varint";
    if (type == protozero::pbf_wire_type::fixed32) return "four bytes";
    return type == protozero::pbf_wire_type::fixed64 ? "eight bytes" : "bytes with their length";
  }

  void require(protozero::pbf_wire_type type, std::string_view field) {
    is_unread_ = false;
    if (!reader_.has_wire_type(type))
      fail("field " + std::string(field) + " has another wire type", wire_name(type),
           wire_name(reader_.wire_type()));
  }

  /// Result of the action; protozero's exceptions become FileErrors.
  template <class Action>
  std::invoke_result_t<Action> decoded(Action action) const {
    try {
      return action();
    } catch (const protozero::end_of_buffer_exception&) {
      fail("ends within a field");
    } catch (const protozero::varint_too_long_exception&) {
      fail("a varint is longer than 64 bits");
    } catch (const protozero::exception&) {
      fail("no protobuf field begins here");
    }
  }

  /// Compares lengths as the 64-bit numbers that they may be; protozero cuts them to 32 bits.
  void require_whole_field() const {
    const char* at = reader_.data().data();
    const char* const end = at + reader_.data().size();
    std::uint64_t size = 0;
    if (reader_.has_wire_type(protozero::pbf_wire_type::fixed32)) size = 4;
    if (reader_.has_wire_type(protozero::pbf_wire_type::fixed64)) size = 8;
    if (reader_.has_wire_type(protozero::pbf_wire_type::length_delimited))
      size = decoded([&] { return protozero::decode_varint(&at, end); });
    const auto left = static_cast<std::uint64_t>(end - at);
    if (size <= left) return;
    const bool is_cut = end == file_->bytes.data() + file_->bytes.size();
    fail(
        (is_cut ? "the file ends within field " : "what holds it ends within field ") + std::to_string(tag()),
        std::to_string(size) + " bytes there", std::to_string(left));
  }

  const ProtobufFile* file_;
  protozero::pbf_reader reader_;
  std::string place_;
  std::uint64_t message_begin_;
  std::uint64_t begin_;     ///< begin of the current field
  bool is_unread_ = false;  ///< whether the current field was not read
};

/// Limits on the content of an ONNX model.
struct OnnxLimits {
  std::uint64_t file_bytes = std::uint64_t(1) << 31U;      ///< protobuf's own limit
  std::uint64_t external_bytes = std::uint64_t(1) << 32U;  ///< bytes of all tensors in files beside it
  std::size_t records = std::size_t(1) << 22U;  ///< nodes, their values' names, attributes, tensors
};

namespace detail {
template <class Visit>
void each_field(ProtobufMessage message, std::uint32_t tag, Visit visit) {
  while (message.next())
    if (message.tag() == tag) visit(message);
}

/// The text in the last field with this tag; empty without one.
[[nodiscard]] inline std::string text_within(const ProtobufMessage& message, std::uint32_t tag,
                                             std::string_view field) {
  std::string_view text;
  each_field(message, tag, [&](ProtobufMessage& at) { text = at.bytes(field); });
  return std::string(text);
}
}  // namespace detail

/// Counts records that take more memory than their bytes in the file, up to a limit.
class OnnxRecords {
 public:
  explicit OnnxRecords(std::size_t most) : most_(most) {}

  /// Counts one more. \throws FileError (limit)
  void count(const ProtobufMessage& message) {
    if (count_ == most_)
      message.fail("too many nodes, names, attributes and tensors", "at most " + std::to_string(most_),
                   "more", ErrorKind::limit);
    ++count_;
  }

  /// One more graph within a graph, until this is destroyed.
  class Deeper {
   public:
    /// \throws FileError (limit) for more than 16
    Deeper(OnnxRecords& records, const ProtobufMessage& message) : depth_(records.depth_) {
      constexpr int most = 16;
      if (depth_ == most)
        message.fail_whole("graphs within graphs", "at most " + std::to_string(most), "more",
                           ErrorKind::limit);
      ++depth_;
    }
    ~Deeper() { --depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;

   private:
    int& depth_;
  };

 private:
  std::size_t most_;
  std::size_t count_ = 0;
  int depth_ = 0;
};
}  // namespace tapestry::io
