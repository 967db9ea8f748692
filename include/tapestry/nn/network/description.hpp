#pragma once
#include <map>
#include <memory>
#include <optional>
#include <tapestry/core/compiled.hpp>
#include <tapestry/nn/network/tensor.hpp>

namespace tapestry::nn {
struct Subgraph;

/// A constant that stands beside a node's inputs; of If and Loop, also the nodes that they run.
using Attribute =
    std::variant<std::int64_t, double, std::string, std::vector<std::int64_t>, std::vector<double>, Constant,
                 std::vector<std::string>, std::shared_ptr<const Subgraph>>;

/// One operator applied to named values. The vocabulary is ONNX's: names, attributes, inputs and outputs of
/// its operators in the version (opset) that the description states. Source: onnx.ai, Operators.md.
struct Node {
  std::string name{};  ///< for messages; may be empty
  std::string operation{};
  /// Names of values; empty where an optional input is left out. The operator's inputs come first, then the
  /// values that each of the node's subgraphs captures.
  std::vector<std::string> inputs{};
  std::vector<std::string> outputs{};
  std::map<std::string, Attribute> attributes{};
};

/// Nodes within a node, such as a branch of If, sorted so that each follows the nodes it reads from.
struct Subgraph {
  std::vector<std::string> inputs{};
  std::vector<std::string> outputs{};
  std::map<std::string, Constant> constants{};
  std::vector<Node> nodes{};
  std::vector<std::string> captured{};      ///< values of the graph around it that it reads
  std::vector<ElementType> output_types{};  ///< as the file states them; none if it does not state all
};

/// An input of a network with its extents. Open extents, those without a number, get their size when a
/// Network is made.
struct InputDescription {
  std::string name{};
  std::vector<std::optional<std::size_t>> shape{};
  ElementType type = ElementType::floating;
};

/// A network as read from a file: nodes sorted so that each follows the nodes it reads from, the values known
/// beforehand, and the names of inputs and outputs. Network runs it.
struct NetworkDescription {
  std::string path{};  ///< of the file, for messages
  std::int64_t opset = 0;
  std::vector<InputDescription> inputs{};  ///< without those that have a constant
  std::vector<std::string> outputs{};
  std::map<std::string, Constant> constants{};
  std::vector<Node> nodes{};
  std::map<std::string, std::string> metadata{};  ///< texts that the file's maker added, by their keys
  /// Extents that the file states for outputs and values in between, by their names; open ones have no
  /// number. A network computes its own, see untrue_shape().
  std::map<std::string, std::vector<std::optional<std::size_t>>> stated_shapes{};
};

/// Name of a node in messages: its operator, with its name or that of its first output in quotes; at most 80
/// bytes of each, printable().
[[nodiscard]] std::string label_of(const Node& node);

/// The node that makes a value; null if none does.
[[nodiscard]] const Node* maker_of(const NetworkDescription& network, const std::string& value);

/// The description with other outputs, and with only the nodes and constants that they need.
///
/// \param outputs  names of values that the description has
[[nodiscard]] NetworkDescription pruned(NetworkDescription description, std::vector<std::string> outputs);

/// A sentence about the first of stated_shapes, outputs first, that differs from the extents that the nodes
/// compute for the description's inputs. None if none differs, or if an input has an open extent: the stated
/// extents are then for an unknown one. Values that cannot be computed are left out.
[[nodiscard]] std::optional<std::string> untrue_shape(const NetworkDescription& description);
}  // namespace tapestry::nn
