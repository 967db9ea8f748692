// autodiff: speed, error and memory of gradients, our tape beside ADOL-C, plain code and adjoints by hand
#include <tapestry/autodiff.hpp>

#include "../support/driver.hpp"
#include "hand_adjoints.hpp"
#include "worker_program.hpp"
#if __has_include(<shared_objectives.hpp>)
#include <shared_objectives.hpp>
#endif

namespace tapestry::benchmarks {
namespace {
namespace fs = std::filesystem;

/// A program beside the driver, and its value of --variant.
struct Variant {
  std::string name, program;
  int threads = 1;              ///< that compute side by side; the seconds are of one of them
  double largest_error = 1e-6;  ///< beyond, it computes something else
  bool is_of_other_build = false;

  [[nodiscard]] std::string label() const { return name + (is_of_other_build ? " of other build" : ""); }
};
const std::vector<Variant> all_variants = {{"plain", "autodiff_tapestry"},
                                           {"hand", "autodiff_tapestry"},
                                           {"scalar", "autodiff_tapestry"},
                                           {"scalar", "autodiff_tapestry", 1, 1e-6, true},
                                           {"scalar", "autodiff_tapestry", 2},
                                           {"recording", "autodiff_tapestry"},
                                           {"recording", "autodiff_tapestry", 1, 1e-6, true},
                                           {"gradient-call", "autodiff_tapestry"},
                                           {"scalar-8-roots", "autodiff_tapestry"},
                                           {"scalar-8-roots", "autodiff_tapestry", 1, 1e-6, true},
                                           {"hessian-product", "autodiff_tapestry"},
                                           {"array", "autodiff_tapestry"},
                                           {"array-float", "autodiff_tapestry", 1, 1e-2},
                                           {"array-library-exp", "autodiff_tapestry"},
                                           {"naive-float", "autodiff_tapestry", 1, 1e-2},
                                           {"dual", "autodiff_tapestry"},
                                           {"compressed", "autodiff_tapestry"},
                                           {"peer:adolc", "autodiff_adolc"},
                                           {"peer:adolc-fresh", "autodiff_adolc"},
                                           {"peer:sacado", "autodiff_sacado"}};

/// Whether there is such a variant: long recurrences have no array form, Jacobians have other ways.
[[nodiscard]] bool applies(const Variant& variant, const std::string& objective) {
  const auto is_one_of = [](const std::string& name, std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const bool is_of_jacobians = is_one_of(variant.name, {"dual", "compressed"});
  if (objective == BundleJacobian::name)
    return is_of_jacobians || is_one_of(variant.name, {"plain", "hand", "peer:adolc-fresh"}) ||
           (variant.name == "scalar" && variant.threads == 1);
  if (variant.name == "peer:sacado" && objective == HandTracking::name) return false;  // see its worker
  if (objective == FloatSum::name) return is_one_of(variant.name, {"plain", "naive-float", "array-float"});
  if (variant.name == "naive-float") return false;
  if (variant.name == "array-library-exp") return objective == Softmax::name;
  if (variant.name.starts_with("array")) return !is_one_of(objective, {Speelpenning::name, Recurrence::name});
  return !is_of_jacobians;
}

/// Value and gradient in long double, by hand.
struct Reference {
  long double value = 0;
  std::vector<long double> gradient{};
};

template <class Objective>
[[nodiscard]] Reference reference_of(const Objective& objective) {
  const auto start = objective.start();
  const std::vector<long double> x(start.begin(), start.end());
  Reference reference{0, std::vector<long double>(entry_count(objective))};
  reference.value = hand_adjoint(objective, x.data(), reference.gradient.data());
  return reference;
}

/// Size of one recording on the tape.
struct TapeSize {
  std::size_t statements = 0, operands = 0, bytes = 0;
};

template <class Objective>
[[nodiscard]] TapeSize tape_size_of(const Objective& objective) {
  Tape<double> tape;
  const auto scope = tape.activate();
  std::vector<Variable<double>> inputs;
  for (const double x : objective.start()) inputs.push_back(tape.input(x));
  static_cast<void>(objective(inputs.data()));
  return {tape.statement_count(), tape.operand_count(), tape.statement_bytes()};
}

/// Relative error of a saved answer: of the gradient, in the L2 norm, or of a value alone.
[[nodiscard]] double error_of(const Reference& reference, const std::string& path) {
  const auto answer = read_numbers<double>(path);
  if (answer.size() == 1)
    return static_cast<double>(
        std::abs((static_cast<long double>(answer[0]) - reference.value) / reference.value));
  long double difference = 0, length = 0;
  for (std::size_t i = 0; i < reference.gradient.size(); ++i) {
    const long double error = static_cast<long double>(answer.at(i + 1)) - reference.gradient[i];
    difference += error * error;
    length += reference.gradient[i] * reference.gradient[i];
  }
  return static_cast<double>(std::sqrt(difference / length));
}

/// One objective under every variant.
struct Comparison {
  std::string name;
  TapeSize tape{};
  std::vector<Contestant> contestants{};
};

/// \param other_build  folder of the programs of another build, or empty
template <class Objective>
[[nodiscard]] Comparison compare(const Objective& objective, const Folders& folders, const Schedule& schedule,
                                 const fs::path& other_build) {
  Comparison comparison{objective.name, tape_size_of(objective)};
  std::vector<Variant> variants;
  std::cerr << objective.name << std::endl;
  for (const Variant& variant : all_variants) {
    const fs::path& programs = variant.is_of_other_build ? other_build : folders.programs;
    if (!applies(variant, objective.name) || programs.empty()) continue;
    variants.push_back(variant);
    comparison.contestants.push_back({{objective.name, variant.label(), variant.threads}});
    comparison.contestants.back().start({programs / variant.program, "--case", objective.name, "--variant",
                                         variant.name, "--threads", std::to_string(variant.threads)},
                                        {}, folders.work);
  }
  run_rounds(comparison.contestants, schedule);
  const Reference reference = reference_of(objective);
  const std::string path = folders.work / "answer";
  for (std::size_t i = 0; i < variants.size(); ++i) {
    Contestant& contestant = comparison.contestants[i];
    const int computations = variants[i].threads == 1 ? 1 : variants[i].threads * computations_a_wait;
    contestant.finish(path, [&] {
      contestant.conclude(error_of(reference, path), variants[i].largest_error, computations);
    });
  }
  fs::remove(path);
  return comparison;
}

/// Median seconds of a variant on one thread, or NaN.
[[nodiscard]] double seconds_of(const Comparison& comparison, const std::string& variant) {
  for (const auto& contestant : comparison.contestants)
    if (const Result& result = contestant.result; result.variant == variant && result.seconds)
      return *result.seconds;
  return std::nan("");
}

void print(const Comparison& comparison) {
  const double traced = seconds_of(comparison, "peer:adolc");
  const double adolc = std::isnan(traced) ? seconds_of(comparison, "peer:adolc-fresh") : traced;
  const auto statements = static_cast<double>(comparison.tape.statements);
  std::printf("\n%s: %.0f statements, %.2f operands and %.1f bytes of tape a statement\n",
              comparison.name.c_str(), statements, static_cast<double>(comparison.tape.operands) / statements,
              static_cast<double>(comparison.tape.bytes) / statements);
  std::printf("  %-18s %11s %8s %9s %8s %9s %9s %9s %13s\n", "", "ms", "spread", "error", "MiB", "/ plain",
              "/ hand", "/ scalar", "1 / of ADOL-C");
  for (const Contestant& contestant : comparison.contestants) {
    const Result& result = contestant.result;
    const std::string threads = result.threads > 1 ? ", " + thread_title(result.threads) : "";
    if (!contestant.print(result.variant + threads, 18)) continue;
    const double seconds = *result.seconds;
    std::printf(" %11.5f %6.1f %% %9.1e %8.0f %9.2f %9.2f %9.2f %13.2f\n", 1e3 * seconds,
                100 * *result.spread, *result.error, *result.memory_mib,
                seconds / seconds_of(comparison, "plain"), seconds / seconds_of(comparison, "hand"),
                seconds / seconds_of(comparison, "scalar"), adolc / seconds);
  }
  std::fflush(stdout);
}

/// Variants that compute the gradient alone, or the sum of floats.
[[nodiscard]] Panel panel_of(const Comparison& comparison) {
  const bool is_sum = comparison.name == FloatSum::name;
  Panel panel{comparison.name, is_sum ? "sums a second" : "gradients a second", {}, true};
  for (const Contestant& contestant : comparison.contestants) {
    const Result& result = contestant.result;
    const bool is_other = result.threads > 1 || result.variant == "scalar-8-roots" ||
                          result.variant == "recording" || result.variant.ends_with("other build") ||
                          result.variant == "hessian-product" || (result.variant == "plain" && !is_sum);
    if (result.seconds && !is_other) panel.points.push_back(point_of(result, 1e-19, 1 / *result.seconds));
  }
  return panel;
}

#if __has_include(<shared_objectives.hpp>)
/// \throws Error unless ours and the shared definition give the same value
template <class Ours, class Theirs>
void require_equal(const Ours& ours, const Theirs& theirs) {
  const auto x = ours.start();
  const double value = ours(x.data()), expected = theirs(x.data());
  if (x != theirs.x0() || !(std::abs(value - expected) <= 1e-12 * std::abs(expected)))
    throw Error(ErrorKind::mismatch, std::string(ours.name) + " is not what the shared definition computes");
}
void check_definitions() {
  require_equal(Gmm(), objectives::Gmm());
  require_equal(Softmax(), objectives::SoftmaxXent());
  require_equal(Iou(), objectives::IouLoss());
  require_equal(Smoothness(), objectives::Smoothness());
  require_equal(Project(), objectives::Project());
  require_equal(Speelpenning(), objectives::Speelpenning());
  require_equal(Recurrence(), objectives::LongLoop());
}
#else
void check_definitions() {}
#endif

void run(const DriverOptions& options, const std::string& other_build) {
  const Folders folders = make_folders("autodiff", options.output);
  const fs::path other = other_build.empty() ? fs::path() : fs::absolute(other_build);
  check_definitions();
  std::vector<Result> results;
  std::vector<Panel> panels;
  for_each_objective([&](const auto& objective) {
    if (!options.takes(objective.name)) return;
    const Comparison comparison = compare(objective, folders, options.schedule, other);
    print(comparison);
    add_results(comparison.contestants, results);
    panels.push_back(panel_of(comparison));
  });
  write_results(folders, "autodiff", "Gradients a second against error", results, panels, 3);
}
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  auto app = tapestry::shell::command_line(
      "Times value and gradient of objectives, by our tape and by other ways in turn, and compares gradients "
      "with long double. Writes autodiff.csv and autodiff.svg.");
  benchmarks::DriverOptions options;
  options.schedule = {9, 0.1};
  benchmarks::add_driver_options(app, options, "Few and short turns: 3 of 0.02 seconds where not given",
                                 {3, 0.02});
  std::string other_build;
  app.add_option(
         "--other-build", other_build,
         "Folder of the benchmarks of another build, such as an earlier commit's: its tape, its sweeps "
         "and its recording run in turn with ours")
      ->check(CLI::ExistingDirectory);
  return benchmarks::run_driver(app, argc, argv, [&] { benchmarks::run(options, other_build); });
}
