#pragma once
#include <sstream>
#include <tapestry/detect/implementation/detector/claim.hpp>
#include <tapestry/detect/implementation/head_trace.hpp>

namespace tapestry::detect {
namespace detail {
/// Whether every grid has one convolution of K filters and one of each of `parts`.
[[nodiscard]] inline bool are_apart(std::vector<std::size_t> filters, std::size_t grids,
                                    const std::vector<std::size_t>& parts) {
  for (const std::size_t part : parts)
    for (std::size_t grid = 0; grid < grids; ++grid) {
      const auto found = std::ranges::find(filters, part);
      if (found == filters.end()) return false;
      filters.erase(found);
    }
  return grids > 0 && filters.size() == grids &&
         std::ranges::count(filters, filters.front()) == std::ptrdiff_t(grids);
}

[[nodiscard]] inline std::string text_of(const std::vector<std::vector<std::array<double, 2>>>& anchors) {
  std::ostringstream text;
  for (const auto& grid : anchors)
    for (const auto& [width, height] : grid)
      text << (text.str().empty() ? "" : ", ") << width << " x " << height;
  return text.str();
}

/// Checks heads of raw outputs against the convolutions that make them.
inline void require_raw_layers(const nn::NetworkDescription& network, const DetectorDescription& kind) {
  const auto raw = raw_outputs(network);
  const std::vector<std::size_t> filters = filter_counts(network, raw);
  if (std::ranges::find(filters, 0U) != filters.end()) return;  // seen by their extents alone
  const std::size_t grids = kind.strides.size();
  const LogisticChannels logistic = logistic_channels(network, raw);
  const auto refuse = [&](const std::string& layers, bool by_filters = true) {
    const auto found = listed(filters, [](std::size_t count) { return std::to_string(count); });
    throw other_kind(network.path, kind, by_filters ? "filters of its last convolutions" : "what it computes",
                     layers,
                     !by_filters     ? "the logistic function of other channels"
                     : found.empty() ? "none"
                                     : found);
  };
  const std::string each = " for each of " + std::to_string(grids) + " grids";
  if (kind.head == HeadKind::yolox) {
    if (!are_apart(filters, grids, {4, 1})) refuse("4, 1 and K" + each);
  } else if (kind.head == HeadKind::yolov8) {
    if (!are_apart(filters, grids, {64})) refuse("64 and K" + each);
  } else if (kind.head == HeadKind::nanodet) {
    const bool shows_parts = logistic.of_some || network.outputs.size() == 2 * grids;
    const bool are_joined = are_apart(filters, grids, {}) && filters.front() > 32 && shows_parts;
    if (!are_apart(filters, grids, {32}) && !are_joined)
      refuse("32 and K, or 32 + K that are parted," + each);
  } else if (filters.empty()) {
    refuse("one" + each);
  } else if (logistic.of_first && !logistic.of_all) {
    refuse("the logistic function of all channels", false);
  } else if (!kind.anchors.empty()) {
    const std::size_t anchors = kind.anchors.front().size();
    const bool are_alike =
        std::ranges::all_of(kind.anchors, [&](const auto& of) { return of.size() == anchors; });
    const auto has_room = [&](std::size_t count) { return count > 5 * anchors && count % anchors == 0; };
    if (filters.size() != grids || (are_alike && !std::ranges::all_of(filters, has_room)))
      refuse(std::to_string(anchors) + " times 5 + K" + each);
    const auto shown = shown_anchors(network);
    if (shown.size() == grids && !are_same_anchors(shown, kind.anchors))
      throw other_kind(network.path, kind, "anchors that it multiplies extents by", text_of(kind.anchors),
                       text_of(shown));
  }
}

/// Checks the scores of a decoded output against the node that makes them.
inline void require_decoded_scores(const nn::NetworkDescription& network, const DetectorDescription& kind) {
  if (kind.decoded.score_form == ScoreForm::probabilities) return;
  if (kind.decoded.scores == kind.decoded.boxes) return;  // boxes come first there
  const nn::Node* const maker = Makers(network).behind(kind.decoded.scores, [](const nn::Node& node) {
    return node.operation != "Sigmoid" && only_presents(node.operation);
  });
  if (maker == nullptr || (maker->operation != "Sigmoid" && maker->operation != "Softmax")) return;
  throw other_kind(network.path, kind, "scores " + in_quotes(kind.decoded.scores), "logits",
                   "probabilities of " + nn::label_of(*maker));
}
}  // namespace detail

void require_layers_of(const nn::NetworkDescription& network, const DetectorDescription& kind) {
  if (decode_family_of(kind.head) == DecodeFamily::decoded)
    detail::require_decoded_scores(network, kind);
  else
    detail::require_raw_layers(network, kind);
}

std::vector<std::string> raw_outputs(const nn::NetworkDescription& description) {
  const detail::Makers makers(description);
  std::vector<std::string> found;
  std::set<std::string_view> seen;
  std::vector<std::string_view> waiting(description.outputs.rbegin(), description.outputs.rend());
  while (!waiting.empty()) {
    const std::string_view value = waiting.back();
    waiting.pop_back();
    const nn::Node* const node = makers.of(value);
    if (node == nullptr || !seen.insert(value).second) continue;
    if (node->operation == "Conv") found.emplace_back(value);
    if (!detail::only_presents(node->operation)) continue;
    const std::size_t tensors =
        node->operation == "Concat" ? node->inputs.size() : std::min<std::size_t>(1, node->inputs.size());
    for (std::size_t i = tensors; i-- > 0;) waiting.emplace_back(node->inputs[i]);
  }
  return found;
}

std::string common_layer(const nn::NetworkDescription& description, const std::vector<std::string>& outputs) {
  std::map<std::string, std::size_t> readers;  // number of raw outputs that depend on each value
  for (const std::string& output : outputs) {
    std::set<std::string_view> needed{output};
    for (auto node = description.nodes.rbegin(); node != description.nodes.rend(); ++node) {
      const auto is_needed = [&](const std::string& name) { return needed.contains(name); };
      if (std::ranges::none_of(node->outputs, is_needed)) continue;
      for (const std::string& name : node->outputs)
        if (is_needed(name) && name != output) ++readers[name];
      needed.insert(node->inputs.begin(), node->inputs.end());
    }
  }
  for (auto node = description.nodes.rbegin(); node != description.nodes.rend(); ++node)
    for (const std::string& name : node->outputs)
      if (const auto found = readers.find(name); found != readers.end() && found->second == outputs.size())
        return name;
  return {};
}

std::string common_layer(const nn::NetworkDescription& network, const DetectorDescription& kind) {
  std::vector<std::string> heads = raw_outputs(network);
  if (decode_family_of(kind.head) == DecodeFamily::decoded) {
    heads = {kind.decoded.boxes};
    if (kind.decoded.scores != kind.decoded.boxes) heads.push_back(kind.decoded.scores);
    heads = detail::head_trace(network, heads).convolutions;
  }
  return heads.size() == 1 ? heads.front() : common_layer(network, heads);
}

std::optional<DetectorDescription> recognised_detector(const nn::NetworkDescription& network) {
  const auto filters = detail::filter_counts(network, raw_outputs(network));
  const bool are_known = !filters.empty() && std::ranges::find(filters, 0U) == filters.end();
  for (const std::string_view name : {"yolox", "nanodet"}) try {
      const DetectorDescription known = known_description(name);
      detail::require_raw_layers(network, known);
      if (are_known) return known;
    } catch (const FileError&) {  // another detector
    }
  return std::nullopt;
}
}  // namespace tapestry::detect
