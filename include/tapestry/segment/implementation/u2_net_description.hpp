#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/segment/u2_net_description.hpp>

namespace tapestry::segment {
namespace detail {
/// Writes the nodes down, block by block. Source: Qin et al., U²-Net (Pattern Recognition 106, 2020), figures
/// 2 and 5, without batch normalisation, which an exporter folds into the convolutions.
class U2NetWriter {
 public:
  U2NetWriter(const U2NetShape& shape, std::uint64_t seed) : random_(seed) {
    description_.path = "u2_net";
    description_.opset = 13;
    description_.inputs = {{"picture", {1, 3, shape.side, shape.side}}};
  }

  [[nodiscard]] nn::NetworkDescription write(const U2NetShape& shape) {
    std::vector<Map> encoded;
    Map map{"picture", 3};
    for (std::size_t i = 0; i < shape.stages.size(); ++i) {
      map = residual_u("encoder" + std::to_string(i + 1), map, shape.stages[i]);
      encoded.push_back(map);
      map = halved(map);
    }
    map = dilated("bottom", map, shape.dilated_middle, shape.dilated_out);
    std::vector<Map> decoded{map};
    for (std::size_t i = shape.stages.size(); i-- > 0;) {
      const Map both = joined({enlarged(map, 2), encoded[i]});
      map = residual_u("decoder" + std::to_string(i + 1), both, shape.stages[i]);
      decoded.insert(decoded.begin(), map);
    }
    add_sides(decoded);
    return std::move(description_);
  }

 private:
  struct Map {
    std::string name;
    std::size_t channels;
  };

  std::string add(const std::string& operation, std::vector<std::string> inputs, const std::string& output,
                  std::map<std::string, nn::Attribute> attributes = {}) {
    description_.nodes.push_back({output, operation, std::move(inputs), {output}, std::move(attributes)});
    return output;
  }

  [[nodiscard]] std::string next(const std::string& kind) { return kind + std::to_string(count_++); }

  /// A convolution whose sums have `gain` times the mean square of their inputs.
  Map convolution(const std::string& name, const Map& in, std::size_t out, std::size_t size,
                  std::int64_t dilation, double gain) {
    std::vector<float> weights(out * in.channels * size * size);
    const double scale = std::sqrt(gain / static_cast<double>(in.channels * size * size));
    for (float& weight : weights) weight = static_cast<float>(scale * random_.normal());
    using nn::ElementType;
    description_.constants[name + ".weight"] = {
        {out, in.channels, size, size}, ElementType::floating, weights};
    description_.constants[name + ".bias"] = {{out}, ElementType::floating, std::vector<float>(out, 0)};
    const auto extent = static_cast<std::int64_t>(size);
    const std::int64_t pad = dilation * (extent - 1) / 2;
    using Integers = std::vector<std::int64_t>;
    add("Conv", {in.name, name + ".weight", name + ".bias"}, name,
        {{"kernel_shape", Integers{extent, extent}},
         {"dilations", Integers{dilation, dilation}},
         {"pads", Integers{pad, pad, pad, pad}}});
    return {name, out};
  }

  /// \param gain 2 makes up for the half that a rectifier takes; results that are added to others start
  /// smaller
  Map unit(const std::string& name, const Map& in, std::size_t out, std::int64_t dilation = 1,
           double gain = 2) {
    const Map sums = convolution(name, in, out, 3, dilation, gain);
    return {add("Relu", {sums.name}, name + ".relu"), out};
  }

  Map halved(const Map& in) {
    using Integers = std::vector<std::int64_t>;
    return {
        add("MaxPool", {in.name}, next("pool"),
            {{"kernel_shape", Integers{2, 2}}, {"strides", Integers{2, 2}}, {"ceil_mode", std::int64_t(1)}}),
        in.channels};
  }

  Map enlarged(const Map& in, std::size_t times) {
    if (times == 1) return in;
    const std::string scales = "scales" + std::to_string(times);
    const auto factor = static_cast<float>(times);
    description_.constants[scales] = {
        {4}, nn::ElementType::floating, std::vector<float>{1, 1, factor, factor}};
    return {
        add("Resize", {in.name, "", scales}, next("resize"),
            {{"mode", std::string("linear")}, {"coordinate_transformation_mode", std::string("half_pixel")}}),
        in.channels};
  }

  Map joined(const std::vector<Map>& maps) {
    std::vector<std::string> names;
    std::size_t channels = 0;
    for (const Map& map : maps) {
      names.push_back(map.name);
      channels += map.channels;
    }
    return {add("Concat", names, next("concat"), {{"axis", std::int64_t(1)}}), channels};
  }

  /// RSU-L: adds a smaller U to its input, the result of the first unit.
  Map residual_u(const std::string& name, const Map& in, const ResidualU& block) {
    const Map first = unit(name + ".in", in, block.out);
    std::vector<Map> down{unit(name + ".down1", first, block.middle)};
    for (std::size_t level = 2; level < block.levels; ++level)
      down.push_back(unit(name + ".down" + std::to_string(level), halved(down.back()), block.middle));
    Map map = unit(name + ".bottom", down.back(), block.middle, 2);
    for (std::size_t level = block.levels; level-- > 1;) {
      const Map both = joined({map, down[level - 1]});
      const bool is_last = level == 1;
      map = unit(name + ".up" + std::to_string(level), both, is_last ? block.out : block.middle, 1,
                 is_last ? last_gain : 2);
      if (level > 1) map = enlarged(map, 2);
    }
    return {add("Add", {map.name, first.name}, name), block.out};
  }

  /// RSU-4F: dilated instead of halved.
  Map dilated(const std::string& name, const Map& in, std::size_t middle, std::size_t out) {
    const Map first = unit(name + ".in", in, out);
    const Map one = unit(name + ".down1", first, middle, 1), two = unit(name + ".down2", one, middle, 2),
              three = unit(name + ".down3", two, middle, 4), four = unit(name + ".bottom", three, middle, 8);
    const Map up3 = unit(name + ".up3", joined({four, three}), middle, 4);
    const Map up2 = unit(name + ".up2", joined({up3, two}), middle, 2);
    const Map up1 = unit(name + ".up1", joined({up2, one}), out, 1, last_gain);
    return {add("Add", {up1.name, first.name}, name), out};
  }

  /// The side outputs d1, d2, … of the decoder's stages at full size, and d0 of them all.
  void add_sides(const std::vector<Map>& decoded) {
    std::vector<Map> sides;
    for (std::size_t i = 0; i < decoded.size(); ++i) {
      const Map side = convolution("side" + std::to_string(i + 1), decoded[i], 1, 3, 1, last_gain);
      sides.push_back(enlarged(side, std::size_t(1) << i));
    }
    sides.insert(sides.begin(), convolution("fused", joined(sides), 1, 1, 1, 1));
    for (std::size_t i = 0; i < sides.size(); ++i)
      description_.outputs.push_back(add("Sigmoid", {sides[i].name}, "d" + std::to_string(i)));
  }

  static constexpr double last_gain = 0.2;

  Random random_;
  std::size_t count_ = 0;
  nn::NetworkDescription description_;
};
}  // namespace detail

nn::NetworkDescription u2_net_description(const U2NetShape& shape, std::uint64_t seed) {
  if (shape.stages.empty() || shape.stages.size() > 12)
    throw DomainError("u2_net_description: 1 to 12 stages");
  std::size_t stride = std::size_t(1) << shape.stages.size();
  for (std::size_t i = 0; i < shape.stages.size(); ++i) {
    const ResidualU& stage = shape.stages[i];
    if (stage.levels < 2 || stage.levels > 12 || stage.middle == 0 || stage.out == 0)
      throw DomainError({"u2_net_description: stage ", i + 1, " needs 2 to 12 levels and some channels"});
    stride = std::max(stride, std::size_t(1) << (i + stage.levels - 2));
  }
  if (shape.dilated_middle == 0 || shape.dilated_out == 0)
    throw DomainError("u2_net_description: the last stage needs some channels");
  if (shape.side == 0 || shape.side % stride != 0)
    throw DomainError({"u2_net_description: a side of ", shape.side,
                       " pixels is no multiple of the largest stride, ", stride});
  return detail::U2NetWriter(shape, seed).write(shape);
}

std::vector<std::string> u2_net_logits(const nn::NetworkDescription& network) {
  std::vector<std::string> logits;
  for (const std::string& output : network.outputs) {
    const auto node = std::ranges::find_if(network.nodes, [&](const nn::Node& candidate) {
      return candidate.operation == "Sigmoid" && candidate.outputs.front() == output;
    });
    if (node == network.nodes.end())
      throw file_mismatch(
          {network.path, "", "output '" + output + "' is not of a Sigmoid", "side outputs in [0, 1]", ""});
    logits.push_back(node->inputs.front());
  }
  return logits;
}
}  // namespace tapestry::segment
