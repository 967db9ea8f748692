#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::benchmarks {
/// A source file that a compiler is timed on.
struct Program {
  std::string name;
  std::filesystem::path source;
  bool is_quick = false;  ///< one of those that --quick takes
  bool is_peer = false;   ///< left out where its library is not installed
};

/// The C++ blocks of a page behind `opening`, one after the other.
[[nodiscard]] inline std::string page_program(const std::filesystem::path& page, const std::string& opening) {
  const std::string text = io::read_text_file(page.string());
  std::string program;
  for (std::size_t at = text.find(opening); at != std::string::npos; at = text.find(opening, at)) {
    at += opening.size();
    const std::size_t end = text.find("```", at);
    program += text.substr(at, end - at);
    at = end;
  }
  return program;
}

/// An expression of a few operations, whose type no other of the file is likely to have.
[[nodiscard]] inline std::string random_formula(Random& random, std::size_t variable_count, int depth) {
  if (depth == 0) return "v[" + std::to_string(random.index(variable_count)) + "]";
  const char* const functions[] = {"sin", "exp", "sqrt", "tanh", "log"};
  const char* const operators[] = {" + ", " - ", " * ", " / "};
  const auto part = [&] {
    const bool is_leaf_sooner = depth > 1 && random.chance(0.5);
    return random_formula(random, variable_count, depth - (is_leaf_sooner ? 2 : 1));
  };
  if (random.chance(0.3)) {
    const std::string function = functions[random.index(std::size(functions))];
    return function + "(" + part() + ")";
  }
  const std::string left = part(), between = operators[random.index(std::size(operators))];
  return "(" + left + between + part() + ")";
}

/// A function of `count` formulas, one a line.
/// \param header  that defines Number's library
/// \param number  the type of the formulas' numbers
[[nodiscard]] inline std::string formulas(const std::string& header, const std::string& number,
                                          std::size_t count) {
  Random random(1);
  constexpr std::size_t variable_count = 8;
  std::string text = "#include <" + header + ">\n\nusing Number = " + number + ";\n\n";
  text += "void formulas(Number (&v)[" + std::to_string(variable_count) + "]) {\n";
  for (std::size_t i = 0; i < count; ++i)
    text += "  v[" + std::to_string(i % variable_count) + "] = " + random_formula(random, variable_count, 3) +
            ";\n";
  return text + "}\n";
}

/// All programs; those that no file holds are written into `work`.
[[nodiscard]] inline std::vector<Program> all_programs(const std::filesystem::path& sources,
                                                       const std::filesystem::path& work) {
  const auto written = [&](const std::string& name, const std::string& text) {
    io::write_file_atomically((work / name).string(), std::string_view(text));
    return work / name;
  };
  const std::filesystem::path own = sources / "benchmarks/compile/programs", peers = own / "../peers";
  constexpr std::size_t formula_count = 100;
  return {
      {"autodiff, six lines", own / "six_lines.cpp", true},
      {"README.md", written("readme.cpp",
                            page_program(sources / "README.md", "<!-- compiled by the tests -->\n```cpp\n"))},
      {"autodiff, 100 formulas",
       written("formulas.cpp",
               formulas("tapestry/autodiff.hpp", "tapestry::Variable<double>", formula_count))},
      {"docs/TUTORIAL.md", written("tutorial.cpp", page_program(sources / "docs/TUTORIAL.md", "```cpp\n"))},
      {"tour/input_gradient.cpp", sources / "examples/tour/input_gradient.cpp", true},
      {"tour/paint_a_car.cpp", sources / "examples/tour/paint_a_car.cpp"},
      {"an ONNX detector", own / "onnx_detector.cpp"},
      {"programs/camouflage.cpp", sources / "examples/programs/camouflage.cpp"},
      {"tapestry/tapestry.hpp alone", written("umbrella.cpp", "#include <tapestry/tapestry.hpp>\n")},
      {"implementation alone", written("implementation.cpp", "#include <tapestry/implementation.hpp>\n")},
      {"CoDiPack, six lines", peers / "codipack_six_lines.cpp", false, true},
      {"CoDiPack, 100 formulas",
       written("codipack_formulas.cpp", formulas("codi.hpp", "codi::RealReverse", formula_count)), false,
       true},
      {"Eigen/Dense, a product", peers / "eigen.cpp", false, true},
      {"xtensor, a sum", peers / "xtensor.cpp", false, true},
  };
}
}  // namespace tapestry::benchmarks
