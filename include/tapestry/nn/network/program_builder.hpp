#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/simplify/editable_graph.hpp>
#include <tapestry/nn/network/program.hpp>

namespace tapestry::nn {
/// An operand of a node that is folded.
struct FoldOperand {
  const Constant* constant = nullptr;  ///< null for Shape and Size, which read the extents alone
  Shape shape{};
  bool is_there = false;
};

namespace detail {
[[nodiscard]] inline Constant integers(std::vector<double> values, Shape shape) {
  return {std::move(shape), ElementType::integer, std::move(values)};
}

/// Whether the operator takes its operands of four axes channels last.
template <std::floating_point T>
[[nodiscard]] bool is_channels_last(const Operator<T>& kind, const std::vector<FoldOperand>& operands);
}  // namespace detail

/// The results of a node with all operands known beforehand. Elements that are moved keep their values;
/// arithmetic, comparisons and casts are computed in double, and all else in T.
///
/// \param most  elements that they may have
/// \throws DomainError or ShapeError if the node is not supported or its results are too large
template <std::floating_point T>
[[nodiscard]] std::vector<Constant> fold_node(const Node& node, std::int64_t opset,
                                              const std::vector<FoldOperand>& operands, std::size_t most);

/// Turns a description into a program. Values known beforehand are computed now, every other node becomes an
/// operation, and tensors of four axes are stored in the order that their readers take.
template <std::floating_point T>
class ProgramBuilder {
 public:
  /// \param shapes  of the inputs, in the description's numbering of axes
  /// \param pictures_channels_last  inputs of four axes are handed over as [N, H, W, C]
  /// \param stores_constants  if false, the program cannot run, and only facts() may be used
  /// \param budget  what earlier stages of the same network have left
  ProgramBuilder(const NetworkDescription& description, const std::map<std::string, Shape>& shapes,
                 bool pictures_channels_last, bool stores_constants = true, PlanBudget budget = {});

  /// \throws FileError (mismatch) naming every node that is not supported, and why
  [[nodiscard]] Program<T> build();

  /// The part of build() that facts() need; nodes that are not supported are left out.
  /// \throws FileError (limit) naming the node that exceeds the budget
  void add_nodes();

  /// Returns the nodes left by add_nodes().
  [[nodiscard]] const PlanBudget& budget() const { return budget_; }

  /// Facts of every value that could be made, after build() or add_nodes(). Constants belong to the
  /// description or to this.
  [[nodiscard]] NetworkFacts facts() const;

  /// Replaces each node that build() took apart by its parts, with their constants. Facts point to these
  /// constants. \param description  the builder's own
  void expand(NetworkDescription& description) const;

  /// Nodes of the description, after add_nodes(), with those that were taken apart as their parts.
  struct DividedNodes {
    std::vector<Node> made{}, left{};             ///< nodes that could be made, and those that could not
    std::map<std::string, Constant> constants{};  ///< of parts
  };
  [[nodiscard]] DividedNodes divided() const;

  /// \throws FileError as build() does, if there are problems
  void require_no_problems() const {
    if (problem_count_ > 0) refuse();
  }

 private:
  static constexpr std::size_t readable_past_end = 32;  ///< values, of at least 128 bytes

  void require_room_for(const char* kind, const std::string& name, const Shape& shape) const;

  /// Facts of a named value: a constant, or where the program has it in either layout.
  struct Known {
    const Constant* constant = nullptr;
    Shape shape{};  ///< in the description's numbering
    ElementType type = ElementType::floating;
    std::size_t value[2] = {no_value, no_value};  ///< plain, channels last
    bool failed = false;
    const Node* moved_by = nullptr;  ///< of a constant that moves its first operand's elements
    std::size_t moved_result = 0;
  };

  [[nodiscard]] static const Shape& shape_of(const Known& known) {
    return known.constant != nullptr ? known.constant->shape : known.shape;
  }

  std::size_t add_value(const std::string& name, const Shape& logical, ElementType type, bool is_last);

  /// Adds a node, or queues the parts that it is taken apart into.
  void add_node(const Node& node);

  /// Counts the cost of a node in a loop's round.
  void take_repeated(const Node& node, const Operation<T>& operation);

  /// Name of a node in messages: of a part, behind the description's.
  [[nodiscard]] std::string label_of_part(const Node& node) const;

  /// Queues a node's parts, if it is taken apart. \returns whether it is
  bool take_apart(const Node& node, const Decomposable& kind);

  /// Names of all values, those between parts included.
  ValueNames& names();

  /// Records a problem. Only the first ones are kept of a network that cannot run.
  void add_problem(const std::string& problem);

  void fail(const Node& node) {
    for (const std::string& output : node.outputs) {
      known_[output].failed = true;
      if (is_repeated_ && !output.empty()) budget_.repeated.insert(output);
    }
  }

  void fold(const Node& node);

  static void require_result(std::size_t i, std::size_t count) {
    if (i >= count) throw DomainError({"result ", i, " is not supported"});
  }

  /// Whether the node takes its tensors channels last.
  [[nodiscard]] bool wants_channels_last(const Node& node, const Operator<T>& kind) const;

  void make(const Node& node, const Operator<T>& kind);

  void add_output(const std::string& name, std::size_t i, bool is_last, ProgramStep<T>& step);

  void note_weights(const ProgramStep<T>& step);

  /// The weights of a constant, under the name of the description's constant with its elements.
  [[nodiscard]] WeightBlock block_of(const ProgramValue& value) const;

  /// Moves the weights to the front of the constants, in the order of their first reading.
  void put_weights_first();

  /// An operand for the maker, with its values if they are known.
  [[nodiscard]] Operand operand_of(const std::string& name, bool is_last);

  const Constant* stored_constant(const std::string& name, const Constant& constant);

  /// Slot of a value in the layout wanted, converted or copied if the program has none yet.
  std::size_t value_of(const std::string& name, Known& known, bool is_last, std::size_t rank);

  [[noreturn]] void refuse() const;

  const NetworkDescription& description_;
  bool stores_constants_;
  Program<T> program_;
  std::map<std::string, Known> known_;
  std::map<std::string, std::unique_ptr<Constant>> stored_;
  std::vector<std::unique_ptr<Constant>> folded_;
  std::map<const Node*, Decomposition> taken_apart_;
  /// A node to add, and whether it belongs to a loop's round.
  struct Waiting {
    const Node* node;
    bool is_repeated;
  };
  std::vector<Waiting> waiting_;  ///< the next one last
  const Node* root_ = nullptr;    ///< the description's node that is being added
  bool is_repeated_ = false;      ///< whether the node being added belongs to a loop's round
  ValueNames names_;
  PlanBudget budget_;
  std::set<std::string> repeated_before_;         ///< budget_.repeated, as earlier stages have left it
  std::set<const Constant*> repeated_constants_;  ///< constants that nodes of loops' rounds read
  std::size_t problem_count_ = 0;
  std::string problems_;
  std::set<std::size_t> noted_;
};

extern template class ProgramBuilder<float>;
extern template class ProgramBuilder<double>;
}  // namespace tapestry::nn
