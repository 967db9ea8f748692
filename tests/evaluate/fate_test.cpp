#include <tapestry/evaluate/detail/fate.hpp>

#include "../support/catch.hpp"

namespace evaluate = tapestry::evaluate;
using evaluate::Fate, tapestry::detect::Detection;

namespace {
const tapestry::loss::Target car{2, {50, 50, 20, 10}};

/// A detection beside the car: shifted by a share of its width, the IoU is (1 − shift) / (1 + shift).
Detection detection(std::size_t class_index, double confidence, double shift) {
  return {class_index, confidence, confidence, {50 + 20 * shift, 50, 20, 10}, 0, 0};
}
}  // namespace

TEST_CASE("the fate of a car is the best thing that a detection says of it", "[evaluate][fate]") {
  const std::vector<std::size_t> related{5, 7};
  const auto fate = [&](const std::vector<Detection>& detections) {
    return evaluate::outcome_of(detections, car, related);
  };
  CHECK(fate({}) == evaluate::ViewOutcome{});
  CHECK(fate({detection(2, 0.9, 0.25)}) == evaluate::ViewOutcome{Fate::found, 2, 0.9});
  CHECK(fate({detection(9, 0.9, 0), detection(2, 0.3, 0.2)}).fate == Fate::found);
  CHECK(fate({detection(9, 0.9, 0), detection(7, 0.3, 0.2)}) == evaluate::ViewOutcome{Fate::related, 7, 0.3});
  CHECK(fate({detection(9, 0.4, 0), detection(4, 0.6, 0.1), detection(8, 0.5, 0)}) ==
        evaluate::ViewOutcome{Fate::renamed, 4, 0.6});
  CHECK(fate({detection(9, 0.4, 0), detection(2, 0.9, 0.5)}).fate == Fate::renamed);
  CHECK(fate({detection(2, 0.9, 0.5)}) == evaluate::ViewOutcome{Fate::misplaced, 2, 0.9});
  CHECK(fate({detection(9, 0.9, 0.5), detection(7, 0.8, 0.5)}).fate == Fate::lost);
}

TEST_CASE("bounds of a fate are met exactly", "[evaluate][fate]") {
  const auto fate = [&](double width) {  // a box of that part of the car has that IoU
    return evaluate::outcome_of({{2, 0.5, 0.5, {50, 50, 20 * width, 10}, 0, 0}}, car, {}).fate;
  };
  CHECK(fate(0.5) == Fate::found);
  CHECK(fate(0.4999) == Fate::misplaced);
  CHECK(fate(0.1000001) == Fate::misplaced);
  CHECK(fate(0.0999) == Fate::lost);
}

TEST_CASE("classes like a car are found by their names", "[evaluate][fate]") {
  const std::vector<std::string> names{"person", "car", "umbrella", "bus", "train", "truck"};
  CHECK(evaluate::related_classes(names, 1) == std::vector<std::size_t>{3, 4, 5});
  CHECK(evaluate::related_classes(names, 3) == std::vector<std::size_t>{1, 4, 5});
  CHECK(evaluate::related_classes(names, 2).empty());
  CHECK(evaluate::related_classes({}, 2).empty());
}

TEST_CASE("fates are counted, and the new names with them", "[evaluate][fate]") {
  const std::vector<evaluate::ViewOutcome> outcomes{{Fate::found, 2, 0.9},   {Fate::renamed, 9, 0.5},
                                                    {Fate::renamed, 4, 0.5}, {Fate::lost, 0, 0},
                                                    {Fate::renamed, 9, 0.4}, {Fate::renamed, 3, 0.4}};
  const auto counts = evaluate::fate_counts(outcomes);
  CHECK(counts.all() == 6);
  CHECK(counts.of(Fate::found) == 1);
  CHECK(counts.of(Fate::renamed) == 4);
  CHECK(counts.of(Fate::lost) == 1);
  CHECK(counts.of(Fate::related) == 0);
  CHECK(counts.commonest_names(2) == std::vector<std::size_t>{9, 3});
  CHECK(counts.commonest_names(9) == std::vector<std::size_t>{9, 3, 4});
  CHECK(evaluate::fate_counts({}).all() == 0);
}
