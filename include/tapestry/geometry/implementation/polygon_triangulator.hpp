#pragma once
#include <tapestry/geometry/polygon_triangulator.hpp>

namespace tapestry::geometry {
namespace detail {
/// A sum of doubles without rounding: no two of its terms overlap, the largest comes last.
/// Source: Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates
/// (1997), theorem 10 (adding one double) and theorem 18 (a product as two doubles).
class ExactSum {
 public:
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }

  /// −1, 0 or 1
  [[nodiscard]] int sign() const {
    for (std::size_t i = count_; i-- > 0;)
      if (terms_[i] != 0) return terms_[i] > 0 ? 1 : -1;
    return 0;
  }

 private:
  void add(double value) {
    for (std::size_t i = 0; i < count_; ++i) {
      const double sum = value + terms_[i];
      const double part = sum - value;
      terms_[i] = (value - (sum - part)) + (terms_[i] - part);
      value = sum;
    }
    terms_.at(count_++) = value;
  }

  std::array<double, 12> terms_{};  // terms of the six products of three points
  std::size_t count_ = 0;
};
}  // namespace detail

int orientation(const Vector2& a, const Vector2& b, const Vector2& c) {
  constexpr double unit = std::numeric_limits<double>::epsilon() / 2;
  const double left = (a[0] - c[0]) * (b[1] - c[1]);
  const double right = (a[1] - c[1]) * (b[0] - c[0]);
  const double bound = (3 + 16 * unit) * unit * (std::abs(left) + std::abs(right));
  if (left - right > bound) return 1;
  if (left - right < -bound) return -1;
  detail::ExactSum sum;
  for (const auto* const edge : {&a, &b, &c}) {
    const Vector2& next = edge == &a ? b : edge == &b ? c : a;
    sum.add_product((*edge)[0], next[1]);
    sum.add_product(-(*edge)[1], next[0]);
  }
  return sum.sign();
}

PolygonShape PolygonTriangulator::triangulate(std::span<const Vector3> corners) {
  triangles_.clear();
  flatten(corners);
  if (turns_one_way(1) || turns_one_way(-1)) return PolygonShape::fan;
  for (int attempt = 0; attempt < 2; ++attempt) {  // rounding may have mistaken the sense of the first
    if (clip_all()) return PolygonShape::concave;
    if (work_ == 0) return PolygonShape::intricate;
    for (auto& point : points_) std::swap(point[0], point[1]);
  }
  return PolygonShape::crossing;
}

void PolygonTriangulator::flatten(std::span<const Vector3> corners) {
  Vector3 area{}, size{};  // areas of the fan along each axis, with signs and without
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Vector3 part = cross(subtract(corners[i], corners[0]), subtract(corners[i + 1], corners[0]));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      area[axis] += part[axis];
      size[axis] += std::abs(part[axis]);
    }
  }
  const auto axis = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
  std::size_t right = (axis + 1) % 3;
  std::size_t up = (axis + 2) % 3;
  if (area[axis] < 0) std::swap(right, up);
  points_.clear();
  for (const Vector3& corner : corners) points_.push_back({corner[right], corner[up]});
}

bool PolygonTriangulator::turns_one_way(int sense) const {
  for (std::size_t i = 1; i + 1 < points_.size(); ++i)
    if (orientation(points_[0], points_[i], points_[i + 1]) * sense < 0) return false;
  return true;
}

bool PolygonTriangulator::clip_all() {
  begin();
  std::size_t corner = 1;
  std::size_t left = points_.size();
  std::size_t failures = 0;
  bool loose = false;
  while (left > 3) {
    if (is_ear(corner, loose)) {
      corner = clip(corner);
      --left;
      failures = 0;
      loose = false;
      continue;
    }
    if (work_ == 0) return false;
    corner = next_[corner];
    if (++failures <= left) continue;
    if (loose) return false;
    loose = true;
    failures = 0;
  }
  if (turn(corner) < 0) return false;
  triangles_.push_back({before_[corner], corner, next_[corner]});
  return true;
}

void PolygonTriangulator::begin() {
  const std::size_t count = points_.size();
  triangles_.clear();
  blockers_.clear();
  retired_ = 0;
  before_.resize(count);
  next_.resize(count);
  is_blocker_.assign(count, 0);
  is_listed_.assign(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    before_[i] = (i + count - 1) % count;
    next_[i] = (i + 1) % count;
  }
  for (std::size_t i = 0; i < count; ++i) classify(i);
  columns_.clear();
  if (blockers_.size() > few_blockers) columns_.build(points_);
}

void PolygonTriangulator::classify(std::size_t corner) {
  if (turn(corner) > 0) return retire(corner);
  is_blocker_[corner] = 1;
  if (is_listed_[corner] != 0) return;
  blockers_.push_back({points_[corner], corner});
  is_listed_[corner] = 1;
}

void PolygonTriangulator::retire(std::size_t corner) {
  if (is_blocker_[corner] == 0) return;
  is_blocker_[corner] = 0;
  if (++retired_ * 4 < blockers_.size()) return;
  retired_ = 0;
  std::erase_if(blockers_, [&](const Blocker& blocker) {
    is_listed_[blocker.corner] = is_blocker_[blocker.corner];
    return is_blocker_[blocker.corner] == 0;
  });
}

std::size_t PolygonTriangulator::clip(std::size_t corner) {
  const std::size_t before = before_[corner];
  const std::size_t next = next_[corner];
  triangles_.push_back({before, corner, next});
  next_[before] = next;
  before_[next] = before;
  retire(corner);
  classify(before);
  classify(next);
  return before;
}

bool PolygonTriangulator::is_ear(std::size_t corner, bool loose) {
  const Vector2& a = points_[before_[corner]];
  const Vector2& b = points_[corner];
  const Vector2& c = points_[next_[corner]];
  const int sense = orientation(a, b, c);
  work_ -= std::min<std::uint64_t>(work_, 1);
  if (sense < 0 || work_ == 0) return false;
  if (sense == 0) return loose || !lies_between(a, b, c);
  const auto blocks = [&](std::size_t other) {
    return is_blocker_[other] != 0 && other != before_[corner] && other != next_[corner] &&
           is_in_the_way(other, corner, loose);
  };
  if (columns_.size() == 0 || blockers_.size() <= columns_.size()) return !any_listed_in({a, b, c}, blocks);
  std::uint64_t steps = 0;
  const bool is_free = !columns_.any_in({a, b, c}, steps, blocks);
  work_ -= std::min(work_, steps);
  return is_free;
}

bool PolygonTriangulator::lies_between(const Vector2& a, const Vector2& b, const Vector2& c) {
  const auto within = [&](std::size_t axis) {
    return std::min(a[axis], c[axis]) <= b[axis] && b[axis] <= std::max(a[axis], c[axis]);
  };
  return b != a && b != c && within(0) && within(1);
}

bool PolygonTriangulator::is_in_the_way(std::size_t other, std::size_t corner, bool loose) const {
  const std::array<Vector2, 3> ear{points_[before_[corner]], points_[corner], points_[next_[corner]]};
  const auto side = [&](std::size_t point, std::size_t edge) {
    return orientation(ear[edge], ear[(edge + 1) % 3], points_[point]);
  };
  std::array<int, 3> sides{};
  for (const std::size_t edge : {2U, 0U, 1U}) {  // most corners lie beyond the new edge
    sides[edge] = side(other, edge);
    if (sides[edge] < 0) return false;
  }
  if (sides[0] > 0 && sides[1] > 0 && (sides[2] > 0 || !loose)) return true;
  for (const std::size_t neighbour : {before_[other], next_[other]}) {
    bool enters = true;
    for (std::size_t edge = 0; edge < 3; ++edge)
      enters = enters && (sides[edge] > 0 || side(neighbour, edge) > 0);
    if (enters) return true;
  }
  return false;
}
}  // namespace tapestry::geometry
