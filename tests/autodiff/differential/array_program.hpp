#pragma once
#include <cctype>
#include <iomanip>
#include <random>
#include <sstream>
#include "array_steps.hpp"

namespace tapestry::test {
/// A random straight line of operations on two arrays of two axes and a scalar. Its result is the sum of the
/// last array, with weights, and of the last scalar.
class ArrayProgram {
 public:
  using Wide = WideArray::Wide;
  using A = ArrayVariable<double, 2>;
  using V = Variable<double>;

  /// The starting point, or a direction there.
  struct Point {
    std::array<Array<double, 2>, 2> arrays;
    double scalar = 0;
  };

  /// \param steps  of directions[0] and so on; also there operands fit and results are at most 20
  ArrayProgram(std::uint64_t seed, double step) {
    std::mt19937_64 random(seed);
    const auto extent = [&] { return random() % 200 == 0 ? 260 + random() % 40 : 1 + random() % 4; };
    const std::size_t rows = extent(), columns = extent();
    point =
        point_of(random, {rows, columns}, {random() % 2 == 0 ? rows : 1, random() % 2 == 0 ? columns : 1});
    for (Point& direction : directions)
      direction = point_of(random, point.arrays[0].shape(), point.arrays[1].shape());
    std::vector<Registers> places = {registers_at(directions[0], 0)};
    for (const Point& direction : directions)
      for (const double s : {-step, step}) places.push_back(registers_at(direction, static_cast<Wide>(s)));
    const std::size_t length = 1 + random() % 10;
    for (std::size_t attempt = 0; attempt < 60 * length && instructions_.size() < length; ++attempt)
      try_instruction(random, places);
    const WideArray& last = places.front().arrays.back();
    weights_ = Array<double, 2>(Extents<2>{last.rows, last.columns});
    for (double& weight : weights_.storage()) weight = number(random) / static_cast<double>(weights_.size());
  }

  /// Its value a step from the point along a direction, by plain loops.
  [[nodiscard]] Wide reference(const Point& direction, Wide step) const {
    Registers all = registers_at(direction, step);
    for (const Instruction& next : instructions_) {
      const WideArray& a = all.arrays[next.a];
      const Wide s = all.scalars[next.s];
      if (next.is_reduction)
        all.scalars.push_back(array_steps::reductions()[next.operation].reference(a, s));
      else
        all.arrays.push_back(array_steps::all()[next.operation].reference(a, all.arrays[next.b], s));
    }
    Wide total = all.scalars.back();
    for (std::size_t i = 0; i < weights_.size(); ++i)
      total += static_cast<Wide>(weights_.data()[i]) * all.arrays.back().elements[i];
    return total;
  }

  /// The same at the point, on the tape.
  [[nodiscard]] V operator()(const std::array<A, 2>& arrays, const V& scalar) const {
    std::vector<A> all(arrays.begin(), arrays.end());
    std::vector<V> scalars = {scalar};
    for (const Instruction& next : instructions_) {
      if (next.is_reduction)
        scalars.push_back(array_steps::reductions()[next.operation].run(all[next.a], scalars[next.s]));
      else
        all.push_back(array_steps::all()[next.operation].run(all[next.a], all[next.b], scalars[next.s]));
    }
    return sum(all.back() * weights_) + scalars.back();
  }

  [[nodiscard]] std::string text() const {
    std::ostringstream out;
    out << std::setprecision(17);
    for (std::size_t k = 0; k < 2; ++k) {
      const Array<double, 2>& x = point.arrays[k];
      out << "const auto a" << k << " = tape.input(Array<double, 2>{";
      for (std::size_t i = 0; i < x.shape(0); ++i) {
        out << (i == 0 ? "{" : ", {");
        for (std::size_t j = 0; j < x.shape(1); ++j) out << (j == 0 ? "" : ", ") << x(i, j);
        out << "}";
      }
      out << "});\n";
    }
    out << "const auto s0 = tape.input(" << point.scalar << ");\n";
    std::size_t arrays = 2, scalars = 1;
    for (const Instruction& next : instructions_) {
      const char* const pattern = next.is_reduction ? array_steps::reductions()[next.operation].text
                                                    : array_steps::all()[next.operation].text;
      out << (next.is_reduction ? "const Variable<double> s" : "const ArrayVariable<double, 2> a")
          << (next.is_reduction ? scalars++ : arrays++) << " = " << text_of(pattern, next) << ";\n";
    }
    return out.str();
  }

  Point point;
  std::array<Point, 2> directions;

 private:
  struct Instruction {
    bool is_reduction;
    std::size_t operation, a, b, s;
  };
  struct Registers {
    std::vector<WideArray> arrays;
    std::vector<Wide> scalars;
  };

  /// A number in [−2, 2).
  static double number(std::mt19937_64& random) { return static_cast<double>(random() >> 11U) * 0x1p-51 - 2; }
  static Point point_of(std::mt19937_64& random, const Extents<2>& first, const Extents<2>& second) {
    Point result{{Array<double, 2>(first), Array<double, 2>(second)}, number(random)};
    for (Array<double, 2>& array : result.arrays)
      for (double& element : array.storage()) element = number(random);
    return result;
  }

  [[nodiscard]] Registers registers_at(const Point& direction, Wide step) const {
    Registers all;
    for (std::size_t k = 0; k < 2; ++k) {
      const Array<double, 2>&x = point.arrays[k], &d = direction.arrays[k];
      all.arrays.push_back(WideArray::of(x.shape(0), x.shape(1), [&](std::size_t i, std::size_t j) {
        return static_cast<Wide>(x(i, j)) + step * static_cast<Wide>(d(i, j));
      }));
    }
    all.scalars.push_back(static_cast<Wide>(point.scalar) + step * static_cast<Wide>(direction.scalar));
    return all;
  }

  void try_instruction(std::mt19937_64& random, std::vector<Registers>& places) {
    const std::size_t arrays = places.front().arrays.size(), scalars = places.front().scalars.size();
    const auto late = [&](std::size_t n) { return random() % 2 == 0 ? n - 1 : std::size_t(random() % n); };
    Instruction next{random() % 4 == 0, 0, late(arrays), late(arrays), late(scalars)};
    next.operation =
        random() % (next.is_reduction ? array_steps::reductions().size() : array_steps::all().size());
    std::vector<WideArray> results;
    std::vector<Wide> numbers;
    for (const Registers& at : places) {
      const WideArray &a = at.arrays[next.a], &b = at.arrays[next.b];
      const Wide s = at.scalars[next.s];
      const auto is_fit = [](Wide x) { return std::abs(x) <= 20; };
      if (next.is_reduction) {
        const ReductionStep& step = array_steps::reductions()[next.operation];
        if (!step.fits(a, s)) return;
        numbers.push_back(step.reference(a, s));
        if (!is_fit(numbers.back())) return;
      } else {
        const ArrayStep& step = array_steps::all()[next.operation];
        if (!step.fits(a, b, s)) return;
        results.push_back(step.reference(a, b, s));
        if (!results.back().all(is_fit)) return;
      }
    }
    for (std::size_t i = 0; i < results.size(); ++i) places[i].arrays.push_back(std::move(results[i]));
    for (std::size_t i = 0; i < numbers.size(); ++i) places[i].scalars.push_back(numbers[i]);
    instructions_.push_back(next);
  }

  /// The operation's text with its operands for the letters a, b and s that stand alone.
  static std::string text_of(const std::string& pattern, const Instruction& next) {
    std::string text;
    const auto is_name = [](char letter) { return std::isalnum(static_cast<unsigned char>(letter)) != 0; };
    for (std::size_t i = 0; i < pattern.size(); ++i) {
      text += pattern[i];
      if ((i > 0 && is_name(pattern[i - 1])) || (i + 1 < pattern.size() && is_name(pattern[i + 1]))) continue;
      if (pattern[i] == 'a') text += std::to_string(next.a);
      if (pattern[i] == 's') text += std::to_string(next.s);
      if (pattern[i] == 'b') {
        text.back() = 'a';
        text += std::to_string(next.b);
      }
    }
    return text;
  }

  std::vector<Instruction> instructions_;
  Array<double, 2> weights_;
};
}  // namespace tapestry::test
