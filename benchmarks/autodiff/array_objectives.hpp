#pragma once
#include <cstddef>
#include <tapestry/autodiff/array_functions.hpp>
#include <vector>

/// Objectives written with array operations; see objectives.hpp for their definitions.
namespace objectives {

/// Cross-entropy of softmax: [cells, classes], the wanted class of cell i being 7i mod classes.
struct ArraySoftmax {
  static constexpr std::size_t rank = 2;
  static constexpr std::size_t classes = 80, cells = 2000;
  static tapestry::Extents<2> extents() { return {cells, classes}; }
  std::vector<std::size_t> wanted = [] {
    std::vector<std::size_t> places(cells);
    for (std::size_t i = 0; i < cells; ++i) places[i] = i * classes + i * 7 % classes;
    return places;
  }();

  template <class T>
  tapestry::Variable<T> operator()(const tapestry::ArrayVariable<T, 2>& z) const {
    return sum(logsumexp_along(z, 1)) - sum(gather(z, wanted));
  }
};

/// Σ (1 − IoU) of box pairs: [boxes, 4] of cx, cy, w, h against wanted ones.
template <class T>
class ArrayIou {
 public:
  static constexpr std::size_t rank = 2;

  explicit ArrayIou(const tapestry::ArrayVariable<T, 2>& wanted) {
    const auto corner = [&](std::size_t axis, double side) -> Row {
      return column(wanted, axis) + side * column(wanted, axis + 2);
    };
    left_ = corner(0, -0.5), right_ = corner(0, 0.5), top_ = corner(1, -0.5), bottom_ = corner(1, 0.5);
    area_ = column(wanted, 2) * column(wanted, 3);
  }

  tapestry::Variable<T> operator()(const tapestry::ArrayVariable<T, 2>& boxes) const {
    const tapestry::ArrayVariable<T, 2> coordinates = transpose(boxes);  // each read several times
    const auto cx = select(coordinates, 0, 0), cy = select(coordinates, 0, 1), w = select(coordinates, 0, 2),
               h = select(coordinates, 0, 3);
    const auto overlap = [](const auto& centre, const auto& size, const Row& low, const Row& high) {
      return max(min(centre + 0.5 * size, constant(high)) - max(centre - 0.5 * size, constant(low)), 0);
    };
    const Row inside = overlap(cx, w, left_, right_) * overlap(cy, h, top_, bottom_);
    return sum(1 - inside / (w * h + constant(area_) - inside));
  }

 private:
  using Row = tapestry::ArrayVariable<T, 1>;
  Row left_, right_, top_, bottom_, area_;
};

/// Squared colour steps of a picture [H, W, C] between neighbours, without the last row and column.
struct ArraySmoothness {
  static constexpr std::size_t rank = 3;

  template <class T>
  tapestry::Variable<T> operator()(const tapestry::ArrayVariable<T, 3>& x) const {
    const std::size_t rows = x.shape()[0] - 1, columns = x.shape()[1] - 1;
    const auto here = slice(x, {{{0, rows}, {0, columns}, {}}});
    const auto below = slice(x, {{{1}, {0, columns}, {}}}), beside = slice(x, {{{0, rows}, {1}, {}}});
    return sum(square(below - here) + square(beside - here));
  }
};

/// Perspective projection of triangles [triangles, 9] and one barycentric interpolation each.
struct ArrayProject {
  static constexpr std::size_t rank = 2;

  template <class T>
  tapestry::Variable<T> operator()(const tapestry::ArrayVariable<T, 2>& v) const {
    using Row = tapestry::ArrayVariable<T, 1>;
    const auto inverse = [&](std::size_t corner) -> Row { return 1 / column(v, 3 * corner + 2); };
    const Row iz0 = inverse(0), iz1 = inverse(1), iz2 = inverse(2);
    const auto project = [&](std::size_t place, const Row& iz) -> Row { return 1.7 * column(v, place) * iz; };
    const Row px0 = project(0, iz0), py0 = project(1, iz0), px1 = project(3, iz1), py1 = project(4, iz1),
              px2 = project(6, iz2), py2 = project(7, iz2);
    const Row area = (px1 - px0) * (py2 - py0) - (px2 - px0) * (py1 - py0);
    const Row w0 = ((px1 - .1) * (py2 - .2) - (px2 - .1) * (py1 - .2)) / area;
    const Row w1 = ((px2 - .1) * (py0 - .2) - (px0 - .1) * (py2 - .2)) / area;
    const Row w2 = 1 - w0 - w1;
    const Row a = w0 * iz0, b = w1 * iz1, c = w2 * iz2;
    return sum(tanh((a * .3 + b * .6 + c * .9) / (a + b + c)));
  }
};

}  // namespace objectives
