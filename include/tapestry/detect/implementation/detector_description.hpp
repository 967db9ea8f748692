#pragma once
#include <tapestry/detect/detector_description.hpp>

namespace tapestry::detect {
HeadKind head_kind_by_name(std::string_view name) {
  for (const HeadKind kind : head_kinds)
    if (name_of(kind) == name) return kind;
  throw DomainError({"no kind of head is called ", in_quotes(name), "; expected ", head_kind_names});
}

DetectorDescription known_description(std::string_view name) {
  if (name == "yolox")
    return {{ColourOrder::bgr, 1}, image::fit_by_name("letterbox_top_left"), HeadKind::yolox, {8, 16, 32}};
  if (name == "nanodet")
    return {{ColourOrder::bgr, 1, {103.53, 116.28, 123.675}, {57.375, 57.12, 58.395}},
            image::fit_by_name("stretch"),
            HeadKind::nanodet,
            {8, 16, 32}};
  if (name == "picodet")
    return {imagenet_encoding, image::fit_by_name("stretch"), HeadKind::nanodet, {8, 16, 32, 64}};
  if (name == "yolov5")
    return {{},
            {image::FitKind::letterbox, 114.0 / 255},
            HeadKind::yolov5,
            {8, 16, 32},
            {{{10, 13}, {16, 30}, {33, 23}},
             {{30, 61}, {62, 45}, {59, 119}},
             {{116, 90}, {156, 198}, {373, 326}}}};
  throw DomainError(
      {"no known detector is called ", in_quotes(name), "; expected yolox, nanodet, picodet or yolov5"});
}

std::vector<Head> heads_of(const DetectorDescription& description, std::size_t classes,
                           std::size_t input_height, std::size_t input_width) {
  Head head;
  head.classes = classes;
  head.decode = decode_family_of(description.head);
  const std::size_t anchored = has_anchors(head.decode) ? description.strides.size() : 0;
  const auto is_none = [](const auto& anchors) { return anchors.empty(); };
  if (description.anchors.size() != anchored || std::ranges::any_of(description.anchors, is_none))
    throw DomainError({"heads_of: a description of ", name_of(description.head), " heads has anchors for ",
                       description.anchors.size(), " of them, expected some for ", anchored});
  if (description.head == HeadKind::nanodet) head.order = ChannelOrder::classes_first;
  if (description.head == HeadKind::yolov8) head.bins = 16;
  std::vector<Head> heads;
  for (const std::size_t stride : description.strides) {
    if (stride == 0) throw DomainError("heads_of: a stride is 0, expected at least 1 pixel");
    head.stride = stride;
    head.grid_height = (input_height + stride - 1) / stride;
    head.grid_width = (input_width + stride - 1) / stride;
    if (anchored > 0) head.anchors = description.anchors[heads.size()];
    heads.push_back(head);
  }
  return heads;
}

std::size_t class_count_of(const DetectorDescription& description, std::size_t channels) {
  DetectorDescription one = description;
  one.strides = {1};
  if (one.anchors.size() > 1) one.anchors.resize(1);
  const Head head = heads_of(one, 0, 1, 1).front();
  const std::size_t others = head.channel_count(), candidates = head.anchor_count();
  if (channels <= others || channels % candidates != 0)
    throw ShapeError({"class_count_of: outputs of ", channels, " channels, expected more than ", others,
                      (candidates > 1 ? " and a multiple of " + std::to_string(candidates) : ""), " for ",
                      name_of(description.head), " heads"});
  return (channels - others) / candidates;
}
}  // namespace tapestry::detect

namespace tapestry::detect::detail {
void DecodedOutputNodes::give_picture_axis() {
  const bool is_one = outputs_.boxes == outputs_.scores;
  if (!outputs_.labels.empty()) {
    const std::string labels = node("Cast", {outputs_.labels}, {{"to", std::int64_t(1)}});
    outputs_.boxes = outputs_.scores =
        node("Concat", {of_one_picture(outputs_.boxes, 2), column(outputs_.scores), column(labels)},
             {{"axis", std::int64_t(2)}});
    return;
  }
  outputs_.scores = of_one_picture(outputs_.scores, 2);
  if (is_one)
    outputs_.boxes = outputs_.scores;
  else if (outputs_.has_box_for_each_class)
    outputs_.boxes = surest(of_one_picture(outputs_.boxes, 3), outputs_.scores);
  else
    outputs_.boxes = of_one_picture(outputs_.boxes, 2);
}

std::string DecodedOutputNodes::of_one_picture(const std::string& from, std::int64_t axes) {
  const std::string extents = rows(node("Shape", {from}, {}), -axes, to_the_end, 0);
  const std::string shape = node("Concat", {integers({1}), extents}, {{"axis", std::int64_t(0)}});
  return node("Reshape", {from, shape}, {{"allowzero", std::int64_t(1)}});
}

std::string DecodedOutputNodes::surest(const std::string& boxes, const std::string& scores) {
  const std::string of_classes = classes_only(scores, 2);
  const std::string are_surest = node("Equal", {of_classes, along(2, "ReduceMax", of_classes)}, {});
  const std::string ones = node("Cast", {are_surest}, {{"to", std::int64_t(1)}});
  const std::string shares = node("Div", {ones, along(2, "ReduceSum", ones)}, {});
  const std::string parts = node("Mul", {classes_only(boxes, 2), along(3, "Unsqueeze", shares)}, {});
  return along(2, "Squeeze", along(2, "ReduceSum", parts));
}

AddedOutputs DecodedOutputNodes::add(std::size_t height, std::size_t width) {
  const bool is_one = outputs_.boxes == outputs_.scores;
  const bool is_chosen = outputs_.classes > 0;
  const std::string all = channels_first(outputs_.boxes);
  const std::string boxes = node("MatMul", {to_pixels(height, width), is_one ? rows(all, 0, 4) : all}, {});
  std::string classes = is_chosen ? probabilities_of_choice(all)
                        : is_one  ? scores(rows(all, outputs_.has_objectness ? 5 : 4, to_the_end))
                                  : scores(channels_first(outputs_.scores));
  if (is_chosen)
    classes = logits(classes);
  else if (outputs_.has_objectness)
    classes = logits(node("Mul", {probabilities(classes), probabilities(rows(all, 4, 5))}, {}));
  else if (outputs_.score_form != ScoreForm::logits)
    classes = logits(classes);
  const std::string joined = node("Concat", {boxes, classes}, {{"axis", std::int64_t(1)}});
  return {along(2, "Unsqueeze", joined), outputs_.scores};
}

std::string DecodedOutputNodes::along(std::int64_t axis, const std::string& operation,
                                      const std::string& from) {
  if (network_.opset < (operation == "ReduceMax" ? 18 : 13))
    return node(operation, {from}, {{"axes", std::vector<std::int64_t>{axis}}});
  return node(operation, {from, integers({static_cast<double>(axis)})}, {});
}

std::string DecodedOutputNodes::node(const std::string& operation, std::vector<std::string> inputs,
                                     std::map<std::string, nn::Attribute> attributes) {
  std::string output = "decoded outputs " + std::to_string(network_.nodes.size());
  network_.nodes.push_back({output, operation, std::move(inputs), {output}, std::move(attributes)});
  return output;
}

std::string DecodedOutputNodes::constant(nn::Constant values) {
  std::string name;
  for (std::size_t i = network_.constants.size(); name.empty() || network_.constants.contains(name); ++i)
    name = "decoded outputs, constant " + std::to_string(i);
  network_.constants[name] = std::move(values);
  return name;
}

std::string DecodedOutputNodes::rows(const std::string& from, std::int64_t first, std::int64_t end,
                                     std::int64_t axis) {
  using List = std::vector<std::int64_t>;
  if (network_.opset < 10)
    return node("Slice", {from}, {{"starts", List{first}}, {"ends", List{end}}, {"axes", List{axis}}});
  const auto list = [&](std::int64_t value) { return integers({static_cast<double>(value)}); };
  return node("Slice", {from, list(first), list(end), list(axis)}, {});
}

std::string DecodedOutputNodes::classes_only(const std::string& from, std::int64_t axis) {
  if (outputs_.background == Background::none) return from;
  return outputs_.background == Background::first ? rows(from, 1, to_the_end, axis) : rows(from, 0, -1, axis);
}

std::string DecodedOutputNodes::scores(std::string from) {
  if (outputs_.score_form == ScoreForm::softmax)  // its axis is the last one in every opset
    from = transposed(node("Softmax", {transposed(from)}, {{"axis", std::int64_t(2)}}));
  return classes_only(from, 1);
}

std::string DecodedOutputNodes::probabilities_of_choice(const std::string& all) {
  std::vector<double> numbers(outputs_.classes);
  std::iota(numbers.begin(), numbers.end(), 0.0);
  const std::string each =
      constant({{1, outputs_.classes, 1}, nn::ElementType::floating, std::move(numbers)});
  const std::string is_it = node("Equal", {rows(all, 5, 6), each}, {});
  const std::string ones = node("Cast", {is_it}, {{"to", std::int64_t(1)}});
  return node("Mul", {probabilities(rows(all, 4, 5)), ones}, {});
}

std::string DecodedOutputNodes::logits(const std::string& from) {
  const std::string above = node("Max", {from, number(least_probability)}, {});
  const std::string inside = node("Min", {above, number(1 - least_probability)}, {});
  const std::string others = node("Sub", {number(1), inside}, {});
  return node("Sub", {node("Log", {inside}, {}), node("Log", {others}, {})}, {});
}

std::string DecodedOutputNodes::to_pixels(std::size_t height, std::size_t width) {
  const bool are_corners = outputs_.form != BoxForm::centre;
  const auto unit = [&](std::size_t extent, double other) {
    if (outputs_.relative) return static_cast<float>(extent);
    return other > 0 ? static_cast<float>(static_cast<double>(extent) / other) : 1.0F;
  };
  const float x = unit(width, outputs_.extent[0]), y = unit(height, outputs_.extent[1]);
  const std::size_t left = outputs_.form == BoxForm::corners_yx ? 1 : 0, top = 1 - left;
  std::vector<float> matrix(16, 0);
  const auto entry = [&](std::size_t row, std::size_t column) -> float& { return matrix[4 * row + column]; };
  for (const auto& [axis, near, scale] : {std::tuple(0U, left, x), std::tuple(1U, top, y)}) {
    entry(axis, near) = are_corners ? scale / 2 : scale;
    entry(axis, near + 2) = are_corners ? scale / 2 : 0;
    entry(axis + 2, near) = are_corners ? -scale : 0;
    entry(axis + 2, near + 2) = scale;
  }
  return constant({{4, 4}, nn::ElementType::floating, std::move(matrix)});
}
}  // namespace tapestry::detect::detail
