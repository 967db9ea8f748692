#pragma once
#include <functional>
#include <tapestry/core/error.hpp>
#include "../support/temporary_folder.hpp"

namespace tapestry::fuzz {
/// The folder of the files that readers are given, which vanishes with the process.
inline const test::TemporaryFolder& folder() {
  static const test::TemporaryFolder own;
  return own;
}

/// One reader under test.
struct Target {
  std::string name;
  /// Reads the bytes, or refuses them by an Error; anything else that is thrown is a fault.
  std::function<void(const std::string& bytes)> read;
  /// Small files that the reader takes, made on demand.
  std::function<std::vector<std::string>()> seeds;
  /// Puts checksums right, so that changed bytes behind them are read as well; may be empty.
  std::function<std::string(std::string)> repair{};
};

/// Every target of the program.
inline std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}

/// An object in a target's source file that registers the target with the program.
struct Registered {
  explicit Registered(Target target) { targets().push_back(std::move(target)); }
};

/// Its exceptions report faults.
/// \returns whether the bytes were taken, not refused
inline bool is_taken(const Target& target, const std::string& bytes) {
  try {
    target.read(bytes);
    return true;
  } catch (const Error& refusal) {
    if (std::string_view(refusal.what()).empty()) throw std::logic_error("a refusal without a word");
    return false;
  }
}

/// Reads the bytes unchanged, and with corrected checksums.
inline void read_both(const Target& target, const std::string& bytes) {
  (void)is_taken(target, bytes);
  if (target.repair) (void)is_taken(target, target.repair(bytes));
}
}  // namespace tapestry::fuzz
