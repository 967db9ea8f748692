#include "../../../support/operator_case.hpp"
#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using Numbers = std::vector<double>;
using Ints = std::vector<std::int64_t>;
constexpr double nothing = -std::numeric_limits<double>::infinity();

double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

OperatorNetwork network_of(const char* operation, std::vector<TestOperand> operands,
                           std::map<std::string, nn::Attribute> attributes, std::int64_t opset = 23) {
  return operator_network(operation, std::move(operands), std::move(attributes), opset);
}

/// Both precisions against the values expected, and the adjoints against differences.
void check(const OperatorNetwork& test, const Numbers& expected) {
  CHECK(largest_difference(result_of<double>(test), expected) <= 1e-13);
  CHECK(largest_difference(result_of<float>(test), expected) <= 2e-6);
  check_adjoints(test);
}

/// Einsum by a loop over all letters, each of extent 2 or 3, without ellipsis or broadcasting.
Numbers einsum(const std::vector<std::string>& terms, const std::string& result,
               const std::vector<TestOperand>& operands) {
  std::map<char, std::size_t> extent, at;
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (std::size_t a = 0; a < terms[t].size(); ++a) extent[terms[t][a]] = operands[t].shape[a];
  std::size_t loops = 1, size = 1;
  for (const auto& [letter, n] : extent) loops *= n;
  for (const char letter : result) size *= extent.at(letter);
  Numbers sums(size);
  const auto place = [&](const std::string& letters) {
    std::size_t index = 0;
    for (const char letter : letters) index = index * extent.at(letter) + at.at(letter);
    return index;
  };
  for (std::size_t loop = 0; loop < loops; ++loop) {
    std::size_t rest = loop;
    for (const auto& [letter, n] : extent) {
      at[letter] = rest % n;
      rest /= n;
    }
    double product = 1;
    for (std::size_t t = 0; t < terms.size(); ++t) product *= operands[t].values[place(terms[t])];
    sums[place(result)] += product;
  }
  return sums;
}

/// One step after the other of one direction, from the formulas of ONNX.
struct PlainRecurrence {
  std::string kind{};
  std::size_t size = 0, inputs = 0;
  Numbers w{}, r{}, bias{}, peepholes{};
  bool resets_after = false;

  [[nodiscard]] double row(std::size_t gate, std::size_t k, const double* x, const Numbers& h, bool of_x,
                           bool of_h) const {
    const std::size_t rows = w.size() / inputs, at = gate * size + k;
    double sum = 0;
    for (std::size_t i = 0; of_x && i < inputs; ++i) sum += w[at * inputs + i] * x[i];
    for (std::size_t i = 0; of_h && i < size; ++i) sum += r[at * size + i] * h[i];
    if (!bias.empty()) sum += (of_x ? bias[at] : 0) + (of_h ? bias[rows + at] : 0);
    return sum;
  }
  void step(const double* x, Numbers& h, Numbers& c) const {
    Numbers next(size), reset(size);
    for (std::size_t k = 0; kind == "GRU" && k < size; ++k) reset[k] = sigmoid(row(1, k, x, h, true, true));
    for (std::size_t k = 0; k < size; ++k) {
      const auto all = [&](std::size_t gate) { return row(gate, k, x, h, true, true); };
      const auto peep = [&](std::size_t i, double cell) {
        return peepholes.empty() ? 0 : peepholes[i * size + k] * cell;
      };
      if (kind == "RNN") next[k] = std::tanh(all(0));
      if (kind == "LSTM") {
        const double old = c[k];
        c[k] = sigmoid(all(2) + peep(2, old)) * old + sigmoid(all(0) + peep(0, old)) * std::tanh(all(3));
        next[k] = sigmoid(all(1) + peep(1, c[k])) * std::tanh(c[k]);
      }
      if (kind == "GRU") {
        Numbers faded(size);
        for (std::size_t i = 0; i < size; ++i) faded[i] = reset[i] * h[i];
        const double from =
            resets_after ? reset[k] * row(2, k, x, h, false, true) : row(2, k, x, faded, false, true);
        const double fresh = std::tanh(row(2, k, x, h, true, false) + from);
        const double update = sigmoid(all(0));
        next[k] = (1 - update) * fresh + update * h[k];
      }
    }
    h = next;
  }
};

constexpr std::size_t steps = 4, batch = 2, width = 3, hidden = 2;

/// A node with all operands, and its first result.
void check_recurrent(const std::string& kind, const std::string& direction, bool resets_after,
                     bool has_peepholes) {
  CAPTURE(kind, direction, resets_after, has_peepholes);
  const std::size_t gates = kind == "LSTM" ? 4 : kind == "GRU" ? 3 : 1;
  const std::size_t directions = direction == "bidirectional" ? 2 : 1;
  std::vector<TestOperand> operands{given({steps, batch, width}, 1),
                                    weight({directions, gates * hidden, width}, 2),
                                    weight({directions, gates * hidden, hidden}, 3),
                                    weight({directions, 2 * gates * hidden}, 4),
                                    {},
                                    given({directions, batch, hidden}, 5)};
  if (kind == "LSTM") operands.push_back(given({directions, batch, hidden}, 6));
  if (has_peepholes) operands.push_back(weight({directions, 3 * hidden}, 7));
  std::map<std::string, nn::Attribute> attributes{{"direction", direction},
                                                  {"hidden_size", std::int64_t(hidden)}};
  if (kind == "GRU") attributes["linear_before_reset"] = std::int64_t(resets_after);
  Numbers expected(steps * directions * batch * hidden);
  const auto of_direction = [&](std::size_t i, std::size_t d) {
    const Numbers& all = operands[i].values;
    const auto part = static_cast<std::ptrdiff_t>(all.size() / directions);
    const auto first = all.begin() + part * static_cast<std::ptrdiff_t>(d);
    return Numbers(first, first + part);
  };
  for (std::size_t d = 0; d < directions; ++d) {
    PlainRecurrence plain{kind, hidden, width, of_direction(1, d), of_direction(2, d), of_direction(3, d)};
    plain.resets_after = resets_after;
    if (has_peepholes) plain.peepholes = of_direction(7, d);
    for (std::size_t b = 0; b < batch; ++b) {
      const auto start = [&](std::size_t i) {
        const Numbers all = of_direction(i, d);
        const auto first = all.begin() + static_cast<std::ptrdiff_t>(b * hidden);
        return Numbers(first, first + hidden);
      };
      Numbers h = start(5), c = kind == "LSTM" ? start(6) : Numbers(hidden);
      for (std::size_t i = 0; i < steps; ++i) {
        const std::size_t t = d == 1 || direction == "reverse" ? steps - 1 - i : i;
        plain.step(&operands[0].values[(t * batch + b) * width], h, c);
        std::ranges::copy(
            h, expected.begin() + static_cast<std::ptrdiff_t>(((t * directions + d) * batch + b) * hidden));
      }
    }
  }
  check(network_of(kind.c_str(), operands, attributes, 17), expected);
}
}  // namespace

TEST_CASE("Einsum is the sum over all letters that its result leaves out", "[nn][network][einsum]") {
  const std::map<char, std::size_t> extents{{'a', 2}, {'b', 3}, {'c', 2}, {'d', 4}};
  const auto run = [&](const std::string& equation, const std::vector<std::string>& terms,
                       const std::string& result) {
    CAPTURE(equation);
    std::vector<TestOperand> operands;
    for (std::size_t t = 0; t < terms.size(); ++t) {
      nn::Shape shape;
      for (const char letter : terms[t]) shape.push_back(extents.at(letter));
      operands.push_back(t % 2 == 0 ? given(shape, t + 1) : weight(shape, t + 1));
    }
    check(network_of("Einsum", operands, {{"equation", equation}}), einsum(terms, result, operands));
  };
  run("ab,bc->ac", {"ab", "bc"}, "ac");
  run(" ab , bc ", {"ab", "bc"}, "ac");  // the result has the letters that occur once
  run("abd,acd->abc", {"abd", "acd"}, "abc");
  run("ab,cd->dbca", {"ab", "cd"}, "dbca");  // an outer product
  run("ab,ab->", {"ab", "ab"}, "");
  run("abc->ca", {"abc"}, "ca");
  run("aba->ba", {"aba"}, "ba");  // a diagonal
  run("aa,a->", {"aa", "a"}, "");
  run("ab,bd,dc,c->a", {"ab", "bd", "dc", "c"}, "a");
  run("abcd,abca->db", {"abcd", "abca"}, "db");
}

TEST_CASE("Einsum repeats axes of extent 1 and those that an ellipsis stands for", "[nn][network][einsum]") {
  const auto a = given({2, 1, 3, 4}, 1), b = weight({5, 4, 2}, 2);
  Numbers expected(2 * 5 * 3 * 2);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const std::size_t k = i % 2, row = i / 2 % 3, e = i / 6 % 5, n = i / 30;
    for (std::size_t j = 0; j < 4; ++j)
      expected[i] += a.values[(n * 3 + row) * 4 + j] * b.values[(e * 4 + j) * 2 + k];
  }
  check(network_of("Einsum", {a, b}, {{"equation", std::string("...ij,...jk->...ik")}}), expected);
}

TEST_CASE("equations that are none are refused by what is wrong", "[nn][network][einsum]") {
  const auto complaint = [](const std::string& equation, std::vector<nn::Shape> shapes) {
    return complaint_of({"Einsum", std::move(shapes), {{"equation", equation}}});
  };
  CHECK_THAT(complaint("i?,j", {{2, 2}, {2}}), contains("has an unknown letter '?'"));
  CHECK_THAT(complaint("ij", {{2, 2}, {2}}), contains("has 1 operands, expected 2"));
  CHECK_THAT(complaint("ijk", {{2, 2}}), contains("names 3 axes of operand 0, which has 2"));
  CHECK_THAT(complaint("ij->k", {{2, 2}}), contains("a letter in its result alone, 'k'"));
  CHECK_THAT(complaint("ij->ii", {{2, 2}}), contains("a letter twice in its result, 'i'"));
  CHECK_THAT(complaint("ij,jk", {{2, 3}, {4, 2}}), contains("axis j has extents 3 and 4"));
}

TEST_CASE("recurrent layers take one step after the other", "[nn][network][recurrent]") {
  for (const char* direction : {"forward", "reverse", "bidirectional"}) {
    check_recurrent("RNN", direction, false, false);
    for (const bool peepholes : {false, true}) check_recurrent("LSTM", direction, false, peepholes);
    for (const bool after : {false, true}) check_recurrent("GRU", direction, after, false);
  }
}

TEST_CASE("recurrent layers refuse what they do not run", "[nn][network][recurrent]") {
  const auto complaint = [](std::map<std::string, nn::Attribute> attributes, nn::Shape weights) {
    return complaint_of({"LSTM", {{4, 2, 3}, std::move(weights), {1, 8, 2}}, std::move(attributes)});
  };
  CHECK(complaint({}, {1, 8, 3}).empty());
  CHECK_THAT(complaint({}, {2, 8, 3}), contains("expected [1, 8, 3]"));
  CHECK_THAT(complaint({{"direction", std::string("bidirectional")}}, {1, 8, 3}),
             contains("expected [2, 8, 3] and [2, 8, 2]"));
  CHECK_THAT(complaint({{"direction", std::string("up")}}, {1, 8, 3}), contains("direction is 'up'"));
  CHECK_THAT(complaint({{"layout", std::int64_t(7)}}, {1, 8, 3}), contains("'layout' is 7, expected 0 or 1"));
  const auto of_operand = [](std::size_t place, const nn::Shape& shape) {
    OperatorCase test{"LSTM", {{4, 2, 3}, {1, 8, 3}, {1, 8, 2}, shape}};
    nn::NetworkDescription network = description_of(test);
    network.nodes[0].inputs.insert(network.nodes[0].inputs.begin() + 3, place - 3, "");
    try {
      const nn::Network<double> made(network);
    } catch (const tapestry::Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(of_operand(3, {1, 16}).empty());
  CHECK_THAT(of_operand(3, {1, 8}),
             contains("LSTM \"y0\" (opset 17): the bias, input 3, is [1, 8], expected [1, 16]"));
  CHECK_THAT(of_operand(5, {1, 2, 3}),
             contains("the first output, input 5, is [1, 2, 3], expected [1, 2, 2]"));
  CHECK_THAT(of_operand(6, {2, 2}), contains("the first cell, input 6, is [2, 2], expected [1, 2, 2]"));
  CHECK_THAT(of_operand(7, {1, 8}), contains("the peepholes, input 7, is [1, 8], expected [1, 6]"));
  CHECK_THAT(complaint({{"clip", 1.0}}, {1, 8, 3}), contains("'clip' is not supported"));
  CHECK_THAT(complaint({{"activations", std::vector<std::string>{"Sigmoid", "Affine", "Tanh"}}}, {1, 8, 3}),
             contains("'Affine' is not supported"));
  CHECK_THAT(complaint({{"hidden_size", std::int64_t(5)}}, {1, 8, 3}),
             contains("hidden_size is 5, expected 2"));
}

TEST_CASE("Attention weighs values by the softmax of products", "[nn][network][attention]") {
  constexpr std::size_t heads = 4, key_heads = 2, length = 3, keys = 5, size = 2;
  for (const bool is_causal : {false, true})
    for (const bool has_mask : {false, true}) {
      CAPTURE(is_causal, has_mask);
      auto q = given({1, heads, length, size}, 1), k = given({1, key_heads, keys, size}, 2),
           v = given({1, key_heads, keys, size}, 3);
      TestOperand mask{};
      if (has_mask) mask = given({length, keys}, 4);
      Numbers expected(heads * length * size);
      for (std::size_t h = 0; h < heads; ++h)
        for (std::size_t i = 0; i < length; ++i) {
          Numbers share(keys);
          double sum = 0;
          for (std::size_t j = 0; j < keys; ++j) {
            double score = 0;
            for (std::size_t c = 0; c < size; ++c)
              score += q.values[(h * length + i) * size + c] * k.values[(h / 2 * keys + j) * size + c] * 0.7;
            if (has_mask) score += mask.values[i * keys + j];
            share[j] = is_causal && j > i ? 0 : std::exp(score);
            sum += share[j];
          }
          for (std::size_t j = 0; j < keys; ++j)
            for (std::size_t c = 0; c < size; ++c)
              expected[(h * length + i) * size + c] +=
                  share[j] / sum * v.values[(h / 2 * keys + j) * size + c];
        }
      std::vector<TestOperand> operands{q, k, v};
      if (has_mask) operands.push_back(mask);
      check(network_of("Attention", operands, {{"is_causal", std::int64_t(is_causal)}, {"scale", 0.7}}),
            expected);
    }
}

TEST_CASE("a query whose keys are all masked attends to nothing", "[nn][network][attention]") {
  const auto q = given({1, 1, 3, 2}, 1), k = given({1, 1, 4, 2}, 2), v = given({1, 1, 4, 2}, 3);
  const Numbers truths{1, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0};  // row 1: all masked; row 2: key 1 alone
  Numbers sums = truths;
  for (double& sum : sums) sum = sum != 0 ? 0.0 : nothing;
  for (const bool is_truth : {false, true}) {
    const TestOperand mask{TestOperand::Kind::constant,
                           {3, 4},
                           is_truth ? truths : sums,
                           is_truth ? nn::ElementType::boolean : nn::ElementType::floating};
    const auto test = network_of("Attention", {q, k, v, mask}, {});
    const auto found = result_of<double>(test);
    CHECK(Numbers(found.begin() + 2, found.end()) == Numbers{0, 0, v.values[2], v.values[3]});
    check_adjoints(test);  // NaN is no slope
  }
}

TEST_CASE("masks that are stored channels last mask all keys as well", "[nn][network][attention]") {
  auto test =
      network_of("Attention", {given({1, 1, 3, 2}, 1), given({1, 1, 4, 2}, 2), given({1, 1, 4, 2}, 3)}, {});
  test.operands.push_back(
      {TestOperand::Kind::given,
       {1, 1, 3, 4},
       {0, 0, nothing, 0, nothing, nothing, nothing, nothing, nothing, 0, nothing, nothing}});
  const auto plain = result_of<double>(test);
  CHECK(plain[2] == 0);
  const nn::Network<double> network(test.description(), {}, true, false);  // of one channel: the same order
  nn::NetworkPass<double> pass;
  const auto inputs = test.inputs<double>();
  network.forward(addresses(inputs), pass);
  CHECK(largest_difference(std::vector<double>(pass.output(0), pass.output(0) + 6), plain) <= 1e-15);
}

TEST_CASE("Softmax of nothing is not a number, as ONNX's formula", "[nn][network][attention]") {
  const TestOperand x{TestOperand::Kind::given, {2, 2}, {nothing, nothing, nothing, 1}};
  for (const char* operation : {"Softmax", "LogSoftmax"}) {
    const auto found = result_of<double>(network_of(operation, {x}, {{"axis", std::int64_t(-1)}}));
    CHECK(std::isnan(found[0]));
    CHECK(std::isnan(found[1]));
    CHECK(found[3] == (std::string(operation) == "Softmax" ? 1 : 0));
  }
}

TEST_CASE("RMSNormalization divides by the root of the mean of squares", "[nn][network][normalization]") {
  const auto x = given({2, 3, 4}, 1), scale = weight({3, 4}, 2, 0.5, 2);
  Numbers expected = x.values;
  for (std::size_t n = 0; n < 2; ++n) {
    double squares = 0;
    for (std::size_t i = 0; i < 12; ++i) squares += x.values[12 * n + i] * x.values[12 * n + i];
    for (std::size_t i = 0; i < 12; ++i)
      expected[12 * n + i] *= scale.values[i] / std::sqrt(squares / 12 + 1e-3);
  }
  check(network_of("RMSNormalization", {x, scale}, {{"axis", std::int64_t(1)}, {"epsilon", 1e-3}}), expected);
}

TEST_CASE("Col2Im adds up patches where they overlap, and leaves out what lies beside the picture",
          "[nn][network][col2im]") {
  constexpr std::size_t channels = 2, height = 4, width_of = 4, rows = 3, columns = 4;
  const auto x = given({1, channels * 4, rows * columns}, 1);
  Numbers expected(channels * height * width_of);
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t tap = 0; tap < 4; ++tap)
      for (std::size_t patch = 0; patch < rows * columns; ++patch) {
        const auto y = static_cast<std::int64_t>(patch / columns * 2 + tap / 2) - 1;     // pads 1, stride 2
        const auto wide = static_cast<std::int64_t>(patch % columns + tap % 2 * 2) - 1;  // dilation 2
        if (y < 0 || wide < 0 || y >= static_cast<std::int64_t>(height) ||
            wide >= static_cast<std::int64_t>(width_of))
          continue;
        expected[(c * height + static_cast<std::size_t>(y)) * width_of + static_cast<std::size_t>(wide)] +=
            x.values[(c * 4 + tap) * rows * columns + patch];
      }
  check(network_of("Col2Im", {x, numbers({4, 4}), numbers({2, 2})},
                   {{"strides", Ints{2, 1}}, {"dilations", Ints{1, 2}}, {"pads", Ints{1, 1, 1, 1}}}),
        expected);
}

TEST_CASE("QuickGelu is x times the sigmoid of alpha x", "[nn][network][unary]") {
  const auto x = given({2, 5}, 1, -4, 4);
  Numbers expected;
  for (const double value : x.values) expected.push_back(value * sigmoid(1.3 * value));
  check(network_of("com.microsoft.QuickGelu", {x}, {{"alpha", 1.3}}), expected);
}

TEST_CASE("a convolution of one axis is a sum along it", "[nn][network][convolution]") {
  const auto x = given({2, 4, 7}, 1), w = weight({6, 2, 3}, 2), bias = weight({6}, 3);
  Numbers expected;
  for (std::size_t n = 0; n < 2; ++n)
    for (std::size_t o = 0; o < 6; ++o)
      for (std::int64_t t = 0; t < 3; ++t) {  // 7 + 1 + 1 − 2·2 = 5 places, every second
        double sum = bias.values[o];
        for (std::size_t i = 0; i < 2; ++i)
          for (std::int64_t k = 0; k < 3; ++k) {
            const std::int64_t at = 2 * t + 2 * k - 1;
            if (at < 0 || at >= 7) continue;
            sum += w.values[(o * 2 + i) * 3 + static_cast<std::size_t>(k)] *
                   x.values[(n * 4 + o / 3 * 2 + i) * 7 + static_cast<std::size_t>(at)];
          }
        expected.push_back(sum);
      }
  check(network_of(
            "Conv", {x, w, bias},
            {{"group", std::int64_t(2)}, {"strides", Ints{2}}, {"dilations", Ints{2}}, {"pads", Ints{1, 1}}}),
        expected);
}

TEST_CASE("pools of one axis take means and largest along it", "[nn][network][pooling]") {
  const auto x = given({1, 2, 6}, 1);
  Numbers means, largest, all;
  for (std::size_t c = 0; c < 2; ++c) {
    double sum = 0;
    for (std::size_t t = 0; t < 6; ++t) sum += x.values[c * 6 + t] / 6;
    all.push_back(sum);
    for (std::size_t t = 0; t < 2; ++t) {
      const double* const at = &x.values[c * 6 + 3 * t];
      means.push_back((at[0] + at[1] + at[2]) / 3);
      largest.push_back(std::max({at[0], at[1], at[2]}));
    }
  }
  const std::map<std::string, nn::Attribute> window{{"kernel_shape", Ints{3}}, {"strides", Ints{3}}};
  check(network_of("AveragePool", {x}, window), means);
  check(network_of("MaxPool", {x}, window), largest);
  check(network_of("GlobalAveragePool", {x}, {}), all);
}

TEST_CASE("a convolution of three axes is a sum over all of them", "[nn][network][convolution]") {
  constexpr std::int64_t depth = 5, height = 4, width_of = 3,
                         out_depth = 3;  // 5 + 1 + 1 − 3 = 4 places, by twos
  const auto x = given({2, 2, 5, 4, 3}, 1), w = weight({3, 2, 3, 2, 2}, 2), bias = weight({3}, 3);
  Numbers expected;
  for (std::size_t n = 0; n < 2; ++n)
    for (std::size_t o = 0; o < 3; ++o)
      for (std::int64_t d = 0; d < out_depth; ++d)
        for (std::int64_t i = 0; i < height; ++i)  // pads 1 above
          for (std::int64_t j = 0; j + 1 < width_of; ++j) {
            double sum = bias.values[o];
            for (std::size_t c = 0; c < 2; ++c)
              for (std::int64_t tap = 0; tap < 12; ++tap) {
                const std::int64_t z = 2 * d - 1 + tap / 4, y = i - 1 + tap / 2 % 2, u = j + tap % 2;
                if (z < 0 || z >= depth || y < 0 || y >= height) continue;
                const std::int64_t at = ((std::int64_t(2 * n + c) * depth + z) * height + y) * width_of + u;
                sum += w.values[(o * 2 + c) * 12 + static_cast<std::size_t>(tap)] *
                       x.values[static_cast<std::size_t>(at)];
              }
            expected.push_back(sum);
          }
  const std::map<std::string, nn::Attribute> attributes{{"strides", Ints{2, 1, 1}},
                                                        {"pads", Ints{1, 1, 0, 1, 0, 0}}};
  check(network_of("Conv", {x, w, bias}, attributes, 13), expected);
  auto early = network_of("Conv", {x, w, bias}, attributes, 9);  // Slice and Pad have attributes there
  CHECK(largest_difference(result_of<double>(early), expected) <= 1e-13);
  CHECK_THAT(complaint_of({"Conv", {{1, 2, 2, 4, 4}, {1, 2, 3, 1, 1}}}),
             contains("a depth of 2 for a filter of 3"));
}

TEST_CASE("pools of three axes take means and largest of boxes", "[nn][network][pooling]") {
  const auto x = given({1, 2, 4, 4, 2}, 1);
  Numbers means, largest;
  for (std::size_t c = 0; c < 2; ++c)
    for (std::size_t box = 0; box < 4; ++box) {  // of 2 · 2 · 2, the third axis is one box
      double sum = 0, most = -2;
      for (std::size_t tap = 0; tap < 8; ++tap) {
        const std::size_t z = box / 2 * 2 + tap / 4, y = box % 2 * 2 + tap / 2 % 2;
        const double value = x.values[((c * 4 + z) * 4 + y) * 2 + tap % 2];
        sum += value / 8;
        most = std::max(most, value);
      }
      means.push_back(sum);
      largest.push_back(most);
    }
  const std::map<std::string, nn::Attribute> box{{"kernel_shape", Ints{2, 2, 2}}, {"strides", Ints{2, 2, 2}}};
  check(network_of("AveragePool", {x}, box, 13), means);
  check(network_of("MaxPool", {x}, box, 13), largest);
}

TEST_CASE("names of parts stay clear of a file's own", "[nn][network]") {
  nn::NetworkDescription network;
  network.opset = 23;
  network.inputs = {{"x", {2, 2}}, {"y#0", {2, 2}}};
  network.nodes = {{"", "Einsum", {"x", "y#0"}, {"y"}, {{"equation", std::string("ij,jk->ik")}}},
                   {"", "Neg", {"y"}, {"y#1"}, {}},
                   {"", "Add", {"y#1", "y#0"}, {"z"}, {}}};
  network.outputs = {"z"};
  const nn::Network<double> made(network);
  nn::NetworkPass<double> pass;
  nn::Buffer<double> x(4), other(4);
  for (std::size_t i = 0; i < 4; ++i) {
    x.data()[i] = i % 3 == 0 ? 2 : 0;  // twice the unit matrix
    other.data()[i] = static_cast<double>(i + 1);
  }
  made.forward({x.data(), other.data()}, pass);
  for (std::size_t i = 0; i < 4; ++i) CHECK(pass.output(0)[i] == -static_cast<double>(i + 1));
}

TEST_CASE("DeformConv looks up at moved places, 0 outside, as a loop does", "[nn][network][operators]") {
  constexpr std::size_t channels = 4, high = 5, wide = 4, filters = 2, groups = 2, points = 6;  // 2 x 3
  constexpr std::size_t rows = 3, columns = 2;
  const std::size_t offset_groups = GENERATE(std::size_t{1}, std::size_t{2});
  const bool has_mask = GENERATE(false, true);
  CAPTURE(offset_groups, has_mask);
  const TestOperand x = given({1, channels, high, wide}, 1), w = weight({filters, 2, 2, 3}, 2),
                    b = weight({filters}, 4);
  TestOperand moves = given({1, offset_groups * points * 2, rows, columns}, 3),
              mask = given({1, offset_groups * points, rows, columns}, 5);
  for (double& move : moves.values) move *= 1.7;
  const std::int64_t stride = 2, pad = 1, dilation = 1;
  const auto pixel = [&](std::size_t c, double row, double column) {
    if (row < 0 || column < 0 || row >= high || column >= wide) return 0.0;
    return x.values[(c * high + static_cast<std::size_t>(row)) * wide + static_cast<std::size_t>(column)];
  };
  Numbers expected;
  for (std::size_t f = 0; f < filters; ++f)
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j) {
        double sum = b.values[f];
        for (std::size_t c = 0; c < channels / groups; ++c)
          for (std::size_t k = 0; k < points; ++k) {
            const std::size_t channel = f / (filters / groups) * (channels / groups) + c;
            const std::size_t point = channel / (channels / offset_groups) * points + k;
            const auto at = [&](std::size_t plane) { return (plane * rows + i) * columns + j; };
            const double y = double(std::int64_t(i) * stride - pad + std::int64_t(k / 3) * dilation) +
                             moves.values[at(2 * point)];
            const double z = double(std::int64_t(j) * stride - pad + std::int64_t(k % 3) * dilation) +
                             moves.values[at(2 * point + 1)];
            const double top = std::floor(y), left = std::floor(z), down = y - top, right = z - left;
            const double value =
                (1 - down) *
                    ((1 - right) * pixel(channel, top, left) + right * pixel(channel, top, left + 1)) +
                down *
                    ((1 - right) * pixel(channel, top + 1, left) + right * pixel(channel, top + 1, left + 1));
            sum += w.values[(f * 2 + c) * points + k] * value * (has_mask ? mask.values[at(point)] : 1);
          }
        expected.push_back(sum);
      }
  std::vector<TestOperand> operands{x, w, moves, b};
  if (has_mask) operands.push_back(mask);
  check(network_of("DeformConv", std::move(operands),
                   {{"group", std::int64_t(groups)},
                    {"offset_group", std::int64_t(offset_groups)},
                    {"strides", Ints{stride, stride}},
                    {"pads", Ints{pad, pad, pad, pad}}}),
        expected);
}

TEST_CASE("Compress takes slices where a condition holds", "[nn][network][operators]") {
  const TestOperand x = given({3, 2}, 1);
  const auto [axis, condition, places] =
      GENERATE(std::tuple(0, Numbers{0, 1, 1}, std::vector<std::size_t>{2, 3, 4, 5}),
               std::tuple(1, Numbers{0, 1}, std::vector<std::size_t>{1, 3, 5}),
               std::tuple(-2, Numbers{1}, std::vector<std::size_t>{0, 1}),
               std::tuple(7, Numbers{0, 1, 0, 0, 1}, std::vector<std::size_t>{1, 4}));
  CAPTURE(axis);
  Numbers expected;
  for (const std::size_t place : places) expected.push_back(x.values[place]);
  std::map<std::string, nn::Attribute> attributes;
  if (axis != 7) attributes["axis"] = std::int64_t(axis);
  check(network_of("Compress", {x, numbers(condition, nn::ElementType::boolean)}, attributes), expected);
}

TEST_CASE("losses of class probabilities are those of a loop", "[nn][network][operators]") {
  const std::string reduction = GENERATE("none", "sum", "mean");
  const bool has_weights = GENERATE(false, true), ignores = GENERATE(false, true);
  const char* const operation = GENERATE("NegativeLogLikelihoodLoss", "SoftmaxCrossEntropyLoss");
  CAPTURE(reduction, has_weights, ignores, operation);
  const TestOperand x = given({2, 3, 2}, 1), weights = given({3}, 2);
  TestOperand classes = numbers({0, 2, 1, 2});
  classes.shape = {2, 2};
  Numbers losses, counts;
  for (std::size_t n = 0; n < 2; ++n)
    for (std::size_t i = 0; i < 2; ++i) {
      const auto score = [&](std::size_t c) { return x.values[(n * 3 + c) * 2 + i]; };
      const auto own = static_cast<std::size_t>(classes.values[2 * n + i]);
      const double all = std::exp(score(0)) + std::exp(score(1)) + std::exp(score(2));
      const bool is_softmax = std::string(operation) == "SoftmaxCrossEntropyLoss";
      const double weight = ignores && own == 2 ? 0 : has_weights ? weights.values[own] : 1;
      losses.push_back(-weight * (is_softmax ? score(own) - std::log(all) : score(own)));
      counts.push_back(weight);
    }
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < losses.size(); ++i) {
    sum += losses[i];
    count += counts[i];
  }
  std::vector<TestOperand> operands{x, classes};
  if (has_weights) operands.push_back(weights);
  std::map<std::string, nn::Attribute> attributes{{"reduction", reduction}};
  if (ignores) attributes["ignore_index"] = std::int64_t(2);
  check(network_of(operation, std::move(operands), attributes),
        reduction == "none" ? losses : Numbers{reduction == "sum" ? sum : sum / count});
}
