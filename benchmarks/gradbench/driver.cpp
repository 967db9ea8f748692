// gradbench: speed and error of the tape on GradBench's programs, beside CoDiPack, Adept and derivatives by
// hand

#include <tapestry/core/random.hpp>

#include "../support/driver.hpp"
#include "../support/relative_distance.hpp"

namespace tapestry::benchmarks {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

/// Arrays of numbers that are drawn in turn.
class Draw {
 public:
  [[nodiscard]] json list(std::size_t count, double low = -1, double high = 1) {
    json numbers = json::array();
    while (numbers.size() < count) numbers.push_back(random_.uniform(low, high));
    return numbers;
  }
  [[nodiscard]] json table(std::size_t rows, std::size_t columns, double low = -1, double high = 1) {
    json all = json::array();
    while (all.size() < rows) all.push_back(list(columns, low, high));
    return all;
  }

 private:
  Random random_{1};
};

using Sizes = std::array<std::size_t, 2>;

[[nodiscard]] json gmm_input(Draw& draw, const Sizes& sizes) {
  const auto [d, k] = sizes;
  return {{"d", d},
          {"k", k},
          {"n", 1000},
          {"alpha", draw.list(k)},
          {"mu", draw.table(k, d)},
          {"q", draw.table(k, d)},
          {"l", draw.table(k, d * (d - 1) / 2)},
          {"x", draw.table(1000, d)},
          {"gamma", 1.0},
          {"m", 0}};
}

[[nodiscard]] json lstm_input(Draw& draw, const Sizes& sizes) {
  const auto [layers, characters] = sizes;
  return {{"main_params", draw.table(2 * layers, 4 * 14)},
          {"extra_params", draw.table(3, 14)},
          {"state", draw.table(2 * layers, 14)},
          {"sequence", draw.table(characters, 14, 0, 1)}};
}

[[nodiscard]] json ba_input(Draw& draw, const Sizes& sizes) {
  const auto [cameras, points] = sizes;
  return {{"n", cameras},
          {"m", points},
          {"p", 4 * points},
          {"cam", draw.list(11, 0.1, 0.5)},
          {"x", draw.list(3, 1, 2)},
          {"w", 0.7},
          {"feat", draw.list(2)}};
}

/// A hand of so many bones and points, the simple objective.
[[nodiscard]] json ht_input(Draw& draw, const Sizes& sizes) {
  const auto [bones, points] = sizes;
  json names, parents, relatives, absolutes, nearest;
  for (std::size_t i = 0; i < bones; ++i) {
    names.push_back("bone " + std::to_string(i));
    parents.push_back(static_cast<int>(i) - 1);
    for (json* const transforms : {&relatives, &absolutes}) {
      transforms->push_back(draw.table(3, 4, -0.5, 0.5));
      transforms->back().push_back({0, 0, 0, 1});
    }
  }
  json positions = draw.table(points, 3);
  for (std::size_t i = 0; i < points; ++i) {
    nearest.push_back(i * 7 % points);
    positions[i].push_back(1);
  }
  const json model{{"bone_names", names},
                   {"parents", parents},
                   {"is_mirrored", false},
                   {"base_positions", positions},
                   {"weights", draw.table(points, bones)},
                   {"triangles", json::array()},
                   {"base_relatives", relatives},
                   {"inverse_base_absolutes", absolutes}};
  return {{"theta", draw.list(26)},
          {"us", json::array()},
          {"data", {{"correspondences", nearest}, {"points", draw.table(points, 3)}, {"model", model}}}};
}

[[nodiscard]] json kmeans_input(Draw& draw, const Sizes& sizes) {
  return {{"points", draw.table(sizes[0], 16)}, {"centroids", draw.table(sizes[1], 16)}};
}

/// One evaluation: its name, the function of its programs, the sizes of its cases, and their inputs.
struct Evaluation {
  std::string name;
  std::string function;
  std::vector<Sizes> cases;
  std::function<json(Draw&, const Sizes&)> input;
};

[[nodiscard]] std::vector<Evaluation> evaluations() {
  return {{"hello", "double", {{1, 1}}, [](Draw&, const Sizes&) { return json(1.5); }},
          {"gmm", "jacobian", {{10, 25}, {64, 10}, {2, 200}}, gmm_input},
          {"lstm", "jacobian", {{2, 1024}, {4, 4096}}, lstm_input},
          {"ba", "jacobian", {{21, 5000}}, ba_input},
          {"ht", "jacobian", {{22, 500}}, ht_input},
          {"kmeans", "dir", {{2000, 20}}, kmeans_input},
          {"ode",
           "gradient",
           {{20, 50}, {200, 50}},
           [](Draw& draw, const Sizes& sizes) {
             return json{{"x", draw.list(sizes[0], 0.5, 1)}, {"s", sizes[1]}};
           }},
          {"llsq",
           "gradient",
           {{64, 4096}, {512, 1024}},
           [](Draw& draw, const Sizes& sizes) {
             return json{{"x", draw.list(sizes[0])}, {"n", sizes[1]}};
           }},
          {"det",
           "gradient",
           {{7, 7}, {9, 9}},
           [](Draw& draw, const Sizes& sizes) {
             return json{{"A", draw.list(sizes[0] * sizes[0])}, {"ell", sizes[0]}};
           }},
          {"lse", "gradient", {{1000, 1}, {1000000, 1}}, [](Draw& draw, const Sizes& sizes) {
             return json{{"x", draw.list(sizes[0], -5, 5)}};
           }}};
}

/// Whose programs, and the name of their variant. The last is what errors are measured by, or the one before.
using Tool = std::pair<const char*, const char*>;
constexpr std::array<Tool, 4> tools{Tool{"tapestry", "tape"}, Tool{"adept", "peer:Adept"},
                                    Tool{"manual", "peer:by hand"}, Tool{"codipack", "peer:CoDiPack"}};

/// All numbers of an answer, in order.
void append_numbers(const json& answer, std::vector<double>& numbers) {
  if (answer.is_number()) numbers.push_back(answer.get<double>());
  if (answer.is_structured())
    for (const json& part : answer) append_numbers(part, numbers);
}

/// Runs a program once. Adds the seconds of its evaluations, and replaces the answer.
void run_program(Contestant& contestant, const std::vector<std::string>& command, const fs::path& log,
                 std::vector<double>& answer) {
  if (!fs::exists(command.front())) throw Error(ErrorKind::usage, "not built");
  const ProcessCost cost = Process(command, {}, log).wait();
  if (!cost.succeeded) throw Error(ErrorKind::malformed, last_line(log));
  contestant.peak_memory_mib = cost.peak_memory_mib;
  std::ifstream lines(log);
  std::string line;
  std::getline(lines, line);
  answer.clear();
  append_numbers(json::parse(line), answer);
  while (std::getline(lines, line))
    if (const json entry = json::parse(line); entry.at("name") == "evaluate")
      contestant.seconds.push_back(1e-9 * entry.at("nanoseconds").get<double>());
}

[[nodiscard]] std::vector<Contestant> measure(const Evaluation& evaluation, const std::string& case_name,
                                              const Folders& folders, const Schedule& schedule) {
  std::vector<Contestant> contestants;
  std::vector<std::vector<double>> answers(tools.size());
  for (const auto& tool : tools) contestants.push_back({{case_name, tool.second}});
  for (int round = 0; round < schedule.rounds; ++round)
    for (std::size_t i = 0; i < tools.size(); ++i)
      contestants[i].attempt([&] {
        const std::string program = std::string("gradbench_") + tools[i].first + "_" + evaluation.name;
        run_program(contestants[i],
                    {folders.programs / program, folders.work / case_name, evaluation.function},
                    folders.work / program, answers[i]);
      });
  const std::size_t reference = contestants.back().failure.empty() ? tools.size() - 1 : tools.size() - 2;
  for (std::size_t i = 0; i < tools.size(); ++i)  // by hand, ode is that of the exact solution
    contestants[i].attempt(
        [&] { contestants[i].conclude(relative_distance(answers[i], answers[reference]), 1e-2); });
  return contestants;
}

void print(const std::string& case_name, const std::vector<Contestant>& contestants) {
  std::printf("\n%s\n  %-16s %9s %8s %9s %6s  %s\n", case_name.c_str(), "", "ms", "spread", "error", "MiB",
              "ours over it");
  const Result& own = contestants.front().result;
  for (const Contestant& contestant : contestants) {
    const Result& result = contestant.result;
    if (contestant.print(result.variant, 16))
      std::printf(" %9.4f %6.1f %% %9.1e %6.0f  %s\n", 1e3 * *result.seconds, 100 * *result.spread,
                  *result.error, *result.memory_mib,
                  own.seconds ? formatted("%.2f", *own.seconds / *result.seconds).c_str() : "");
  }
  std::fflush(stdout);
}

void run(const DriverOptions& options) {
  const Folders folders = make_folders("gradbench", options.output);
  std::vector<Result> results;
  for (const Evaluation& evaluation : evaluations())
    for (const Sizes& sizes : evaluation.cases) {
      const std::string name =
          evaluation.name + "_" + std::to_string(sizes[0]) + "_" + std::to_string(sizes[1]);
      if (!options.takes(name)) continue;
      Draw draw;
      json input = evaluation.input(draw, sizes);
      if (input.is_object()) input.update({{"min_runs", 3}, {"min_seconds", options.schedule.seconds}});
      io::write_file_atomically(folders.work / name, std::string_view(input.dump()));
      const std::vector<Contestant> contestants = measure(evaluation, name, folders, options.schedule);
      print(name, contestants);
      add_results(contestants, results);
    }
  write_results(folders, "gradbench", "", results, {}, 1);
}
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  auto app = tapestry::shell::command_line(
      "Runs the programs of GradBench on our tape, on CoDiPack's and Adept's, and with derivatives written "
      "by hand, in turn. Build it with the CMake variables TAPESTRY_GRADBENCH and TAPESTRY_CODIPACK, their "
      "checkouts. Writes gradbench.csv.");
  benchmarks::DriverOptions options;
  benchmarks::add_driver_options(app, options, "3 rounds of 0.1 s", {3, 0.1});
  return benchmarks::run_driver(app, argc, argv, [&] { benchmarks::run(options); });
}
