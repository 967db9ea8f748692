// bits                prints the bits of values and derivatives: a line a name, a place and numbers
// bits FIRST SECOND   compares two such outputs, for tests/reach.sh: names each operation whose bits differ,
// and how
//                     many units in the last place lie between them. Ends with 1 if the tape's own arithmetic
//                     differs.
#include <tapestry/autodiff.hpp>

#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>

#include "function_rows.hpp"

namespace {
using First = tapestry::Dual<double>;
using Second = tapestry::Dual<First>;
using Third = tapestry::Dual<Second>;

constexpr int places = 48;

void print(const std::string& name, int place, const std::vector<double>& values) {
  std::printf("%s %d", name.c_str(), place);
  for (const double value : values)
    std::printf(" %016" PRIx64,
                std::isnan(value) ? ~std::uint64_t{0} : __builtin_bit_cast(std::uint64_t, value));
  std::printf("\n");
}

/// The value and three derivatives by dual numbers, and the gradient by the tape.
template <class Function>
void print_function(const std::string& name, int place, double x, const Function& f) {
  const Third y = f(Third::input(Second::input(First::input(x))));
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto input = tape.input(x);
  tape.reverse(f(input));
  print(name, place,
        {y.value().value().value(), y.tangent().value().value(), y.tangent().tangent().value(),
         y.tangent().tangent().tangent(), input.adjoint()});
}

template <class T, class Program>
void print_gradient(const std::string& name, const Program& program) {
  tapestry::Tape<T> tape;
  const auto scope = tape.activate();
  std::vector<tapestry::Variable<T>> inputs;
  for (int i = 0; i < 24; ++i) inputs.push_back(tape.input(T(1 + 7 * i % 24) / T(16)));
  const auto y = program(inputs);
  tape.reverse(y);
  std::vector<double> values{static_cast<double>(y.value())};
  for (const auto& input : inputs) values.push_back(static_cast<double>(input.adjoint()));
  print(name, 0, values);
}

template <class T>
void print_programs(const std::string& type) {
  print_gradient<T>("arithmetic" + type, [](const auto& x) {  // no function of the C library but sqrt
    tapestry::Variable<T> sum = x[0] * x[1] - x[2] / x[3];
    for (std::size_t step = 0; step < 400; ++step) {
      const auto &a = x[step % 24], &b = x[(5 * step + 3) % 24];
      sum = sqrt(square(sum) + a * b + T(0.25)) - a / (b + T(2)) + fabs(sum - a) * T(0.125);
    }
    return sum;
  });
  print_gradient<T>("network" + type, [](const auto& x) {
    tapestry::Variable<T> sum = x[0] * T(0.5);
    for (std::size_t layer = 0; layer < 20; ++layer) {
      tapestry::Variable<T> inner = x[layer] * T(0.75);
      for (std::size_t i = 0; i < 24; ++i) inner += tanh(x[i] * sum - x[(i + layer) % 24]);
      sum = softplus(inner * T(0.0625)) + exp(-square(sum));
    }
    return sum;
  });
}

void print_all() {
  tapestry::test::for_each_function([](const tapestry::test::FunctionRow& row, const auto& f) {
    for (int k = 1; k < places; ++k) {
      const double t = k / double(places), most = 64;  // near 0, where functions bend
      const double low = std::fmax(row.low, -most), high = std::fmin(row.high, most);
      print_function(row.name, k, low + (high - low) * t, f);
    }
  });
  for (int k = 1; k < places; ++k) {
    const double x = k / 8.0;
    print_function("pow", k, x, [](const auto& v) { return pow(v, 2.5 - v / 4); });
    print_function("atan2", k, x - 3, [](const auto& v) { return atan2(v, 2 - v); });
    print_function("hypot", k, x - 3, [](const auto& v) { return hypot(v, v + 1); });
    print_function("logsumexp", k, x, [](const auto& v) { return logsumexp(v, 3 - v); });
    print_function("arithmetic", k, x,
                   [](const auto& v) { return (v * v - 3 / v) / sqrt(v + 2) * fabs(v - 2); });
  }
  print_programs<double>("");
  print_programs<float>("_float");
}

using Output = std::map<std::string, std::vector<std::uint64_t>>;
Output read(const char* path) {
  Output output;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string name, word;
    words >> name >> word;
    while (words >> word) output[name].push_back(std::stoull(word, nullptr, 16));
  }
  return output;
}

/// Order of numbers as whole numbers, so that neighbours differ by 1.
std::uint64_t order(std::uint64_t bits) {
  constexpr auto sign = std::uint64_t{1} << 63U;
  return bits >= sign ? sign - (bits - sign) : bits + sign;
}

int compare(const Output& first, const Output& second) {
  if (first.empty() || first.size() != second.size()) return 2;
  bool is_sound = true;
  for (const auto& [name, bits] : first) {
    const auto other = second.find(name);
    if (other == second.end() || other->second.size() != bits.size()) return 2;
    int differ = 0;
    double most = 0;
    for (std::size_t i = 0; i < bits.size(); ++i) {
      const auto [low, high] = std::minmax({order(bits[i]), order(other->second[i])});
      const auto distance = static_cast<double>(high - low);
      differ += bits[i] != other->second[i] ? 1 : 0;
      most = std::fmax(most, name.ends_with("_float") ? distance / 0x1p29 : distance);
    }
    if (differ > 0)
      std::printf("  %s: %d of %zu numbers, %.0f ulp\n", name.c_str(), differ, bits.size(), most);
    if (differ > 0 && name.starts_with("arithmetic")) is_sound = false;
  }
  return is_sound ? 0 : 1;
}
}  // namespace

int main(int argc, char** argv) {
  if (argc == 3) return compare(read(argv[1]), read(argv[2]));
  print_all();
  return 0;
}
