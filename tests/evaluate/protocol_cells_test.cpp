#include <tapestry/evaluate/protocol_cells.hpp>

#include "../support/catch.hpp"

namespace evaluate = tapestry::evaluate;
using evaluate::FrameState;

namespace {
/// Outcomes of some frames, some measured, some left out, some pending.
evaluate::ProtocolOutcomes random_outcomes(std::size_t frames, std::size_t textures) {
  tapestry::Random random(11);
  evaluate::ProtocolOutcomes outcomes(frames, textures);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    outcomes.state(frame) = static_cast<std::uint8_t>(random.chance(0.8)   ? FrameState::measured
                                                      : random.chance(0.5) ? FrameState::left_out
                                                                           : FrameState::pending);
    if (outcomes.state_of(frame) != FrameState::measured) continue;
    outcomes.hidden_share(frame) = random.uniform();
    for (std::size_t k = 0; k < textures; ++k) {
      outcomes.found(frame, k) = random.chance(k == 0 ? 0.9 : 0.4) ? 1 : 0;
      outcomes.best_confidence(frame, k) = random.uniform();
    }
  }
  return outcomes;
}

/// One cell a frame list: found with the clean texture, and with the other.
evaluate::Cell cell_of(const std::vector<std::pair<bool, bool>>& found) {
  evaluate::ProtocolOutcomes outcomes(found.size(), 2);
  for (std::size_t i = 0; i < found.size(); ++i) {
    outcomes.state(i) = static_cast<std::uint8_t>(FrameState::measured);
    outcomes.found(i, 0) = found[i].first ? 1 : 0;
    outcomes.found(i, 1) = found[i].second ? 1 : 0;
  }
  return evaluate::cell_of(outcomes, [](std::size_t) { return true; });
}
}  // namespace

TEST_CASE("a cell counts what was found, lost and left out", "[evaluate][cells]") {
  evaluate::ProtocolOutcomes outcomes(6, 2);
  const std::vector<FrameState> states{FrameState::measured, FrameState::measured, FrameState::measured,
                                       FrameState::left_out, FrameState::pending,  FrameState::measured};
  for (std::size_t i = 0; i < 6; ++i) outcomes.state(i) = static_cast<std::uint8_t>(states[i]);
  outcomes.found(0, 0) = outcomes.found(1, 0) = outcomes.found(5, 0) = 1;
  outcomes.found(1, 1) = outcomes.found(2, 1) =
      1;  // found painted where the clean car is lost counts for P@0.5
  outcomes.best_confidence(0, 1) = 0.5;
  outcomes.best_confidence(1, 1) = 1;
  outcomes.hidden_share(2) = 0.4;
  const auto cell = evaluate::cell_of(outcomes, [](std::size_t frame) { return frame < 5; });
  CHECK(cell.measured == 3);
  CHECK(cell.left_out == 1);
  CHECK(cell.textures[0].rate.detected == 2);
  CHECK(cell.textures[0].success.hidden == 0);
  CHECK(cell.textures[1].rate.detected == 2);
  CHECK(cell.textures[1].success.views == 2);
  CHECK(cell.textures[1].success.hidden == 1);
  CHECK(cell.textures[1].success.rate == 0.5);
  CHECK(cell.textures[1].success.interval == evaluate::wilson_interval(1, 2));
  CHECK(cell.textures[1].mean_best_confidence == 0.5);
  CHECK(cell.mean_hidden_share == Approx(0.4 / 3));
}

TEST_CASE("the cells of a table add up to the whole", "[evaluate][cells]") {
  const evaluate::ViewGrid grid{{1.5, 3}, {0, 10}, 15};
  const auto table = evaluate::view_table(grid);
  const auto frames = evaluate::view_frames(grid);
  const auto outcomes = random_outcomes(frames.size(), 3);
  const auto cells = evaluate::cells_of(table, frames, outcomes);
  const auto whole = evaluate::cell_of(outcomes, [](std::size_t) { return true; });
  REQUIRE(cells.size() == 16);
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t measured = 0, left_out = 0, detected = 0, views = 0, hidden = 0;
    double confidence = 0;
    for (const auto& cell : cells) {
      measured += cell.measured;
      left_out += cell.left_out;
      detected += cell.textures[k].rate.detected;
      views += cell.textures[k].success.views;
      hidden += cell.textures[k].success.hidden;
      confidence += cell.textures[k].mean_best_confidence * static_cast<double>(cell.measured);
    }
    CHECK(measured == whole.measured);
    CHECK(left_out == whole.left_out);
    CHECK(detected == whole.textures[k].rate.detected);
    CHECK(views == whole.textures[0].rate.detected);
    CHECK(hidden == whole.textures[k].success.hidden);
    CHECK(confidence == Approx(whole.textures[k].mean_best_confidence * static_cast<double>(measured)));
  }
  CHECK(whole.measured < frames.size());
  CHECK(whole.left_out > 0);
}

TEST_CASE("a view that was photographed twice counts once in intervals", "[evaluate][cells]") {
  const evaluate::ProtocolTable table{"row", {"twice", "once"}, "column", {"all"}, {2}};
  std::vector<evaluate::ProtocolFrame> frames(60);
  for (std::size_t i = 40; i < 60; ++i) frames[i].row = 1;
  auto outcomes = random_outcomes(60, 3);
  for (std::size_t i = 0; i < 60; ++i) {
    outcomes.state(i) = static_cast<std::uint8_t>(FrameState::measured);
    if (i % 2 == 1 && i < 40)  // a second photograph with the first one's result
      for (std::size_t k = 0; k < 3; ++k) {
        outcomes.found(i, k) = outcomes.found(i - 1, k);
        outcomes.best_confidence(i, k) = outcomes.best_confidence(i - 1, k);
        outcomes.found_confidence(i, k) = outcomes.found_confidence(i - 1, k);
      }
  }
  const auto cells = evaluate::cells_of(table, frames, outcomes);
  const auto first = [](std::size_t i) { return i < 40 && i % 2 == 0; };  // as if there were no second
  const auto twice = [](std::size_t i) { return i < 40; };
  const auto alone = evaluate::cell_of(outcomes, first);
  CHECK(cells[0].measured == 40);
  CHECK(cells[0].textures[1].rate.detected == 2 * alone.textures[1].rate.detected);
  for (std::size_t end = 0; end < 2; ++end) {
    CHECK(cells[0].textures[1].rate.interval[end] == Approx(alone.textures[1].rate.interval[end]));
    CHECK(cells[0].textures[1].success.interval[end] == Approx(alone.textures[1].success.interval[end]));
    CHECK(evaluate::sweep_of(outcomes, 1, {0.5}, twice, 2)[0].interval[end] ==
          Approx(evaluate::sweep_of(outcomes, 1, {0.5}, first)[0].interval[end]));
  }
  CHECK(cells[1].textures[1].rate.interval ==
        evaluate::wilson_interval(cells[1].textures[1].rate.detected, 20));
  const auto effect = evaluate::effect_of(outcomes, "control", 2, 1, twice, 2);
  const auto of_first = evaluate::effect_of(outcomes, "control", 2, 1, first);
  CHECK(effect.best_confidence.pairs == 20);
  CHECK(effect.best_confidence.mean == Approx(of_first.best_confidence.mean));
  CHECK(effect.best_confidence.interval[0] == Approx(of_first.best_confidence.interval[0]));
  CHECK_THROWS_WITH(evaluate::effect_of(outcomes, "control", 2, 1, twice, 3),
                    "view_means: 40 pictures are not 3 of each view");
}

TEST_CASE("draws of a control are further pictures of a view", "[evaluate][cells]") {
  // Clean, the camouflage, three draws of noise; two frames. Found: clean in both, the camouflage in none,
  // the noise in one draw of the first frame and in three of the second.
  evaluate::ProtocolOutcomes outcomes(2, 5);
  outcomes.draws = {1, 1, 3};
  const double confidence[2][5] = {{0.9, 0.1, 0.2, 0.3, 0.1}, {0.8, 0.2, 0.4, 0.6, 0.1}};
  const int found[2][5] = {{1, 0, 0, 1, 0}, {1, 0, 1, 1, 1}};
  for (std::size_t i = 0; i < 2; ++i) {
    outcomes.state(i) = static_cast<std::uint8_t>(FrameState::measured);
    for (std::size_t k = 0; k < 5; ++k) {
      outcomes.best_confidence(i, k) = outcomes.found_confidence(i, k) = confidence[i][k];
      outcomes.found(i, k) = static_cast<std::uint8_t>(found[i][k]);
      outcomes.fate(i, k) =
          static_cast<std::uint8_t>(found[i][k] == 1 ? evaluate::Fate::found : evaluate::Fate::lost);
    }
  }
  const auto all = [](std::size_t) { return true; };
  CHECK(outcomes.texture_count() == 3);
  CHECK(outcomes.first_column(2) == 2);
  CHECK(evaluate::measured_values(outcomes, outcomes.best_confidence, 2, all) ==
        std::vector<double>{0.2, 0.3, 0.1, 0.4, 0.6, 0.1});
  const auto cell = evaluate::cell_of(outcomes, all);
  REQUIRE(cell.textures.size() == 3);
  CHECK(cell.textures[2].rate.detected == 4);
  CHECK(cell.textures[2].rate.views == 6);
  const evaluate::PictureOrder draws{1, 3};
  CHECK(cell.textures[2].rate.interval ==
        evaluate::detection_rate({false, true, false, true, true, true}, draws).interval);
  CHECK(cell.textures[2].mean_best_confidence == Approx(1.7 / 6));
  CHECK(cell.textures[2].success.hidden == 2);
  CHECK(cell.textures[2].success.views == 6);
  CHECK(cell.textures[2].fates.of(evaluate::Fate::lost) == 2);
  const auto differences = evaluate::draw_differences(outcomes, outcomes.best_confidence, 2, 1, all);
  const double expected[3][2] = {{0.1, 0.2}, {0.2, 0.4}, {0, -0.1}};
  for (std::size_t draw = 0; draw < 3; ++draw)
    for (std::size_t view = 0; view < 2; ++view)
      CHECK(differences(draw, view) == Approx(expected[draw][view]).margin(1e-15));
  const auto effect = evaluate::effect_of(outcomes, "noise", 2, 1, all);
  CHECK(effect.best_confidence.mean == Approx(0.8 / 6));
  CHECK(effect.best_confidence.interval == evaluate::two_level_difference(differences).interval);
  CHECK(effect.p_at_50.mean == Approx(4.0 / 6));
  CHECK(effect.draws == 3);
  CHECK(effect.draws_at_most == 1);
  CHECK(evaluate::sweep_of(outcomes, 2, {0.25}, all)[0].detected == 3);
  CHECK_THROWS_WITH(evaluate::effect_of(outcomes, "noise", 1, 2, all),
                    "effect_of: a texture of several draws");
  outcomes.draws = {1, 1, 4};
  CHECK_THROWS_WITH(evaluate::cell_of(outcomes, all), "measured_values: draws up to column 6 of 5");
}

TEST_CASE("draws that are all the same give the figures of one", "[evaluate][cells]") {
  const auto one = random_outcomes(60, 3);
  evaluate::ProtocolOutcomes several(60, 5);
  several.state = one.state;
  several.draws = {1, 1, 3};
  for (std::size_t i = 0; i < 60; ++i)
    for (std::size_t k = 0; k < 5; ++k) {
      several.found(i, k) = one.found(i, std::min<std::size_t>(k, 2));
      several.best_confidence(i, k) = one.best_confidence(i, std::min<std::size_t>(k, 2));
    }
  const auto all = [](std::size_t) { return true; };
  const auto of_one = evaluate::cell_of(one, all), of_several = evaluate::cell_of(several, all);
  CHECK(of_several.textures[2].rate.p_at_50 == Approx(of_one.textures[2].rate.p_at_50));
  const auto effect = evaluate::effect_of(several, "noise", 2, 1, all),
             effect_of_one = evaluate::effect_of(one, "noise", 2, 1, all);
  CHECK(effect.best_confidence.mean == Approx(effect_of_one.best_confidence.mean));
  for (const std::size_t end : {0U, 1U}) {
    CHECK(of_several.textures[2].rate.interval[end] == Approx(of_one.textures[2].rate.interval[end]));
    CHECK(effect.p_at_50.interval[end] == Approx(effect_of_one.p_at_50.interval[end]));
  }
}

TEST_CASE("what is kept of an effect is a ratio over the views of both", "[evaluate][cells]") {
  // 12 views: two photographs of each, with the control .1 and .3 above the texture, and then the view itself
  // with .8 in one half and .4 in the other: ⅓ is kept.
  evaluate::ProtocolOutcomes outcomes(36, 3);
  for (std::size_t i = 0; i < 36; ++i) {
    outcomes.state(i) = static_cast<std::uint8_t>(FrameState::measured);
    outcomes.best_confidence(i, 1) = 0.1;
    outcomes.best_confidence(i, 2) = i % 3 == 0 ? 0.2 : i % 3 == 1 ? 0.4 : i / 3 % 2 == 0 ? 0.9 : 0.5;
  }
  const auto photographed = [](std::size_t i) { return i % 3 != 2; };
  const auto as_it_is = [](std::size_t i) { return i % 3 == 2; };
  const auto kept = evaluate::effect_kept(outcomes, 2, 1, photographed, 2, as_it_is);
  REQUIRE(kept);
  CHECK(kept->ratio == Approx(1.0 / 3));
  CHECK(kept->interval[0] > 0.24);
  CHECK(kept->interval[0] < 1.0 / 3);
  CHECK(kept->interval[1] > 1.0 / 3);
  CHECK(kept->interval[1] < 0.51);
  CHECK_FALSE(evaluate::effect_kept(outcomes, 1, 2, photographed, 2, as_it_is));  // it helps the detector
  outcomes.state(2) = static_cast<std::uint8_t>(FrameState::left_out);
  CHECK_FALSE(evaluate::effect_kept(outcomes, 2, 1, photographed, 2, as_it_is));
}

TEST_CASE("an effect and a sweep are of the measured frames that belong", "[evaluate][cells]") {
  auto outcomes = random_outcomes(60, 3);
  for (std::size_t i = 0; i < outcomes.found_confidence.size(); ++i)
    outcomes.found_confidence.data()[i] = 0.9 * outcomes.best_confidence.data()[i];
  outcomes.found_confidence(0, 1) = 0.5;  // is above neither itself nor more
  outcomes.state(0) = static_cast<std::uint8_t>(FrameState::measured);
  const auto belongs = [](std::size_t frame) { return frame % 2 == 0; };
  double difference = 0, points = 0;
  std::size_t frames = 0, at_half = 0;
  for (std::size_t i = 0; i < 60; i += 2) {
    if (outcomes.state_of(i) != FrameState::measured) continue;
    ++frames;
    difference += outcomes.best_confidence(i, 2) - outcomes.best_confidence(i, 1);
    points += static_cast<double>(outcomes.found(i, 2)) - static_cast<double>(outcomes.found(i, 1));
    at_half += outcomes.found_confidence(i, 1) > 0.5 ? 1U : 0U;
  }
  const auto effect = evaluate::effect_of(outcomes, "control", 2, 1, belongs);
  CHECK(effect.control == "control");
  CHECK(effect.best_confidence.pairs == frames);
  CHECK(effect.best_confidence.mean == Approx(difference / static_cast<double>(frames)));
  CHECK(effect.p_at_50.mean == Approx(points / static_cast<double>(frames)));
  CHECK(effect.best_confidence.interval[0] < effect.best_confidence.mean);
  const auto sweep = evaluate::sweep_of(outcomes, 1, {0.5, 0.95}, belongs);
  REQUIRE(sweep.size() == 2);
  CHECK(sweep[0].views == frames);
  CHECK(sweep[0].detected == at_half);
  CHECK(sweep[1].detected == 0);
  double lost = 0;
  for (std::size_t i = 0; i < outcomes.attention.size(); ++i)
    outcomes.attention.data()[i] = outcomes.best_confidence.data()[i] / 2;
  for (std::size_t i = 0; i < 60; i += 2)
    if (outcomes.state_of(i) == FrameState::measured)
      lost += outcomes.attention(i, 0) - outcomes.attention(i, 1);
  CHECK(evaluate::attention_lost(outcomes, 1, belongs).mean == Approx(lost / static_cast<double>(frames)));
  CHECK(evaluate::attention_lost(outcomes, 0, belongs).interval == std::array<double, 2>{0.0, 0.0});
  CHECK_THROWS_WITH(evaluate::attention_lost(outcomes, 3, belongs), "measured_values: texture 3 of 3");
  CHECK(evaluate::sweep_of(evaluate::ProtocolOutcomes(3, 2), 1, {0.5}, belongs)[0].views == 0);
  CHECK_THROWS_AS(evaluate::sweep_of(outcomes, 3, {0.5}, belongs), tapestry::ShapeError);
  CHECK_THROWS_AS(evaluate::effect_of(outcomes, "control", 3, 1, belongs), tapestry::ShapeError);
}

TEST_CASE("a cell whose clean car is never found has no attack success", "[evaluate][cells]") {
  const auto cell = cell_of({{false, false}, {false, true}});
  CHECK(cell.textures[1].success.views == 0);
  CHECK(cell.textures[1].success.interval == std::array<double, 2>{0.0, 1.0});
  CHECK(cell.textures[1].rate.views == 2);
  const auto empty = cell_of({});
  CHECK(empty.measured == 0);
  CHECK(empty.textures[1].rate.views == 0);
  CHECK(empty.textures[1].mean_best_confidence == 0);
  CHECK(!evaluate::least_hidden_cell({cell, empty}, 1));
  CHECK(evaluate::least_found_cell({empty, cell}, 0) == std::size_t{1});
  CHECK(!evaluate::least_found_cell({empty}, 0));
}

TEST_CASE("the worst cell is where the camouflage hides least", "[evaluate][cells]") {
  const auto half = cell_of({{true, true}, {true, false}});
  const auto undefined = cell_of({{false, true}});
  const auto none_of_one = cell_of({{true, true}});
  const auto none_of_two = cell_of({{true, true}, {true, true}});
  CHECK(evaluate::least_hidden_cell({half, undefined, none_of_one}, 1) == std::size_t{2});
  CHECK(evaluate::least_hidden_cell({none_of_one, none_of_two, none_of_two}, 1) == std::size_t{1});
  CHECK(evaluate::least_found_cell({none_of_two, half, undefined}, 1) == std::size_t{1});
  // None of one hidden may be as many as 79 of 100; one of forty is at most 13.
  std::vector<std::pair<bool, bool>> many(40, {true, true});
  many[0].second = false;
  CHECK(evaluate::least_hidden_cell({none_of_one, cell_of(many)}, 1) == std::size_t{1});
}

TEST_CASE("outcomes that do not fit are refused", "[evaluate][cells]") {
  const evaluate::ViewGrid grid{{5}, {0}, 45};
  const auto table = evaluate::view_table(grid);
  auto frames = evaluate::view_frames(grid);
  CHECK_THROWS_AS(evaluate::cells_of(table, frames, random_outcomes(7, 2)), tapestry::ShapeError);
  frames[3].column = 1;
  CHECK_THROWS_WITH(evaluate::cells_of(table, frames, random_outcomes(8, 2)),
                    "cells_of: a frame is in row 3, column 1 of a table of 8 by 1");
  auto torn = random_outcomes(8, 2);
  torn.hidden_share = tapestry::zeros<double, 1>({7});
  CHECK_THROWS_AS(evaluate::cell_of(torn, [](std::size_t) { return true; }), tapestry::ShapeError);
  CHECK_THROWS_AS(evaluate::cell_of(random_outcomes(8, 0), [](std::size_t) { return true; }),
                  tapestry::ShapeError);
}

TEST_CASE("a cell counts what became of the car", "[evaluate][protocol]") {
  using evaluate::Fate;
  evaluate::ProtocolOutcomes outcomes(4, 1);
  const std::array fates{Fate::renamed, Fate::lost, Fate::renamed, Fate::found};
  for (std::size_t i = 0; i < fates.size(); ++i) {
    outcomes.state(i) = static_cast<std::uint8_t>(i == 2 ? FrameState::pending : FrameState::measured);
    outcomes.fate(i, 0) = static_cast<std::uint8_t>(fates[i]);
    outcomes.named(i, 0) = static_cast<std::uint16_t>(20 + i);
  }
  const auto cell = evaluate::cell_of(outcomes, [](std::size_t) { return true; });
  CHECK(cell.textures[0].fates.pictures == std::array<std::size_t, 5>{1, 0, 1, 0, 1});
  CHECK(cell.textures[0].fates.commonest_names(3) == std::vector<std::size_t>{20});
  outcomes.fate = tapestry::zeros<std::uint8_t, 2>({3, 1});
  CHECK_THROWS_AS(evaluate::cell_of(outcomes, [](std::size_t) { return true; }), tapestry::ShapeError);
}
