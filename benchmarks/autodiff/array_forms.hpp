#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include "objectives.hpp"

namespace tapestry::benchmarks {
/// An objective written with array operations, in float or double:
///
///   ArrayForm(objective)   what is constant, as arrays
///   extents()              of the input array, whose elements are the objective's inputs in the same order
///   form(x)                the value
///
/// Long recurrences have no array form.
template <class Objective, class T>
class ArrayForm;

namespace detail {
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> constants(const std::vector<double>& values,
                                               const Extents<Rank>& extents) {
  Array<T, Rank> array(extents);
  for (std::size_t i = 0; i < values.size(); ++i) array.data()[i] = static_cast<T>(values[i]);
  return array;
}
/// first, first + step … , `count` of them
[[nodiscard]] inline std::vector<std::size_t> places(std::size_t first, std::size_t count,
                                                     std::size_t step = 1) {
  std::vector<std::size_t> all(count);
  for (std::size_t i = 0; i < count; ++i) all[i] = first + i * step;
  return all;
}
}  // namespace detail

template <class T>
class ArrayForm<Gmm, T> {
  static constexpr std::size_t d = Gmm::d, k = Gmm::k;

 public:
  explicit ArrayForm(const Gmm& gmm) : data_(detail::constants<T, 2>(gmm.data, {Gmm::points, d})) {
    for (std::size_t column = 0; column < d; ++column)
      for (std::size_t row = column + 1; row < d; ++row) below_.push_back(column * d + row);
  }
  static Extents<1> extents() { return {k + k * d + k * Gmm::factor}; }

  /// Points as rows: y = (p − mean) · Qᵀ, for every component.
  Variable<T> operator()(const ArrayVariable<T, 1>& x) const {
    std::vector<ArrayVariable<T, 2>> terms;
    for (std::size_t j = 0; j < k; ++j) {
      const ArrayVariable<T, 1> mean = part(x, k + j * d, d), logs = part(x, k + k * d + j * Gmm::factor, d);
      const ArrayVariable<T, 1> rest = part(x, k + k * d + j * Gmm::factor + d, below_.size());
      const ArrayVariable<T, 2> turned =
          scatter<2>(exp(logs), detail::places(0, d, d + 1), {d, d}) + scatter<2>(rest, below_, {d, d});
      const ArrayVariable<T, 2> y = matmul(constant(data_) - repeat(mean, 0), turned);
      const ArrayVariable<T, 1> term = (element(x, {j}) + sum(logs)) - T(0.5) * sum_along(square(y), 1);
      terms.push_back(reshape<2>(term, {1, Gmm::points}));
    }
    return sum(logsumexp_along(concatenate<T, 2>(terms, 0), 0));
  }

 private:
  static auto part(const ArrayVariable<T, 1>& x, std::size_t first, std::size_t count) {
    return slice(x, {{{first, first + count}}});
  }

  ArrayVariable<T, 2> data_;
  std::vector<std::size_t> below_;
};

template <class T, Exponential Policy>
class SoftmaxForm {
 public:
  explicit SoftmaxForm(const Softmax&) {
    for (std::size_t i = 0; i < Softmax::cells; ++i)
      labels_.push_back(i * Softmax::classes + Softmax::label(i));
  }
  static Extents<2> extents() { return {Softmax::cells, Softmax::classes}; }
  Variable<T> operator()(const ArrayVariable<T, 2>& z) const {
    return sum(logsumexp_along<Policy>(z, 1)) - sum(gather(z, labels_));
  }

 private:
  std::vector<std::size_t> labels_;
};
template <class T>
class ArrayForm<Softmax, T> : public SoftmaxForm<T, Exponential::vector> {
 public:
  using SoftmaxForm<T, Exponential::vector>::SoftmaxForm;
};

/// One axis of boxes beside wanted ones.
template <class C, class S, class G, class H>
[[nodiscard]] auto overlap(const C& centre, const S& size, const G& other, const H& other_size) {
  return max(
      min(centre + 0.5 * size, other + 0.5 * other_size) - max(centre - 0.5 * size, other - 0.5 * other_size),
      0);
}

template <class T>
class ArrayForm<Iou, T> {
 public:
  explicit ArrayForm(const Iou& iou)
      : truth_(transpose(detail::constants<T, 2>(iou.truth, {Iou::boxes, 4}))) {}
  static Extents<2> extents() { return {Iou::boxes, 4}; }
  Variable<T> operator()(const ArrayVariable<T, 2>& boxes) const {
    const ArrayVariable<T, 2> b = transpose(boxes);  // each side is read several times
    const auto side = [&](std::size_t i) { return select(b, 0, i); };
    const auto wanted = [&](std::size_t i) { return constant(select(truth_, 0, i)); };
    const ArrayVariable<T, 1> inside =
        overlap(side(0), side(2), wanted(0), wanted(2)) * overlap(side(1), side(3), wanted(1), wanted(3));
    return sum(1 - inside / (side(2) * side(3) + wanted(2) * wanted(3) - inside));
  }

 private:
  ArrayVariable<T, 2> truth_;  // [4, boxes]
};

template <class T>
class ArrayForm<Ciou, T> {
 public:
  explicit ArrayForm(const Ciou& ciou)
      : truth_(transpose(detail::constants<T, 2>(ciou.truth, {Ciou::boxes, 4}))) {}
  static Extents<2> extents() { return {Ciou::boxes, 4}; }
  Variable<T> operator()(const ArrayVariable<T, 2>& boxes) const {
    const ArrayVariable<T, 2> b = transpose(boxes);  // each side is read several times
    const auto side = [&](std::size_t i) { return select(b, 0, i); };
    const auto wanted = [&](std::size_t i) { return constant(select(truth_, 0, i)); };
    const auto around = [&](std::size_t a) {
      return square(max(side(a) + 0.5 * side(a + 2), wanted(a) + 0.5 * wanted(a + 2)) -
                    min(side(a) - 0.5 * side(a + 2), wanted(a) - 0.5 * wanted(a + 2)));
    };
    const ArrayVariable<T, 1> inside =
        overlap(side(0), side(2), wanted(0), wanted(2)) * overlap(side(1), side(3), wanted(1), wanted(3));
    const ArrayVariable<T, 1> iou = inside / (side(2) * side(3) + wanted(2) * wanted(3) - inside);
    const ArrayVariable<T, 1> distance =
        (square(side(0) - wanted(0)) + square(side(1) - wanted(1))) / (around(0) + around(1));
    const ArrayVariable<T, 1> v =
        static_cast<T>(Ciou::aspect_scale) * square(atan(wanted(2) / wanted(3)) - atan(side(2) / side(3)));
    return sum(1 - iou + distance + v * v / (1 - iou + v));
  }

 private:
  ArrayVariable<T, 2> truth_;
};

template <class T>
class ArrayForm<Smoothness, T> {
 public:
  explicit ArrayForm(const Smoothness&) {}
  static Extents<3> extents() { return {Smoothness::side, Smoothness::side, 3}; }
  Variable<T> operator()(const ArrayVariable<T, 3>& x) const {
    constexpr std::size_t last = Smoothness::side - 1;
    const auto here = slice(x, {{{0, last}, {0, last}, {}}});
    const auto below = slice(x, {{{1}, {0, last}, {}}}), beside = slice(x, {{{0, last}, {1}, {}}});
    return sum(square(below - here) + square(beside - here));
  }
};

template <class T>
class ArrayForm<Project, T> {
 public:
  explicit ArrayForm(const Project&) {}
  static Extents<2> extents() { return {Project::triangles, 9}; }
  Variable<T> operator()(const ArrayVariable<T, 2>& v) const {
    using Row = ArrayVariable<T, 1>;
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

/// The skeleton as scalars; the measured vertices as one product, [3, 4 · bones] · [4 · bones, measured].
template <class T>
class ArrayForm<HandTracking, T> {
  static constexpr std::size_t bones = HandTracking::bones, measured = HandTracking::measured;

 public:
  explicit ArrayForm(const HandTracking& hand)
      : hand_(hand), points_(transpose(detail::constants<T, 2>(hand.points, {measured, 3}))) {
    Array<T, 2> follows({4 * bones, measured});
    for (std::size_t point = 0; point < measured; ++point)
      for (std::size_t bone = 0; bone < bones; ++bone) {
        const std::size_t v = HandTracking::vertex(point);
        const double weight = hand.weights[bone * HandTracking::vertices + v];
        for (std::size_t i = 0; i < 4; ++i)
          follows(4 * bone + i, point) = static_cast<T>(weight * (i == 3 ? 1 : hand.rest[3 * v + i]));
      }
    follows_ = follows;
  }
  static Extents<1> extents() { return {HandTracking::parameters}; }

  Variable<T> operator()(const ArrayVariable<T, 1>& x) const {
    using S = Variable<T>;
    std::vector<S> p;
    for (std::size_t i = 0; i < x.size(); ++i) p.push_back(element(x, {i}));
    std::array<Affine<S>, bones> absolutes;
    std::vector<S> transforms(12 * bones);
    for (std::size_t bone = 0; bone < bones; ++bone) {
      const std::size_t place = HandTracking::flexion(bone);
      const S abduct = HandTracking::has_abduction(bone) ? p[place + 1] : S(0);
      const auto relative =
          compose<S>(cast<T>(hand_.relatives[bone]), rotation_xz<S>(place == 0 ? S(0) : p[place], abduct));
      absolutes[bone] = bone == 0 ? relative : compose<S>(absolutes[HandTracking::parent(bone)], relative);
      const auto m = compose<S>(absolutes[bone], cast<T>(hand_.inverses[bone]));
      for (std::size_t i = 0; i < 12; ++i) transforms[(i / 4 * bones + bone) * 4 + i % 4] = m[i];
    }
    const auto turn = axis_rotation(p.data());
    const auto posed = array_of<T, 2>(transforms, {3, 4 * bones});
    const auto turned = array_of<T, 2>(std::span<const S>(turn), {3, 3});
    const ArrayVariable<T, 2> seen = matmul(turned, matmul(posed, follows_));
    return T(0.5) * sum(square(seen + repeat(slice(x, {{{3, 6}}}), 1) - constant(points_)));
  }

 private:
  HandTracking hand_;
  ArrayVariable<T, 2> points_, follows_;
};

template <class T>
class ArrayForm<MatmulChain, T> {
  static constexpr std::size_t side = MatmulChain::side;

 public:
  explicit ArrayForm(const MatmulChain&) {}
  static Extents<3> extents() { return {MatmulChain::factors, side, side}; }
  Variable<T> operator()(const ArrayVariable<T, 3>& x) const {
    ArrayVariable<T, 2> product = select(x, 0, 0);
    for (std::size_t f = 1; f < MatmulChain::factors; ++f) product = matmul(product, select(x, 0, f));
    return T(0.5) * sum(square(product));
  }
};

/// All observations side by side.
template <class T>
class ArrayForm<Bundle, T> {
  using B = BundleProblem;

 public:
  explicit ArrayForm(const Bundle& bundle)
      : seen_(detail::constants<T, 2>(bundle.seen, {B::observations, 2})) {
    for (std::size_t k = 0; k < B::block - 1; ++k)
      for (std::size_t o = 0; o < B::observations; ++o)
        places_[k].push_back(k < B::camera_size ? B::camera(o) * B::camera_size + k
                                                : B::first_point + 3 * B::point(o) + k - B::camera_size);
  }
  static Extents<1> extents() { return {B::first_weight + B::observations}; }

  Variable<T> operator()(const ArrayVariable<T, 1>& input) const {
    using Row = ArrayVariable<T, 1>;
    const auto in = [&](std::size_t k) { return gather(input, places_[k]); };
    const auto weight = slice(input, {{{B::first_weight, extents()[0]}}});
    const Row x = in(11) - in(3), y = in(12) - in(4), z = in(13) - in(5), rx = in(0), ry = in(1), rz = in(2);
    const Row angle = sqrt(square(rx) + square(ry) + square(rz));
    const Row s = sin(angle), c = cos(angle), u = rx / angle, v = ry / angle, w = rz / angle;
    const Row along = (u * x + v * y + w * z) * (1 - c);
    const Row depth = z * c + (u * y - v * x) * s + w * along;
    const Row a = (x * c + (v * z - w * y) * s + u * along) / depth;
    const Row b = (y * c + (w * x - u * z) * s + v * along) / depth;
    const Row r = square(a) + square(b);
    const Row scale = in(6) * (1 + in(9) * r + in(10) * square(r));
    const auto error = [&](std::size_t axis, const Row& at) {
      return square(weight * (in(7 + axis) + scale * at - constant(column(seen_, axis))));
    };
    return T(0.5) * sum(error(0, a) + error(1, b) + square(1 - square(weight)));
  }

 private:
  ArrayVariable<T, 2> seen_;
  std::array<std::vector<std::size_t>, B::block - 1> places_;
};
}  // namespace tapestry::benchmarks
