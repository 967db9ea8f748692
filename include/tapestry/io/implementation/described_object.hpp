#pragma once
#include <algorithm>
#include <array>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/json.hpp>

namespace tapestry::io::detail {
/// One object of a description, whose members are read by name and type.
class DescribedObject {
 public:
  /// \param name       its key, for messages; empty for the outermost
  /// \param positions  places where members begin; members of an inner object have the place of that object
  DescribedObject(const nlohmann::json& value, const std::string& path, std::string name,
                  std::map<std::string, std::string> positions)
      : value_(value), path_(path), name_(std::move(name)), positions_(std::move(positions)) {}

  [[noreturn]] void fail(const std::string& key, const std::string& what, const std::string& expected,
                         const std::string& found) const {
    const auto at = positions_.find(name_.empty() ? key : name_);
    throw malformed_file({path_, at == positions_.end() ? "" : at->second, what, expected, found});
  }

  /// Refuses other members.
  void require_keys(std::initializer_list<std::string_view> keys) const {
    for (const auto& member : value_.items())
      if (std::ranges::find(keys, member.key()) == keys.end())
        fail(member.key(), "unknown key" + (name_.empty() ? "" : " of " + in_quotes(name_)), listed(keys),
             in_quotes(member.key()));
  }

  [[nodiscard]] bool has(const char* key) const { return value_.contains(key); }

  /// The member with that name, which must exist.
  [[nodiscard]] const nlohmann::json& member(const char* key) const { return value_[key]; }

  /// A number from low to high; `range` states the range in words.
  [[nodiscard]] double number(const char* key, const nlohmann::json& value, double low, double high,
                              const char* range) const {
    const double found = value.is_number() ? value.get<double>() : low - 1;
    if (!(found >= low && found <= high)) refuse(key, value, range);
    return found;
  }

  [[nodiscard]] std::string word(const char* key, const std::string& expected) const {
    if (!member(key).is_string()) refuse(key, member(key), expected);
    return member(key).get<std::string>();
  }

  template <class ByName>
  [[nodiscard]] auto named(const char* key, const std::string& expected, ByName by_name) const {
    try {
      return by_name(word(key, expected));
    } catch (const DomainError&) {
      refuse(key, member(key), expected);
    }
  }

  [[noreturn]] void refuse(const char* key, const nlohmann::json& value, const std::string& expected) const {
    fail(key, in_quotes(key) + " makes no sense", expected,
         value.is_string() ? in_quotes(value.get_ref<const std::string&>()) : in_quotes(value.dump()));
  }

 private:
  const nlohmann::json& value_;
  const std::string& path_;
  std::string name_;
  std::map<std::string, std::string> positions_;
};

template <std::size_t Count>
void read_numbers(const DescribedObject& object, const char* key, double low, double high, const char* range,
                  std::array<double, Count>& values) {
  if (!object.has(key)) return;
  const auto& list = object.member(key);
  if (!list.is_array() || list.size() != Count) object.refuse(key, list, range);
  for (std::size_t i = 0; i < Count; ++i) values[i] = object.number(key, list[i], low, high, range);
}

/// The choice that a key names; the first one if the key is missing.
template <class Choice, std::size_t Count>
[[nodiscard]] Choice chosen(const DescribedObject& object, const char* key,
                            const std::array<std::pair<std::string_view, Choice>, Count>& choices) {
  if (!object.has(key)) return choices.front().second;
  std::string expected;
  for (std::size_t i = 0; i < Count; ++i)
    expected += (i == 0 ? "" : i + 1 < Count ? ", " : " or ") + std::string(choices[i].first);
  return object.named(key, expected, [&](const std::string& name) {
    for (const auto& [known, choice] : choices)
      if (known == name) return choice;
    throw DomainError("no such choice");
  });
}
}  // namespace tapestry::io::detail
