#pragma once
#include <tapestry/nn/network/description.hpp>
#include "random_array.hpp"

namespace tapestry::test {
/// Writes down small exports, as PyTorch leaves them.
class Exporter {
 public:
  explicit Exporter(std::size_t size, std::int64_t opset = 11) {
    description_.path = "net.onnx";
    description_.opset = opset;
    description_.inputs = {{"images", {1, 3, size, size}}};
  }

  /// A convolution of 3 × 3 taps.
  std::string convolution(const std::string& from, std::size_t in, std::size_t out, std::int64_t stride) {
    const std::string name = "conv" + std::to_string(description_.nodes.size());
    std::vector<float> weights(out * in * 9), biases(out);
    for (float& weight : weights)
      weight = static_cast<float>(random_.normal() / std::sqrt(9.0 * static_cast<double>(in)));
    for (float& bias : biases) bias = static_cast<float>(random_.uniform(-0.5, 0.5));
    description_.constants[name + ".weight"] = {{out, in, 3, 3}, nn::ElementType::floating, weights};
    description_.constants[name + ".bias"] = {{out}, nn::ElementType::floating, biases};
    return add("Conv", {from, name + ".weight", name + ".bias"},
               {{"kernel_shape", std::vector<std::int64_t>{3, 3}},
                {"strides", std::vector<std::int64_t>{stride, stride}},
                {"pads", std::vector<std::int64_t>{1, 1, 1, 1}}});
  }

  /// \param second  name of a second output; empty for none
  std::string add(const std::string& operation, std::vector<std::string> inputs,
                  std::map<std::string, nn::Attribute> attributes = {}, const std::string& second = "") {
    const std::string output = "v" + std::to_string(description_.nodes.size());
    description_.nodes.push_back({"", operation, std::move(inputs), {output}, std::move(attributes)});
    if (!second.empty()) description_.nodes.back().outputs.push_back(second);
    return output;
  }

  std::string integers(std::vector<double> values) {
    const std::string name = "shape" + std::to_string(description_.constants.size());
    const std::size_t count = values.size();
    description_.constants[name] = {{count}, nn::ElementType::integer, std::move(values)};
    return name;
  }

  std::string numbers(std::vector<std::size_t> shape, std::vector<float> values) {
    const std::string name = "numbers" + std::to_string(description_.constants.size());
    description_.constants[name] = {std::move(shape), nn::ElementType::floating, std::move(values)};
    return name;
  }

  nn::NetworkDescription finish(std::vector<std::string> outputs) {
    description_.outputs = std::move(outputs);
    return description_;
  }

  /// Features of stride 8, 16, 32 and so on.
  std::vector<std::string> backbone(std::size_t grids = 3) {
    const auto sigmoid = [&](const std::string& from) { return add("Sigmoid", {from}); };
    const std::string four = sigmoid(convolution(sigmoid(convolution("images", 3, 4, 2)), 4, 6, 2));
    std::vector<std::string> levels{sigmoid(convolution(four, 6, 8, 2))};
    while (levels.size() < grids) levels.push_back(sigmoid(convolution(levels.back(), 8, 8, 2)));
    return levels;
  }

 private:
  nn::NetworkDescription description_;
  Random random_{7};
};

/// Classes of the detectors below.
inline constexpr std::size_t exported_classes = 5;

/// A network like YOLOX: boxes, objectness and classes from convolutions of their own, joined, laid flat,
/// joined again.
inline nn::NetworkDescription yolox_like(std::size_t size, std::size_t classes = exported_classes) {
  Exporter exporter(size);
  std::vector<std::string> flat;
  const std::map<std::string, nn::Attribute> channels{{"axis", std::int64_t(1)}};
  for (const std::string& level : exporter.backbone()) {
    const std::string scores = exporter.convolution(level, 8, classes, 1);
    const std::string boxes = exporter.convolution(level, 8, 4, 1);
    const std::string objectness = exporter.convolution(level, 8, 1, 1);
    const std::string joined = exporter.add(
        "Concat", {boxes, exporter.add("Sigmoid", {objectness}), exporter.add("Sigmoid", {scores})},
        channels);
    flat.push_back(
        exporter.add("Reshape", {joined, exporter.integers({1, static_cast<double>(5 + classes), -1})}));
  }
  const std::string all = exporter.add("Concat", flat, {{"axis", std::int64_t(2)}});
  return exporter.finish({exporter.add("Transpose", {all}, {{"perm", std::vector<std::int64_t>{0, 2, 1}}})});
}

/// Puts a batch normalisation behind the first convolution, as exports for training have it.
inline void normalise_first(nn::NetworkDescription& description) {
  nn::Node& convolution = description.nodes.front();
  const std::string output = convolution.outputs.front();
  const std::size_t channels = description.constants.at(convolution.inputs[2]).size();
  std::vector<std::string> inputs{convolution.outputs.front() = output + ".plain"};
  Random random(11);
  for (const char* name : {"bn.weight", "bn.bias", "bn.mean", "bn.variance"}) {
    std::vector<float> values(channels);
    for (float& value : values) value = static_cast<float>(random.uniform(0.5, 1.5));
    description.constants[name] = {{channels}, nn::ElementType::floating, std::move(values)};
    inputs.emplace_back(name);
  }
  description.nodes.insert(description.nodes.begin() + 1,
                           {"", "BatchNormalization", std::move(inputs), {output}, {}});
}

/// Puts all constants behind nodes Constant.
inline void hide_constants(nn::NetworkDescription& description) {
  std::vector<nn::Node> nodes;
  for (const auto& [name, constant] : description.constants)
    nodes.push_back({"", "Constant", {}, {name}, {{"value", constant}}});
  description.nodes.insert(description.nodes.begin(), nodes.begin(), nodes.end());
  description.constants.clear();
}

/// Bends the picture and the first convolution's output by one slope: where both are simplified, one is a
/// weight and the other belongs to the convolution.
inline void share_slope(nn::NetworkDescription& description) {
  nn::Node& convolution = description.nodes.front();
  const std::string picture = convolution.inputs[0], output = convolution.outputs[0];
  convolution.inputs[0] = picture + ".bent";
  convolution.outputs[0] = output + ".plain";
  description.constants["slope"] = {nn::Shape{1}, nn::ElementType::floating, std::vector<float>{0.25F}};
  const auto bend = [](const std::string& from, const std::string& to) {
    return nn::Node{"", "PRelu", {from, "slope"}, {to}, {}};
  };
  description.nodes.insert(description.nodes.begin() + 1, bend(output + ".plain", output));
  description.nodes.insert(description.nodes.begin(), bend(picture, picture + ".bent"));
}

/// A network like NanoDet: one convolution a level, split in two outputs.
inline nn::NetworkDescription nanodet_like(std::size_t size, std::size_t grids = 3) {
  Exporter exporter(size);
  std::vector<std::string> scores, distances;
  const std::vector<std::int64_t> transposed{0, 2, 1};
  for (const std::string& level : exporter.backbone(grids)) {
    const std::string both = exporter.convolution(level, 8, exported_classes + 32, 1);
    const auto part = [&](std::int64_t first, std::int64_t end) {
      const std::string cut =
          exporter.add("Slice", {both, exporter.integers({static_cast<double>(first)}),
                                 exporter.integers({static_cast<double>(end)}), exporter.integers({1})});
      return cut;
    };
    const auto flat = [&](const std::string& from, double count) {
      const std::string shaped = exporter.add("Reshape", {from, exporter.integers({1, count, -1})});
      return exporter.add("Transpose", {shaped}, {{"perm", transposed}});
    };
    scores.push_back(flat(exporter.add("Sigmoid", {part(0, exported_classes)}), exported_classes));
    distances.push_back(flat(part(exported_classes, exported_classes + 32), 32));
  }
  scores.insert(scores.end(), distances.begin(), distances.end());
  return exporter.finish(scores);
}

/// A network like YOLOv8 before its decoding: for each level one output, [1, 64 + exported_classes, H, W].
inline nn::NetworkDescription yolov8_like(std::size_t size) {
  Exporter exporter(size);
  std::vector<std::string> outputs;
  for (const std::string& level : exporter.backbone())
    outputs.push_back(exporter.add(
        "Concat",
        {exporter.convolution(level, 8, 64, 1), exporter.convolution(level, 8, exported_classes, 1)},
        {{"axis", std::int64_t(1)}}));
  return exporter.finish(outputs);
}

/// A network like DETR: cells of a picture attend to each other; outputs with numbers for names, [1, N,
/// exported_classes + 1] of a linear layer and [1, N, 4] of a logistic function.
/// \param chooses  whether queries are the surest cells, as in RT-DETR
inline nn::NetworkDescription detr_like(std::size_t size, bool chooses) {
  constexpr std::size_t channels = 8;
  Exporter exporter(size, 17);
  const auto cells = static_cast<double>(size / 8 * (size / 8));
  const std::string flat =
      exporter.add("Reshape", {exporter.backbone(1).front(), exporter.integers({1, channels, cells})});
  std::string queries = exporter.add("Transpose", {flat}, {{"perm", std::vector<std::int64_t>{0, 2, 1}}});
  Random random(5);
  const auto linear = [&](const std::string& from, std::size_t out) {
    std::vector<float> weights(channels * out);
    for (float& weight : weights) weight = static_cast<float>(random.normal());
    const std::string product = exporter.add("MatMul", {from, exporter.numbers({channels, out}, weights)});
    return exporter.add("Add", {product, exporter.numbers({out}, std::vector<float>(out, 0.25F))});
  };
  const std::string weights =
      exporter.add("Softmax", {exporter.add("MatMul", {queries, flat})}, {{"axis", std::int64_t(2)}});
  queries = exporter.add("MatMul", {weights, queries});
  if (chooses) {
    const std::string sure = exporter.add(
        "ReduceMax", {queries}, {{"axes", std::vector<std::int64_t>{0, 2}}, {"keepdims", std::int64_t(0)}});
    exporter.add("TopK", {sure, exporter.integers({10})}, {}, "places");
    queries = exporter.add("Gather", {queries, "places"}, {{"axis", std::int64_t(1)}});
  }
  const std::string scores = linear(queries, exported_classes + 1);
  return exporter.finish({scores, exporter.add("Sigmoid", {linear(queries, 4)})});
}

/// A network like YOLOv5 since version 6: for each level one convolution for three anchors, which the export
/// decodes itself into centre, extent, objectness and classes: [1, candidates, 5 + exported_classes].
///
/// \param anchors  width and height of three, of each stride
inline nn::NetworkDescription yolov5_like(std::size_t size,
                                          const std::vector<std::vector<std::array<double, 2>>>& anchors) {
  constexpr std::size_t channels = 5 + exported_classes;
  Exporter exporter(size);
  std::vector<std::string> flat;
  for (const std::string& level : exporter.backbone()) {
    const std::size_t stride = std::size_t(8) << flat.size(), cells = size / stride;
    const auto side = static_cast<double>(cells);
    const std::string raw = exporter.convolution(level, 8, 3 * channels, 1);
    const std::string parted =
        exporter.add("Reshape", {raw, exporter.integers({1, 3, static_cast<double>(channels), side, side})});
    const std::string scores = exporter.add(
        "Sigmoid",
        {exporter.add("Transpose", {parted}, {{"perm", std::vector<std::int64_t>{0, 1, 3, 4, 2}}})});
    const auto part = [&](double first, double end) {
      return exporter.add(
          "Slice", {scores, exporter.integers({first}), exporter.integers({end}), exporter.integers({4})});
    };
    const auto with = [&](const char* operation, const std::string& from, std::vector<std::size_t> shape,
                          std::vector<float> values) {
      return exporter.add(operation, {from, exporter.numbers(std::move(shape), std::move(values))});
    };
    std::vector<float> corners, extents;
    for (std::size_t cell = 0; cell < cells * cells; ++cell)
      for (const std::size_t at : {cell % cells, cell / cells})
        corners.push_back(static_cast<float>(at) - 0.5F);
    for (const auto& anchor : anchors.at(flat.size()))
      for (const double extent : anchor) extents.push_back(static_cast<float>(extent));
    const std::string centres = with(
        "Mul", with("Add", with("Mul", part(0, 2), {1}, {2}), {1, 1, cells, cells, 2}, std::move(corners)),
        {1}, {static_cast<float>(stride)});
    const std::string boxes = with("Mul", with("Pow", with("Mul", part(2, 4), {1}, {2}), {1}, {2}),
                                   {1, 3, 1, 1, 2}, std::move(extents));
    const std::string all = exporter.add("Concat", {centres, boxes, part(4, static_cast<double>(channels))},
                                         {{"axis", std::int64_t(4)}});
    flat.push_back(exporter.add("Reshape", {all, exporter.integers({1, -1, static_cast<double>(channels)})}));
  }
  return exporter.finish({exporter.add("Concat", flat, {{"axis", std::int64_t(1)}})});
}

/// A network like SSD and DETR: boxes [1, N, 4] as corners, top first, and a number for each of
/// exported_classes and, before them, for none of them, [1, N, 1 + exported_classes].
inline nn::NetworkDescription boxes_and_scores(std::size_t size, std::int64_t opset) {
  Exporter exporter(size, opset);
  const std::string level = exporter.backbone().front();
  const auto flat = [&](std::size_t channels) {
    const std::string raw = exporter.convolution(level, 8, channels, 1);
    const std::string shaped =
        exporter.add("Reshape", {raw, exporter.integers({1, static_cast<double>(channels), -1})});
    return exporter.add("Transpose", {shaped}, {{"perm", std::vector<std::int64_t>{0, 2, 1}}});
  };
  return exporter.finish({exporter.add("Sigmoid", {flat(4)}), flat(1 + exported_classes)});
}

template <class T>
Array<T, 4> pictures(std::size_t count, std::size_t size) {
  auto images = random_array<T, 4>({count, size, size, 3}, 3);
  for (T& value : images.storage()) value = (value + 1) / 2;
  return images;
}
}  // namespace tapestry::test
