#pragma once
#include <array>
#include <set>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::nn {
/// Place of axis i of an [N, C, H, W] tensor that is stored channels last, [N, H, W, C].
inline constexpr std::array<std::size_t, 4> stored_axis{0, 3, 1, 2};

/// An operand as the maker of an operation sees it.
struct Operand {
  Shape shape{};  ///< as stored
  ElementType type = ElementType::floating;
  const Constant* constant = nullptr;  ///< its values in storage order, if known beforehand
  bool is_there = false;
};

/// A node with the extents of its operands, to make an operation from. Attributes are read by name. An
/// attribute that is never read is an error, so that none is overlooked.
class OperatorContext {
 public:
  /// \param channels_last  tensors of four axes among the data operands are stored as [N, H, W, C]; so must
  ///                       be results of four axes
  OperatorContext(const Node& node, std::int64_t opset, std::vector<Operand> operands, bool channels_last)
      : inputs(std::move(operands)), node_(node), opset_(opset), channels_last_(channels_last) {}

  std::vector<Operand> inputs;  ///< in the node's order; empty places are dropped

  [[nodiscard]] const Node& node() const { return node_; }
  [[nodiscard]] std::int64_t opset() const { return opset_; }
  [[nodiscard]] bool channels_last() const { return channels_last_; }
  [[nodiscard]] std::size_t output_count() const { return node_.outputs.size(); }
  [[nodiscard]] bool has_input(std::size_t i) const { return i < inputs.size() && inputs[i].is_there; }

  /// The operand. \throws DomainError if the node leaves it out
  [[nodiscard]] const Operand& input(std::size_t i) const {
    if (!has_input(i)) throw DomainError({"input ", i, " is missing"});
    return inputs[i];
  }
  /// Integers of an operand that must be known beforehand, such as axes and extents. Integers out of range
  /// are clipped.
  /// \throws DomainError if it is missing, of another type or depends on the network's inputs; ShapeError for
  ///         more than no node needs
  [[nodiscard]] std::vector<std::int64_t> integers(std::size_t i) const {
    constexpr std::size_t most = 1024;
    const Constant& values = constant(i);
    require_type(i, ElementType::integer);
    if (values.size() > most)
      throw ShapeError({"input ", i, " has ", values.size(), " elements, expected at most ", most});
    std::vector<std::int64_t> all;
    for (std::size_t k = 0; k < values.size(); ++k) all.push_back(to_integer(values.at(k)));
    return all;
  }
  /// \throws DomainError if the operand is missing or of another type
  void require_type(std::size_t i, ElementType type) const {
    constexpr std::array<const char*, 3> names{"floating-point numbers", "integers", "truths"};
    const ElementType own = input(i).type;
    if (own != type)
      throw DomainError({"input ", i, " holds ", names[static_cast<std::size_t>(own)], ", expected ",
                         names[static_cast<std::size_t>(type)]});
  }
  [[nodiscard]] const Constant& constant(std::size_t i) const {
    const Operand& operand = input(i);
    if (operand.constant == nullptr)
      throw DomainError({"input ", i, " is computed; only a constant one is supported"});
    return *operand.constant;
  }

  [[nodiscard]] bool has_attribute(const std::string& name) const { return node_.attributes.contains(name); }
  [[nodiscard]] std::int64_t integer(const std::string& name, std::int64_t otherwise) {
    const auto* value = find<std::int64_t>(name, "an integer");
    return value == nullptr ? otherwise : *value;
  }
  /// An attribute that is 0 or 1. \throws DomainError for another number
  [[nodiscard]] bool flag(const std::string& name, std::int64_t otherwise) {
    const std::int64_t value = integer(name, otherwise);
    if (value != 0 && value != 1)
      throw DomainError({"attribute ", in_quotes(name), " is ", value, ", expected 0 or 1"});
    return value == 1;
  }
  [[nodiscard]] double number(const std::string& name, double otherwise) {
    const auto* value = find<double>(name, "a number");
    return value == nullptr ? otherwise : *value;
  }
  [[nodiscard]] std::string text(const std::string& name, const std::string& otherwise) {
    const auto* value = find<std::string>(name, "a text");
    return value == nullptr ? otherwise : *value;
  }
  [[nodiscard]] std::vector<std::int64_t> integers(const std::string& name,
                                                   std::vector<std::int64_t> otherwise = {}) {
    const auto* value = find<std::vector<std::int64_t>>(name, "a list of integers");
    return value == nullptr ? std::move(otherwise) : *value;
  }
  [[nodiscard]] std::vector<double> numbers(const std::string& name, std::vector<double> otherwise = {}) {
    const auto* value = find<std::vector<double>>(name, "a list of numbers");
    return value == nullptr ? std::move(otherwise) : *value;
  }
  [[nodiscard]] std::vector<std::string> texts(const std::string& name) {
    const auto* value = find<std::vector<std::string>>(name, "a list of texts");
    return value == nullptr ? std::vector<std::string>() : *value;
  }
  /// \throws DomainError if it is missing
  [[nodiscard]] const std::shared_ptr<const Subgraph>& graph(const std::string& name) {
    const auto* value = find<std::shared_ptr<const Subgraph>>(name, "a graph");
    if (value == nullptr) throw DomainError({"attribute ", in_quotes(name), " is missing"});
    return *value;
  }
  [[nodiscard]] const Constant* tensor(const std::string& name) { return find<Constant>(name, "a tensor"); }
  /// Marks an attribute without effect here as read.
  void ignore(const std::string& name) { asked_.insert(name); }

  /// The place, as stored, of an axis that may count from the end. \throws DomainError outside `rank`
  [[nodiscard]] std::size_t axis(std::int64_t logical, std::size_t rank) const {
    const auto extent = static_cast<std::int64_t>(rank);
    if (logical < -extent || logical >= std::max<std::int64_t>(extent, 1))
      throw DomainError({"axis ", logical, " of ", rank, " axes"});
    const auto place = static_cast<std::size_t>(logical < 0 ? logical + extent : logical);
    return channels_last_ && rank == 4 ? stored_axis[place] : place;
  }

  /// \throws DomainError naming attributes that were never read
  void require_all_asked() const {
    std::string unknown;
    for (const auto& [name, value] : node_.attributes)
      if (!asked_.contains(name)) unknown += (unknown.empty() ? "" : ", ") + in_quotes(name);
    if (!unknown.empty()) throw DomainError({"attribute ", unknown, " is not supported"});
  }

  /// \throws DomainError for NaN and infinities, which casts of fractions give
  [[nodiscard]] static std::int64_t to_integer(double value) {
    constexpr double largest = 4611686018427387904.0;  // 2^62, further than any extent
    if (!std::isfinite(value)) throw DomainError({"an integer is ", value});
    return static_cast<std::int64_t>(std::clamp(value, -largest, largest));
  }

 private:
  template <class Value>
  [[nodiscard]] const Value* find(const std::string& name, const char* kind) {
    asked_.insert(name);
    const auto found = node_.attributes.find(name);
    if (found == node_.attributes.end()) return nullptr;
    const auto* value = std::get_if<Value>(&found->second);
    if (value == nullptr) throw DomainError({"attribute ", in_quotes(name), " is not ", kind});
    return value;
  }

  const Node& node_;
  std::int64_t opset_;
  bool channels_last_;
  std::set<std::string> asked_;
};
}  // namespace tapestry::nn
