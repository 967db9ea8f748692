#include "../../examples/programs/shell/report.hpp"

#include "../support/catch.hpp"

namespace shell = tapestry::shell;
namespace evaluate = tapestry::evaluate;

namespace {
/// A car that is found in some of 80 views, misplaced in some of the others, else lost.
shell::FoundCar found_in(std::size_t count, std::size_t misplaced = 0, std::size_t views = 80) {
  std::vector<bool> found(views);
  std::fill_n(found.begin(), count, true);
  shell::FoundCar car{evaluate::detection_rate(found), {}};
  car.fates.pictures = {count, 0, 0, misplaced, views - count - misplaced};
  car.fates.renamed_to = {0, 0, 0};
  return car;
}

std::string verdict(std::size_t plain, std::size_t noise, shell::FoundCar paint, double low, double high) {
  shell::VerdictFigures figures{"held-out views", found_in(plain), std::move(paint), found_in(noise)};
  figures.beyond = evaluate::PairedDifference{80, (low + high) / 2, {low, high}};
  return shell::verdict_text(figures);
}
}  // namespace

TEST_CASE("a verdict has the counts and what they show", "[programs][verdict]") {
  CHECK(verdict(80, 77, found_in(4, 35), 0.8, 0.97) ==
        "Found in 4 of 80 held-out views with the paint, 77 with noise of the same colours, 80 plain: the "
        "design hides the car; lost in 41, misplaced in 35.");
  CHECK(verdict(80, 77, found_in(60), 0.1, 0.3)
            .ends_with("80 plain: the design hides the car in some views; lost in 20."));
  CHECK(verdict(80, 30, found_in(4), 0.2, 0.4)
            .ends_with("the design hides the car, beyond what its colours do; lost in 76."));
  CHECK(verdict(80, 5, found_in(4), -0.05, 0.07)
            .ends_with("the paint hides the car, and so does noise of the same colours: no effect on how "
                       "often it is found is shown; lost in 76."));
  CHECK(verdict(80, 79, found_in(80), -0.03, 0.01)
            .ends_with("80 plain: no effect on how often it is found is shown."));
  CHECK(verdict(80, 20, found_in(60), -0.6, -0.3)
            .ends_with("noise of the same colours hides the car better than the design; lost in 20."));
}

TEST_CASE("a verdict says what keeps it from being one", "[programs][verdict]") {
  auto plain = found_in(11);
  plain.fates.pictures = {11, 0, 60, 0, 9};
  plain.fates.renamed_to = {0, 50, 10};
  shell::VerdictFigures figures{"frames", plain, found_in(0), {}, {}, {"car", "airplane", "kite"}};
  CHECK(shell::verdict_text(figures) ==
        "No verdict: the plain car itself is found in 11 of 80 frames only: lost in 9, called something else "
        "in 60 (airplane 50, kite 10). Is --class right? Is --detector right?");
  figures.plain = found_in(11, 60);
  CHECK(shell::verdict_text(figures).ends_with(
      "found in 11 of 80 frames only: lost in 9, misplaced in 60. It needs no paint to be missed."));
  figures.plain = found_in(80);
  CHECK(shell::verdict_text(figures) ==
        "Found in 0 of 80 frames with the paint, 80 plain: the paint hides the car; whether its design does "
        "was not measured, for want of noise of the same colours; lost in 80.");
  figures.plain = found_in(0, 0, 0);
  CHECK(shell::verdict_text(figures).empty());
}

TEST_CASE("odds are written where they can be read", "[programs][verdict]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  CHECK(shell::odds_text({3.14159, {1.9, 5.25}}, " times") == "3.14 times [1.9, 5.25]");
  CHECK(shell::odds_text({376, {89.7, 1580}}) == "> 100 [89.7, > 100]");
  CHECK(shell::odds_text({0.002, {0, 0.3}}) == "< 0.01 [< 0.01, 0.3]");
  CHECK(shell::odds_text({1, {0.018, 55.6}}) == "-");
  CHECK(shell::odds_text({2, {0, infinity}}) == "-");
}

TEST_CASE("faults of JSON values are told in our words", "[programs][verdict]") {
  const auto fault = [](auto read) {
    try {
      read(nlohmann::ordered_json::parse(R"({"a": 1, "b": [1]})"));
    } catch (const std::exception& error) {
      return shell::json_fault(error.what());
    }
    return std::string("none");
  };
  CHECK(fault([](const auto& json) { (void)json.at("c"); }) == "no member 'c'");
  CHECK(fault([](const auto& json) { (void)json.at("a").template get<std::string>(); }) ==
        "expected string, found number");
  CHECK(fault([](const auto& json) { (void)json.at("b").at(3); }) ==
        "a value of another kind, or too few of them");
  CHECK(fault([](const auto& json) { (void)json.at("a").at("d"); }) ==
        "a value of another kind, or too few of them");
  CHECK(shell::json_fault("no such file").empty());
}
