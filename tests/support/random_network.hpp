#pragma once
#include <iterator>
#include "random_network_parts.hpp"

namespace tapestry::test {
/// A random network of ONNX's vocabulary, values between about -2 and 2, smooth but for kinks that few values
/// come near. Operands are constants, inputs behind a node, or other values; values are read never, once or
/// often, and some that are read are results, too.
class RandomNetwork : public RandomNetworkParts {
 public:
  explicit RandomNetwork(std::uint64_t seed) : RandomNetworkParts(seed) {
    description.path = "random network " + std::to_string(seed);
    description.opset = 23;
    picture(input({one_to(3), 2 * one_to(3), 2 * one_to(4), 2 * one_to(4)}));
    for (std::size_t i = 2 + random.index(9); i > 0; --i) add_node();
    for (const auto& [name, shape] : shapes) {
      const bool is_read = read.contains(name);
      if (name.front() == 'v' && (!is_read || random.chance(0.1))) description.outputs.push_back(name);
    }
  }

 private:
  void add_node() {
    const std::string x = picture();
    switch (random.index(11)) {
      case 0:
        return picture(unary(x));
      case 1:
        return picture(binary(x));
      case 2:
      case 3:
        return picture(convolution(x));
      case 4:
        return picture(normalisation(x));
      case 5:
        return picture(pooling(x));
      case 6:
        return picture(pattern(x));
      case 7:
        return picture(view(x));
      case 8:
        return picture(product(x));
      case 9:
        return picture(decomposed(x));
      default:
        return reduction(x);
    }
  }

  std::string unary(const std::string& x) {
    const char* const smooth[] = {"Sigmoid",   "Tanh",        "Erf",   "Sin",      "Cos",  "Atan",
                                  "Softplus",  "Softsign",    "Mish",  "Elu",      "Celu", "Selu",
                                  "Neg",       "Gelu",        "Asinh", "Identity", "Relu", "LeakyRelu",
                                  "HardSwish", "HardSigmoid", "Abs",   "Dropout",  "Swish"};
    const char* const of_positive[] = {"Log", "Sqrt", "Reciprocal", "Exp", "Acosh"};
    if (random.chance(0.15)) {
      const std::size_t i = random.index(5);
      const std::string bent = positive(x);
      return node(of_positive[i], {i == 4 ? node("Add", {bent, constant({}, 1, 1)}, shape(x)) : bent},
                  shape(x));
    }
    if (random.chance(0.1))
      return node("Clip", {x, constant({}, -0.6, -0.4), constant({}, 0.5, 0.8)}, shape(x));
    return node(smooth[random.index(std::size(smooth))], {x}, shape(x));
  }

  std::string binary(const std::string& x) {
    const nn::Shape s = shape(x);
    switch (random.index(9)) {
      case 0:
        return node("Div", {x, operand(s, 0.5, 2)}, s);
      case 1:
        return node("Pow", {positive(x), operand({s[1], 1, 1}, 0.5, 2)}, s);
      case 2:
        return node("PRelu", {x, operand({s[1], 1, 1}, -0.5, 0.5)}, s);
      case 3:
        return node(one_of({"Max", "Min"}), {x, partner(x), repeated(x)}, s);
      case 4:
        return node(one_of({"Sum", "Mean"}), {x, partner(x), repeated(x)}, s);
      case 5:
        return node("Mul", {repeated(x), bounded(x)}, s);
      default:
        return node(one_of({"Add", "Sub", "Mul"}), {bounded(x), repeated(x)}, s);
    }
  }

  std::string convolution(const std::string& x) {
    const nn::Shape s = shape(x);
    const bool grows = s[2] < 8 && random.chance(0.15);
    const std::size_t groups = random.chance(0.4) ? (random.chance(0.5) ? s[1] : 2) : 1;
    const std::size_t outs = groups * one_to(groups > 2 ? 1 : 4), ins = s[1] / groups;
    std::string bias = random.chance(0.6) ? operand({outs}, -0.5, 0.5) : "";
    const std::size_t side = grows ? 2 : one_of<std::size_t>({1, 3, 3});
    const double size = 1.5 / std::sqrt(static_cast<double>(ins * side * side));
    Attributes attributes{{"group", whole(groups)}};
    nn::Shape out{s[0], outs, s[2], s[3]};
    std::vector<std::string> operands{x};
    if (grows) {
      operands.push_back(operand({s[1], outs / groups, 2, 2}, -size, size));
      attributes["strides"] = Ints{2, 2};
      out[2] *= 2;
      out[3] *= 2;
    } else {
      operands.push_back(operand({outs, ins, side, side}, -size, size));
      const std::size_t stride = out[2] % 4 == 0 && out[3] % 4 == 0 ? one_to(2) : 1;
      attributes["strides"] = Ints{whole(stride), whole(stride)};
      if (side == 3) attributes["pads"] = Ints{1, 1, 1, 1};
      out[2] /= stride;
      out[3] /= stride;
    }
    if (!bias.empty()) operands.push_back(bias);
    const std::string y = node(grows ? "ConvTranspose" : "Conv", operands, out, attributes);
    if (out[1] % 2 != 0)
      return node("Concat", {y, y}, {out[0], 2 * out[1], out[2], out[3]}, {{"axis", whole(1)}});
    return random.chance(0.5) ? unary(y) : y;
  }

  /// Operators that are made of others; rows of a picture are sequences.
  std::string decomposed(const std::string& x) {
    const nn::Shape s = shape(x);
    const nn::Shape rows{s[2], s[0] * s[1], s[3]}, cells{s[0] * s[1], 4, s[2] / 2 * (s[3] / 2)};
    const auto back = [&](const std::string& y, nn::Shape own) {
      return node("Reshape", {y, setting(numbers_of(own))}, own);
    };
    const auto equation = [](const char* text) { return Attributes{{"equation", std::string(text)}}; };
    const double size = 1.5 / std::sqrt(static_cast<double>(s[3]));
    switch (random.index(6)) {
      case 0:
        return node("Einsum", {x, operand({s[3], s[3]}, -size, size)}, s, equation("...ij,jk->...ik"));
      case 1:
        return node("Einsum", {bounded(x), operand({s[1]}, -1, 1), operand(s, -1, 1)}, s,
                    equation("nchw,c,nchw->nchw"));
      case 2:
        return node("RMSNormalization", {x, operand({s[3]}, 0.5, 1.5)}, s, {{"epsilon", 0.1}});
      case 3: {
        const std::string flat = back(x, {s[0] * s[1], s[2], s[3]});
        const std::string y =
            node("Conv", {flat, operand({s[2], s[2], 3}, -size, size)}, shape(flat), {{"pads", Ints{1, 1}}});
        return back(y, s);
      }
      case 4: {
        const std::string flat = back(x, cells);
        const nn::Shape image{cells[0], 1, s[2], s[3]};
        const std::string y = node("Col2Im", {flat, setting(numbers_of({s[2], s[3]})), setting({2, 2})},
                                   image, {{"strides", Ints{2, 2}}});
        return back(y, s);
      }
      default: {
        const std::string kind = one_of({"LSTM", "GRU", "RNN"});
        const std::size_t gates = kind == "LSTM" ? 4 : kind == "GRU" ? 3 : 1;
        const std::string y =
            node(kind.c_str(),
                 {back(x, rows), operand({1, gates * s[3], s[3]}, -size, size),
                  operand({1, gates * s[3], s[3]}, -size, size), operand({1, 2 * gates * s[3]}, -0.5, 0.5)},
                 {rows[0], 1, rows[1], rows[2]},
                 {{"direction", std::string(one_of({"forward", "reverse"}))}, {"hidden_size", whole(s[3])}});
        return back(y, s);
      }
    }
  }
  static std::vector<double> numbers_of(const nn::Shape& extents) { return {extents.begin(), extents.end()}; }

  std::string normalisation(const std::string& x) {
    const nn::Shape s = shape(x);
    const auto scale = [&](std::size_t count) { return operand({count}, 0.5, 1.5); };
    const auto bias = [&](std::size_t count) { return operand({count}, -0.5, 0.5); };
    const Attributes soft{{"epsilon", 0.1}};
    switch (random.index(6)) {
      case 0:
      case 1:
        return node("BatchNormalization", {x, scale(s[1]), bias(s[1]), bias(s[1]), scale(s[1])}, s, soft);
      case 2:
        return node("InstanceNormalization", {x, scale(s[1]), bias(s[1])}, s, soft);
      case 3:
        return node("GroupNormalization", {x, scale(s[1]), bias(s[1])}, s,
                    {{"epsilon", 0.1}, {"num_groups", whole(2)}});
      case 4:
        return node("LayerNormalization", {x, scale(s[3]), bias(s[3])}, s, soft);
      default:
        return node("LRN", {x}, s, {{"size", whole(3)}, {"alpha", 0.3}});
    }
  }

  std::string pooling(const std::string& x) {
    const nn::Shape s = shape(x);
    const char* const kind = one_of({"AveragePool", "MaxPool", "LpPool"});
    const std::string from = kind == std::string("LpPool") ? positive(x) : x;
    if (s[2] % 4 == 0 && s[3] % 4 == 0 && random.chance(0.7))
      return node(kind, {from}, {s[0], s[1], s[2] / 2, s[3] / 2},
                  {{"kernel_shape", Ints{2, 2}}, {"strides", Ints{2, 2}}});
    if (random.chance(0.5) || s[2] > 8)
      return node(kind, {from}, s, {{"kernel_shape", Ints{3, 3}}, {"pads", Ints{1, 1, 1, 1}}});
    const std::string scales = "scales" + std::to_string(description.constants.size());
    description.constants[scales] = {{4}, nn::ElementType::floating, std::vector<float>{1, 1, 2, 2}};
    return node("Resize", {x, "", scales}, {s[0], s[1], 2 * s[2], 2 * s[3]},
                {{"mode", std::string(one_of({"nearest", "linear", "cubic"}))}});
  }

  /// Patterns that simplified() looks for.
  std::string pattern(const std::string& x) {
    const nn::Shape s = shape(x);
    switch (random.index(4)) {
      case 0:
        return node("Mul", {x, node("Sigmoid", {x}, s)}, s);
      case 1:
        return node("Mul", {x, node("HardSigmoid", {x}, s, {{"alpha", 1.0 / 6}, {"beta", 0.5}})}, s);
      case 2:
        return node("Mul", {x, node("Tanh", {node("Softplus", {x}, s)}, s)}, s);
      default: {
        const nn::Shape split{s[0], 2, s[1] / 2, s[2], s[3]}, turned{s[0], s[1] / 2, 2, s[2], s[3]};
        const auto extents = [&](const nn::Shape& shape) { return setting({shape.begin(), shape.end()}); };
        const std::string apart = node("Reshape", {x, extents(split)}, split);
        const std::string other = node("Transpose", {apart}, turned, {{"perm", Ints{0, 2, 1, 3, 4}}});
        return node("Reshape", {other, extents(s)}, s);
      }
    }
  }

  std::string view(const std::string& x) {
    const nn::Shape s = shape(x);
    const auto d = [](std::size_t value) { return static_cast<double>(value); };
    switch (random.index(6)) {
      case 0: {
        const std::string y = partner(x);
        return s[1] > 8 ? x : node("Concat", {x, y}, {s[0], 2 * s[1], s[2], s[3]}, {{"axis", whole(1)}});
      }
      case 1:
        if (s[1] % 4 != 0) return x;
        return node("Slice", {x, setting({d(s[1] / 2)}), setting({d(s[1])}), setting({1})},
                    {s[0], s[1] / 2, s[2], s[3]});
      case 2:
        return node("Transpose", {x}, {s[0], s[1], s[3], s[2]}, {{"perm", Ints{0, 1, 3, 2}}});
      case 3:
        return node("Pad", {x, setting({0, 0, 1, 0, 0, 0, 1, 2})}, {s[0], s[1], s[2] + 2, s[3] + 2},
                    {{"mode", std::string(one_of({"constant", "edge"}))}});
      case 4:
        if (s[1] > 8 || s[2] % 4 != 0 || s[3] % 4 != 0) return x;
        return node("SpaceToDepth", {x}, {s[0], s[1] * 4, s[2] / 2, s[3] / 2}, {{"blocksize", whole(2)}});
      default: {
        std::vector<double> order;
        for (std::size_t i = 0; i < s[1]; ++i) order.push_back(d(random.index(s[1])));
        return node("Gather", {x, setting(order)}, s, {{"axis", whole(1)}});
      }
    }
  }

  std::string product(const std::string& x) {
    const nn::Shape s = shape(x);
    const double size = 1.5 / std::sqrt(static_cast<double>(s[3]));
    const std::size_t columns = 2 * one_to(3);
    const nn::Shape out{s[0], s[1], s[2], columns};
    if (random.chance(0.4)) return node("MatMul", {x, operand({s[3], columns}, -size, size)}, out);
    if (random.chance(0.4)) {
      const std::string turned =
          node("Transpose", {partner(x)}, {s[0], s[1], s[3], s[2]}, {{"perm", Ints{0, 1, 3, 2}}});
      const std::string all = node("MatMul", {bounded(x), turned}, {s[0], s[1], s[2], s[2]});
      return node("Softmax", {all}, shape(all));
    }
    const std::size_t rows = s[0] * s[1] * s[2];
    const std::string flat = node("Reshape", {x, setting({-1, static_cast<double>(s[3])})}, {rows, s[3]});
    std::vector<std::string> operands{flat, operand({columns, s[3]}, -size, size)};
    if (random.chance(0.6)) operands.push_back(operand({columns}, -0.5, 0.5));
    const std::string y = node("Gemm", operands, {rows, columns}, {{"transB", whole(1)}, {"alpha", 0.8}});
    return node("Reshape", {y, setting({out.begin(), out.end()})}, out);
  }

  /// A result that nobody reads.
  void reduction(const std::string& x) {
    const nn::Shape s = shape(x);
    const char* const kind =
        one_of({"ReduceMean", "ReduceSum", "ReduceMax", "ReduceL2", "ReduceLogSumExp", "ReduceProd",
                "ReduceSumSquare", "ReduceL1", "ReduceMin", "ReduceLogSum"});
    const std::size_t axis = 1 + random.index(3);
    nn::Shape out = s;
    out[axis] = 1;
    node(kind, {positive(x), setting({static_cast<double>(axis)})}, out);
    if (random.chance(0.3)) node(one_of({"Softmax", "LogSoftmax"}), {x}, s, {{"axis", whole(axis)}});
    if (random.chance(0.3)) node("CumSum", {x, setting({static_cast<double>(axis)})}, s);
  }
};
}  // namespace tapestry::test
