#include <tapestry/geometry/point_columns.hpp>

#include <random>

#include "../support/catch.hpp"

using tapestry::geometry::orientation, tapestry::geometry::Vector2;

TEST_CASE("orientation tells left, right and straight", "[geometry][orientation]") {
  CHECK(orientation({0, 0}, {1, 0}, {0, 1}) == 1);
  CHECK(orientation({0, 0}, {0, 1}, {1, 0}) == -1);
  CHECK(orientation({0, 0}, {1, 1}, {3, 3}) == 0);
  CHECK(orientation({2, 2}, {2, 2}, {7, -3}) == 0);
}

TEST_CASE("orientation is exact one unit in the last place beside a line", "[geometry][orientation]") {
  const double step = std::numeric_limits<double>::epsilon();
  for (int row = 0; row < 32; ++row) {
    for (int column = 0; column < 32; ++column) {  // the points of figure 4 of Kettner et al. (2008)
      const Vector2 near{0.5 + row * step / 2, 0.5 + column * step / 2};
      const int expected = row == column ? 0 : row < column ? 1 : -1;  // above or below the diagonal y = x
      CHECK(orientation({12, 12}, {24, 24}, near) == expected);
      CHECK(orientation({24, 24}, near, {12, 12}) == expected);
      CHECK(orientation({24, 24}, {12, 12}, near) == -expected);
    }
  }
}

TEST_CASE("orientation agrees with whole numbers of 128 bits", "[geometry][orientation]") {
  std::mt19937_64 draw(1);
  const auto whole = [&] { return static_cast<std::int64_t>(draw() >> 11U) - (std::int64_t(1) << 52U); };
  for (int repeat = 0; repeat < 2000; ++repeat) {
    const std::int64_t x = whole() / 4, y = whole() / 4, dx = whole() / 1024, dy = whole() / 1024;
    const std::int64_t factor = static_cast<std::int64_t>(draw() % 7) - 3;
    const std::int64_t off = static_cast<std::int64_t>(draw() % 3) - 1;  // the third point beside the line
    __extension__ using Wide = __int128;
    const std::int64_t cx = x + factor * dx, cy = y + factor * dy + off;
    const Wide area = Wide(dx) * (cy - y) - Wide(dy) * (cx - x);
    const auto point = [](std::int64_t u, std::int64_t v) {
      return Vector2{static_cast<double>(u), static_cast<double>(v)};
    };
    const int expected = area > 0 ? 1 : area < 0 ? -1 : 0;
    for (const double scale : {1.0, 0x1p-300, 0x1p200}) {
      auto a = point(x, y), b = point(x + dx, y + dy), c = point(cx, cy);
      for (Vector2* p : {&a, &b, &c})
        for (double& value : *p) value *= scale;
      REQUIRE(orientation(a, b, c) == expected);
    }
  }
}
