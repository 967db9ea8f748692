#pragma once
#include <cstddef>
#include <cstdint>
#include <typeinfo>
#include <vector>

namespace tapestry {
namespace detail {
/// The name of a type, as the compiler mangles it; empty where types have no names, with -fno-rtti.
template <class Type>
[[nodiscard]] const char* type_name() noexcept {
#if defined(__cpp_rtti)
  return typeid(Type).name();
#else
  return "";
#endif
}
}  // namespace detail

/// An operation on the tape that is more than a list of partial derivatives: its pullback.
/// record.hpp makes these from a callable; derive from it only for what that cannot express.
template <class T>
class TapeRecord {
 public:
  TapeRecord() = default;
  TapeRecord(const TapeRecord&) = delete;
  TapeRecord& operator=(const TapeRecord&) = delete;
  virtual ~TapeRecord() = default;

  /// Adds to the adjoints of the inputs. `adjoints[i]` belongs to scalar statement i, and `statement` is the
  /// place of the record.
  virtual void pull_back(T* adjoints, std::size_t statement) = 0;
  /// Appends the statements of all its active inputs, in any order. A sweep of several roots fills the
  /// adjoints of these alone, of `statement` and of its results before it calls pull_back().
  virtual void list_inputs(std::vector<std::uint32_t>& statements) const = 0;
  /// The operation's name in tape_statistics(): for an operation with a callable, the callable's type,
  /// mangled.
  [[nodiscard]] virtual const char* operation() const noexcept {
#if defined(__cpp_rtti)
    return typeid(*this).name();
#else
    return "";
#endif
  }
  /// Called before each reverse sweep: adjoints held by the record are zero again.
  virtual void forget_adjoint() noexcept {}
};

namespace detail {
/// An object that is kept on a tape for others, as long as the tape lives.
struct TapeAttachment {
  virtual ~TapeAttachment() = default;
  /// Sets the lane of the adjoints that records hold: 0 outside sweeps, and in sweeps of one root.
  virtual void select_lane(std::size_t lane) noexcept = 0;
};

/// A record on a tape, which owns it.
template <class T>
struct HeldRecord {
  TapeRecord<T>* record;
  std::size_t results;  ///< statements behind it that are its results
};
}  // namespace detail
}  // namespace tapestry
