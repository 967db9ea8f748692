#include <tapestry/loss/detail/box_assignment.hpp>

#include <map>

#include "../support/catch.hpp"
#include "../support/tiny_heads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using detect::DecodeFamily;

namespace {
using Logits = std::vector<Array<double, 4>>;
using Found = std::map<std::tuple<std::size_t, std::size_t, std::size_t>, std::size_t>;  // cell to truth

loss::DynamicMatches matches_of(const TinyHeads& detector, const Logits& logits, const loss::Truths& truths) {
  return loss::dynamic_matches(detector.heads(), loss::to_read(logits), truths, TinyHeads::input_height(),
                               TinyHeads::input_width());
}

/// The rule literally: the full table of costs, with plain probabilities, and minima sought one by one.
Found table_of_costs(const TinyHeads& detector, const Logits& logits,
                     const std::vector<loss::Target>& truths) {
  struct Cell {
    std::tuple<std::size_t, std::size_t, std::size_t> place;
    std::vector<double> cost, iou;
    std::vector<bool> is_open;
  };
  std::vector<Cell> cells;
  for (std::size_t h = 0; h < detector.heads().size(); ++h) {
    const auto& head = detector.heads()[h];
    const double stride =
        static_cast<double>(TinyHeads::input_width()) / static_cast<double>(head.grid_width);
    for (std::size_t row = 0; row < head.grid_height; ++row)
      for (std::size_t column = 0; column < head.grid_width; ++column) {
        const auto t = [&](std::size_t channel) { return logits[h](0, channel, row, column); };
        const auto share = [](double logit) { return 1 / (1 + std::exp(-logit)); };
        const double x = static_cast<double>(column), y = static_cast<double>(row);
        Cell cell{{h, row, column}, {}, {}, {}};
        detect::Box box{(x + t(0)) * stride, (y + t(1)) * stride, std::exp(t(2)) * stride,
                        std::exp(t(3)) * stride};
        std::size_t first_class = 5;
        if (head.decode == DecodeFamily::distance) {
          first_class = 32;
          double reach[4];
          for (std::size_t side = 0; side < 4; ++side) {
            double sum = 0, weighted = 0;
            for (std::size_t bin = 0; bin < 8; ++bin) {
              sum += std::exp(t(8 * side + bin));
              weighted += static_cast<double>(bin) * std::exp(t(8 * side + bin));
            }
            reach[side] = weighted / sum * stride;
          }
          const double cx = (x + 0.5) * stride, cy = (y + 0.5) * stride;
          box = detect::box_from_corners(cx - reach[0], cy - reach[1], cx + reach[2], cy + reach[3]);
        }
        for (const auto& truth : truths) {
          const double dx = std::abs((x + 0.5) * stride - truth.box.cx);
          const double dy = std::abs((y + 0.5) * stride - truth.box.cy);
          const bool inside = dx < truth.box.w / 2 && dy < truth.box.h / 2;
          const bool near = std::max(dx, dy) < 2.5 * stride;
          const double overlap = detect::iou(box, truth.box);
          double cost = -3 * std::log(overlap + 1e-8) + (inside && near ? 0 : 1e5);
          for (std::size_t k = 0; k < head.classes; ++k) {
            double p = share(t(first_class + k));
            if (head.decode != DecodeFamily::distance) p = std::sqrt(p * share(t(4)));
            cost -= std::log(k == truth.class_index ? p : 1 - p);
          }
          cell.cost.push_back(cost);
          cell.iou.push_back(overlap);
          cell.is_open.push_back((inside || near) && truth.box.w > 0 && truth.box.h > 0);
        }
        cells.push_back(cell);
      }
  }
  std::vector<std::vector<bool>> takes(cells.size(), std::vector<bool>(truths.size(), false));
  for (std::size_t i = 0; i < truths.size(); ++i) {
    std::vector<double> overlaps;
    for (const Cell& cell : cells)
      if (cell.is_open[i]) overlaps.push_back(cell.iou[i]);
    std::sort(overlaps.rbegin(), overlaps.rend());
    double sum = 0;
    for (std::size_t k = 0; k < std::min<std::size_t>(10, overlaps.size()); ++k) sum += overlaps[k];
    for (int left = std::max(1, static_cast<int>(sum)); left > 0; --left) {
      std::size_t best = cells.size();
      for (std::size_t c = 0; c < cells.size(); ++c)
        if (cells[c].is_open[i] && !takes[c][i] &&
            (best == cells.size() || cells[c].cost[i] < cells[best].cost[i]))
          best = c;
      if (best < cells.size()) takes[best][i] = true;
    }
  }
  Found found;
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (std::size_t i = 0; i < truths.size(); ++i)
      if (takes[c][i] &&
          (!found.contains(cells[c].place) || cells[c].cost[i] < cells[c].cost[found[cells[c].place]]))
        found[cells[c].place] = i;
  return found;
}
}  // namespace

TEST_CASE("dynamic_matches are those of the full table of costs", "[loss][dynamic_match]") {
  const TinyHeads detector(GENERATE(DecodeFamily::yolox, DecodeFamily::distance));
  std::size_t count = 0, shared = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Logits logits = detector.logits<double>(1, seed, -2, 2);
    Random random(seed);
    std::vector<loss::Target> truths;
    for (std::size_t i = 0; i < 1 + seed % 4; ++i)
      truths.push_back({random.index(3),
                        {random.uniform(-10, 106), random.uniform(-10, 74), random.uniform(2, 60),
                         random.uniform(2, 60)}});
    const auto matches = matches_of(detector, logits, {truths}).front();
    const Found expected = table_of_costs(detector, logits, truths);
    REQUIRE(matches.size() == expected.size());
    std::size_t i = 0;
    for (const auto& [place, truth] : expected) {
      const auto& match = matches[i++];
      CHECK(std::tuple(match.candidate.head, match.candidate.row, match.candidate.column) == place);
      CHECK(match.truth.box.cx == truths[truth].box.cx);
      CHECK(match.truth.class_index == truths[truth].class_index);
    }
    count += matches.size();
    std::size_t alone = 0;
    for (const auto& truth : truths) alone += matches_of(detector, logits, {{truth}}).front().size();
    shared += alone - matches.size();
  }
  CHECK(count > 80);  // more than one a picture
  CHECK(shared > 0);  // cells that more than one truth wants
}

TEST_CASE("a box smaller than a cell has a match near it", "[loss][dynamic_match]") {
  const TinyHeads detector(DecodeFamily::yolox);
  const auto matches = matches_of(detector, detector.flat_logits(), {{{1, {41, 30, 1, 2}}}}).front();
  REQUIRE(matches.size() == 1);
  CHECK(matches[0].candidate.head == 2);  // the box of the finest head, 8 × 8, has the largest share of it
}

TEST_CASE("two boxes on one cell: it has the one that costs less", "[loss][dynamic_match]") {
  const TinyHeads detector(DecodeFamily::yolox);
  auto logits = detector.flat_logits();
  logits[2](0, 5 + 1, 3, 5) = 3;  // the cell of x 40 to 48 and y 24 to 32 predicts class 1
  const loss::Target one{0, {40, 24, 9, 9}}, other{1, {40, 24, 9, 9}};  // logits 0: a cell's corner, 8 × 8
  for (const auto& truths : {std::vector{one, other}, std::vector{other, one}}) {
    const auto matches = matches_of(detector, logits, {truths}).front();
    const auto of_cell = std::ranges::find_if(matches, [](const loss::DynamicMatch& match) {
      return match.candidate == loss::Candidate{2, 0, 3, 5};
    });
    REQUIRE(of_cell != matches.end());
    CHECK(of_cell->truth.class_index == 1);
    CHECK(of_cell->iou == Approx(64.0 / 81));
  }
}

TEST_CASE("tied costs go to the first cell and the first truth", "[loss][dynamic_match]") {
  const TinyHeads detector(DecodeFamily::yolox);
  auto logits = detector.flat_logits();
  for (std::size_t h = 0; h < 2; ++h) {  // no box of the coarse heads meets the truth
    for (std::size_t i = 0; i < logits[h].size(); ++i) logits[h].data()[i] = 0;
    for (std::size_t row = 0; row < logits[h].shape(2); ++row)
      for (std::size_t column = 0; column < logits[h].shape(3); ++column) logits[h](0, 0, row, column) = 40;
  }
  // Boxes 8 × 8 about (40, 24) and (48, 24), the corners of two cells, share as much of a truth about (44,
  // 24).
  const loss::Target one{2, {44, 24, 20, 10}}, other{1, {44, 24, 20, 10}};  // all classes are as likely
  for (const auto& truths : {std::vector{one, other}, std::vector{other, one}}) {
    const auto matches = matches_of(detector, logits, {truths}).front();
    REQUIRE(matches.size() == 1);  // both truths want the same cell
    CHECK(matches[0].candidate == loss::Candidate{2, 0, 3, 5});
    CHECK(matches[0].truth.class_index == truths[0].class_index);
  }
}

TEST_CASE("boxes outside the picture or without area are left out, one that reaches in is not",
          "[loss][dynamic_match]") {
  const TinyHeads detector(DecodeFamily::yolox);
  const auto is_left_out = [&](const std::vector<loss::Target>& boxes) {
    return matches_of(detector, detector.flat_logits(), {boxes}).front().empty();
  };
  CHECK(is_left_out({}));
  CHECK(is_left_out({{0, {400, 400, 20, 20}}}));
  CHECK_FALSE(is_left_out({{0, {-5, 20, 60, 30}}}));
  CHECK(is_left_out({{0, {40, 24, 0, 20}}, {0, {40, 24, 20, -3}}}));
}

TEST_CASE("saturated logits still have finite costs", "[loss][dynamic_match]") {
  const TinyHeads detector(DecodeFamily::yolox);
  auto logits = detector.flat_logits();
  for (auto& head : logits)
    for (std::size_t i = 0; i < head.size(); ++i) head.data()[i] = i % 2 == 0 ? 1e4 : -1e4;
  const auto found = matches_of(detector, logits, {{{1, {40, 24, 20, 20}}}});
  CHECK_FALSE(found.front().empty());
  for (const double logit : {-1e308, -800.0, -40.0, 0.0, 40.0, 800.0, 1e308}) {
    const loss::detail::ClassCost cost(logit, logit);
    CHECK((cost.if_present >= 0 && cost.if_present <= 100));
    CHECK((cost.if_absent >= 0 && cost.if_absent <= 100));
  }
}

TEST_CASE("dynamic_matches refuses what it cannot match", "[loss][dynamic_match]") {
  const TinyHeads detector(DecodeFamily::yolox);
  auto logits = detector.flat_logits();
  CHECK_THROWS_AS(matches_of(detector, logits, {}), DomainError);
  CHECK_THROWS_AS(matches_of(detector, detector.logits<double>(2, 1), {{}}), ShapeError);
  CHECK_THROWS_WITH(matches_of(detector, logits, {{{3, {1, 1, 1, 1}}}}), "dynamic_matches: class 3 of 3");
  CHECK_THROWS_AS(matches_of(detector, logits, {{{0, {std::nan(""), 1, 1, 1}}}}), DomainError);
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    logits[1].data()[7] = value;
    CHECK_THROWS_AS(matches_of(detector, logits, {{}}), NumericError);
  }
  const TinyHeads anchored;
  CHECK_THROWS_WITH(
      matches_of(anchored, anchored.logits<double>(1, 1), {{}}),
      "dynamic_matches: heads of the decode family darknet, whose candidates are no cells without anchors; "
      "expected yolox or distance");
}
