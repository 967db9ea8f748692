#pragma once
#include <map>
#include <tapestry/core/array.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/detail/npy_header.hpp>
#include <tapestry/io/detail/zip_archive.hpp>
#include <tapestry/io/file_source.hpp>
#include <type_traits>

namespace tapestry::io {
/// An array of an .npy file, its elements already in this machine's byte order and row-major.
struct NpyArray {
  std::string origin;              ///< "frame.npz:img.npy", for messages
  std::vector<std::size_t> shape;  ///< empty for a single number
  DType type = DType::u1;
  std::vector<std::uint8_t> bytes;

  [[nodiscard]] std::size_t size() const { return bytes.size() / item_size(type); }

  /// The elements as T, in row-major order. Numbers of any type are rounded to a floating-point T. Integers
  /// and booleans become integers if every value fits; floating-point numbers never do.
  /// \throws FileError (mismatch) naming both types or the first value that does not fit
  template <class Element>
  [[nodiscard]] std::vector<Element> as() const;

  /// The elements as an array; throws FileError (mismatch) for another number of axes, and as as() does.
  template <class Element, std::size_t Rank>
  [[nodiscard]] Array<Element, Rank> array() const {
    if (shape.size() != Rank)
      throw file_mismatch({.path = origin,
                           .what = "array has another number of axes",
                           .expected = std::to_string(Rank),
                           .found = shape_text(shape)});
    Extents<Rank> extents{};
    std::copy(shape.begin(), shape.end(), extents.begin());
    Array<Element, Rank> result(extents);
    const auto values = as<Element>();
    std::copy(values.begin(), values.end(), result.data());
    return result;
  }
};

namespace detail {
template <class Element>
constexpr DType type_of() {
  if constexpr (std::same_as<Element, bool>) return DType::b1;
  if constexpr (std::floating_point<Element>) return sizeof(Element) == 4 ? DType::f4 : DType::f8;
  constexpr std::array unsigned_types{DType::u1, DType::u2, DType::u4, DType::u8};
  constexpr std::array signed_types{DType::i1, DType::i2, DType::i4, DType::i8};
  constexpr auto width = static_cast<std::size_t>(std::countr_zero(sizeof(Element)));
  return std::is_signed_v<Element> ? signed_types[width] : unsigned_types[width];
}

/// Calls visit with a value of the C++ type for `type`.
template <class Visit>
void visit_type(DType type, Visit visit) {
  const auto visit_if = [&]<class... Elements>(Elements... zeros) {
    ((type == type_of<Elements>() ? visit(zeros) : void()), ...);
  };
  visit_if(bool{}, std::uint8_t{}, std::uint16_t{}, std::uint32_t{}, std::uint64_t{}, std::int8_t{},
           std::int16_t{}, std::int32_t{}, std::int64_t{}, float{}, double{});
}

template <class From>
From element(const std::uint8_t* bytes) {
  if constexpr (std::same_as<From, bool>) return *bytes != 0;
  From value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

template <class Element, class From>
Element element_as(From value, const NpyArray& array) {
  if constexpr (std::integral<Element> && std::integral<From> && !std::same_as<Element, bool> &&
                !std::same_as<From, bool>) {
    if (!std::in_range<Element>(value))
      throw file_mismatch({.path = array.origin,
                           .what = "a value does not fit",
                           .expected = std::string(type_name(type_of<Element>())),
                           .found = std::to_string(value)});
  }
  return static_cast<Element>(value);
}

/// Column-major elements in row-major order.
std::vector<std::uint8_t> row_major(const std::vector<std::uint8_t>& column_major,
                                    const std::vector<std::size_t>& shape, std::size_t item);
}  // namespace detail

template <class Element>
std::vector<Element> NpyArray::as() const {
  constexpr bool to_integer = std::integral<Element>;
  if (to_integer && (type == DType::f4 || type == DType::f8))
    throw file_mismatch({.path = origin,
                         .what = "array has another element type",
                         .expected = std::string(type_name(detail::type_of<Element>())),
                         .found = std::string(type_name(type))});
  std::vector<Element> values(size());
  detail::visit_type(type, [&]<class From>(From) {
    if constexpr (!to_integer || std::integral<From>) {
      const std::uint8_t* from = bytes.data();
      for (std::size_t i = 0; i < values.size(); ++i, from += sizeof(From))
        values[i] = detail::element_as<Element>(detail::element<From>(from), *this);
    }
  });
  return values;
}

/// Reads an .npy image in memory. Header, shape and payload must agree to the byte before anything is
/// allocated. Takes memory of at most 3 times the file and 1 MiB.
///
/// \param origin  names the file and member in messages
/// \throws FileError: malformed (bad header, payload shorter or longer than the shape, pickled objects),
///         mismatch (element type that is not a plain number), limit (shape product beyond 2^60)
[[nodiscard]] NpyArray parse_npy(std::string_view file, const std::string& origin);

/// The bytes of an .npy file of version 1 holding elements in row-major order.
template <class Element>
[[nodiscard]] std::string npy_bytes(std::span<const std::size_t> shape, std::span<const Element> elements) {
  std::string file = npy_header_text(detail::type_of<Element>(), shape);
  file.append(reinterpret_cast<const char*>(elements.data()), elements.size_bytes());
  return file;
}

/// The arrays of an .npz file, all of them read and verified at once.
class NpzFile {
 public:
  /// Takes memory of at most 4 times the file, 2 times its arrays and 1 MiB.
  /// \throws FileError: malformed (damaged archive or array, pickled objects), limit (larger than `limits`)
  [[nodiscard]] static NpzFile read(const std::string& path, const ZipLimits& limits = {}) {
    return parse(read_text_file(path, limits.file_bytes), path, limits);
  }

  /// Like read(), for a file held in memory; `path` is for messages.
  [[nodiscard]] static NpzFile parse(std::string_view bytes, const std::string& path,
                                     const ZipLimits& limits = {});

  /// Without arrays, for readers of other files, which add() them by different names.
  explicit NpzFile(std::string path) : path_(std::move(path)) {}
  void add(const std::string& name, NpyArray array) {
    names_.push_back(name);
    arrays_.emplace(name, std::move(array));
  }

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Names of the arrays, without .npy.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] bool has(std::string_view name) const { return find(name) != nullptr; }

  /// \throws FileError (mismatch) listing the members if `name` is not among them
  [[nodiscard]] const NpyArray& get(std::string_view name) const;

  /// A member as an array; see NpyArray::array().
  template <class Element, std::size_t Rank>
  [[nodiscard]] Array<Element, Rank> array(std::string_view name) const {
    return get(name).template array<Element, Rank>();
  }

 private:
  [[nodiscard]] const NpyArray* find(std::string_view name) const;

  std::string path_;
  std::vector<std::string> names_;
  std::map<std::string, NpyArray, std::less<>> arrays_;  ///< names in an archive are unique
};

/// Collects arrays and writes them as one .npz file that NumPy can load. Takes memory of twice the file.
class NpzWriter {
 public:
  template <class Element, std::size_t Rank>
  void add(const std::string& name, const Array<Element, Rank>& array) {
    const auto shape = array.shape();
    add(name, std::span<const std::size_t>(shape.data(), Rank),
        std::span<const Element>(array.data(), array.size()));
  }

  /// A list becomes an array of one axis.
  template <class Element>
  void add(const std::string& name, const std::vector<Element>& list) {
    const std::size_t shape[] = {list.size()};
    add(name, std::span<const std::size_t>(shape), std::span<const Element>(list));
  }

  /// A number becomes an array without axes.
  template <class Element>
  requires std::integral<Element> || std::floating_point<Element>
  void add(const std::string& name, Element number) { add(name, {}, std::span<const Element>(&number, 1)); }

  /// Text becomes an array of its bytes.
  void add(const std::string& name, std::string_view text) {
    add(name, std::vector<std::uint8_t>(text.begin(), text.end()));
  }

  /// Elements in row-major order under a shape of any number of axes.
  template <class Element>
  void add(const std::string& name, std::span<const std::size_t> shape, std::span<const Element> elements) {
    members_.emplace_back(name + ".npy", npy_bytes<Element>(shape, elements));
  }

  /// The bytes of the file so far.
  [[nodiscard]] std::string bytes(bool compress = false) const;

  /// Writes the whole file to `path`, or leaves the old one as it was. Equal arrays give equal bytes.
  /// \throws FileError (write); Error (limit) beyond 4 GiB
  void write(const std::string& path, bool compress = false) const {
    write_file_atomically(path, bytes(compress));
  }

 private:
  std::vector<std::pair<std::string, std::string>> members_;
};
}  // namespace tapestry::io
