#pragma once
#include <cctype>
#include <iomanip>
#include <random>
#include <sstream>
#include "scalar_steps.hpp"

namespace tapestry::test {
inline constexpr std::size_t input_count = 4;
using Point = std::array<double, input_count>;

/// A random straight line of operations on four inputs. Register i is an input, or the result of instruction
/// i − 4; the last one is the program's result.
class ScalarProgram {
 public:
  /// A program and a point. At the point, and at all points given by `around`, operands fit and results are
  /// at most 20.
  template <class Around>
  ScalarProgram(std::uint64_t seed, const Around& around) {
    std::mt19937_64 random(seed);
    for (double& entry : point) entry = static_cast<double>(random() >> 11U) * 0x1p-51 - 2;  // of [-2, 2)
    std::vector<std::vector<Wide>> registers;
    for (const Point& at : around(point)) registers.emplace_back(at.begin(), at.end());
    const std::size_t length = 2 + random() % 24;
    for (std::size_t attempt = 0; attempt < 40 * length && instructions.size() < length; ++attempt)
      try_instruction(random, registers);
  }

  /// Instructions [begin, end) on registers of any scalars, which grow.
  template <class S>
  void run(std::vector<S>& registers, std::size_t begin, std::size_t end) const {
    for (std::size_t i = begin; i < end; ++i) {
      const Instruction& step = instructions[i];
      registers.push_back(steps::all<S>()[step.operation].run(
          registers[step.operands[0]], registers[step.operands[1]], registers[step.operands[2]]));
    }
  }
  template <class S>
  [[nodiscard]] S operator()(std::span<const S> inputs) const {
    std::vector<S> registers(inputs.begin(), inputs.end());
    run(registers, 0, instructions.size());
    return registers.back();
  }

  /// The program and its point in C++.
  [[nodiscard]] std::string text() const {
    std::ostringstream out;
    out << std::setprecision(17) << "const std::array<double, 4> point = {";
    for (std::size_t i = 0; i < input_count; ++i) out << (i == 0 ? "" : ", ") << point[i];
    out << "};\nconst auto f = []<class S>(std::span<const S> x) {\n";
    for (std::size_t i = 0; i < input_count; ++i) out << "  const S r" << i << " = x[" << i << "];\n";
    for (std::size_t i = 0; i < instructions.size(); ++i)
      out << "  const S r" << i + input_count << " = " << text_of(instructions[i]) << ";\n";
    out << "  return r" << input_count + instructions.size() - 1 << ";\n};\n";
    return out.str();
  }

  [[nodiscard]] std::size_t size() const { return instructions.size(); }

  Point point{};

 private:
  struct Instruction {
    std::size_t operation;
    std::array<std::size_t, 3> operands;
  };

  void try_instruction(std::mt19937_64& random, std::vector<std::vector<Wide>>& registers) {
    const auto table = steps::all<Wide>();
    const std::size_t count = registers.front().size();
    Instruction next{static_cast<std::size_t>(random() % table.size()), {}};
    for (std::size_t& operand : next.operands)  // late ones more often: else most of a program has no effect
      operand = static_cast<std::size_t>(
          random() % 2 == 0 ? count - 1 - random() % std::min<std::size_t>(count, 3) : random() % count);
    std::vector<Wide> results;
    for (const auto& at : registers) {
      const Wide a = at[next.operands[0]], b = at[next.operands[1]], c = at[next.operands[2]];
      if (!table[next.operation].fits(a, b, c)) return;
      results.push_back(table[next.operation].run(a, b, c));
      if (!(std::abs(results.back()) <= 20)) return;
    }
    for (std::size_t i = 0; i < results.size(); ++i) registers[i].push_back(results[i]);
    instructions.push_back(next);
  }

  /// The operation's text with its operands for the letters a, b and c that stand alone.
  static std::string text_of(const Instruction& step) {
    const std::string pattern = steps::all<Wide>()[step.operation].text;
    std::string text;
    const auto is_name = [](char letter) { return std::isalnum(static_cast<unsigned char>(letter)) != 0; };
    for (std::size_t i = 0; i < pattern.size(); ++i) {
      const bool stands_alone =
          (i == 0 || !is_name(pattern[i - 1])) && (i + 1 == pattern.size() || !is_name(pattern[i + 1]));
      if (stands_alone && pattern[i] >= 'a' && pattern[i] <= 'c')
        text += "r" + std::to_string(step.operands[static_cast<std::size_t>(pattern[i] - 'a')]);
      else
        text += pattern[i];
    }
    return text;
  }

  std::vector<Instruction> instructions;
};
}  // namespace tapestry::test
