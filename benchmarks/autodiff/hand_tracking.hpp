#pragma once
#include <algorithm>
#include <array>
#include "seeded.hpp"

namespace tapestry::benchmarks {
/// Rotation and translation, [3, 4].
template <class S>
using Affine = std::array<S, 12>;

/// a · b of affine maps; a or b may be of numbers.
template <class S, class A, class B>
[[nodiscard]] Affine<S> compose(const Affine<A>& a, const Affine<B>& b) {
  Affine<S> c;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      c[4 * i + j] = a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j];
      if (j == 3) c[4 * i + j] += a[4 * i + 3];
    }
  return c;
}

/// Rotation about x, then about z.
template <class S>
[[nodiscard]] Affine<S> rotation_xz(const S& x, const S& z) {
  const S cx = cos(x), sx = sin(x), cz = cos(z), sz = sin(z);
  return {cz, -sz * cx, sz * sx, S(0), sz, cz * cx, -cz * sx, S(0), S(0), sx, cx, S(0)};
}

/// Rotation about an axis by the axis's length, row by row. The axis is not 0.
template <class S>
[[nodiscard]] std::array<S, 9> axis_rotation(const S* axis) {
  const S length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const S x = axis[0] / length, y = axis[1] / length, z = axis[2] / length;
  const S s = sin(length), c = cos(length);
  return {x * x + (1 - x * x) * c, x * y * (1 - c) - z * s, x * z * (1 - c) + y * s,
          x * y * (1 - c) + z * s, y * y + (1 - y * y) * c, y * z * (1 - c) - x * s,
          x * z * (1 - c) - y * s, z * y * (1 - c) + x * s, z * z + (1 - z * z) * c};
}

/// ½ Σ of squared distances between measured points and a posed hand: the hand tracking of the public ADBench
/// suite in its form of 26 parameters (global rotation and translation; of each finger three flexions and one
/// abduction), on a drawn hand of 22 bones and 544 vertices. The suite takes the Jacobian of the distances.
/// Every vertex follows every bone by its weight, most of which are 0.
struct HandTracking {
  static constexpr const char* name = "hand-tracking";
  static constexpr std::size_t bones = 22, vertices = 544, measured = 500, parameters = 26;

  std::array<Affine<double>, bones> relatives{}, inverses{};  // at rest: to the parent, and from the world
  std::vector<double> rest = uniform(3 * vertices, -1, 1, 51);
  std::vector<double> weights = std::vector<double>(bones * vertices);  // [bones, vertices]
  std::vector<double> points = uniform(3 * measured, -1.5, 1.5, 52);
  [[nodiscard]] static std::vector<double> start() { return uniform(parameters, -.4, .4, 53); }

  HandTracking() {
    const auto draw = uniform(5 * bones, -.5, .5, 54), share = uniform(4 * vertices, .1, 1, 55);
    std::array<Affine<double>, bones> absolutes;
    for (std::size_t bone = 0; bone < bones; ++bone) {
      relatives[bone] = rotation_xz(draw[5 * bone], draw[5 * bone + 1]);
      for (std::size_t i = 0; i < 3; ++i) relatives[bone][4 * i + 3] = draw[5 * bone + 2 + i];
      absolutes[bone] = bone == 0 ? relatives[0] : compose<double>(absolutes[parent(bone)], relatives[bone]);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) inverses[bone][4 * i + j] = absolutes[bone][4 * j + i];
        for (std::size_t j = 0; j < 3; ++j)
          inverses[bone][4 * i + 3] -= absolutes[bone][4 * j + i] * absolutes[bone][4 * j + 3];
      }
    }
    for (std::size_t v = 0; v < vertices; ++v) {
      const double total = share[4 * v] + share[4 * v + 1] + share[4 * v + 2] + share[4 * v + 3];
      for (std::size_t k = 0; k < 4; ++k)
        weights[(v + 5 * k) % bones * vertices + v] = share[4 * v + k] / total;
    }
  }

  /// Bones: the wrist, four of each finger, the forearm.
  [[nodiscard]] static std::size_t parent(std::size_t bone) {
    return bone == bones - 1 || bone % 4 == 1 ? 0 : bone - 1;
  }
  /// The place of a bone's flexion among the parameters, behind which its abduction is; 0 if it has none.
  [[nodiscard]] static std::size_t flexion(std::size_t bone) {
    if (bone == 0 || bone == bones - 1 || bone % 4 == 1) return 0;
    const std::size_t joint = (bone - 1) % 4;
    return 6 + (bone - 1) / 4 * 4 + (joint == 1 ? 0 : joint);
  }
  [[nodiscard]] static bool has_abduction(std::size_t bone) { return flexion(bone) != 0 && bone % 4 == 2; }
  [[nodiscard]] static std::size_t vertex(std::size_t point) { return point * 7 % vertices; }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    std::array<Affine<S>, bones> absolutes;
    std::vector<S> positions(3 * vertices, S(0));
    for (std::size_t bone = 0; bone < bones; ++bone) {
      const S flex = flexion(bone) == 0 ? S(0) : x[flexion(bone)];
      const S abduct = has_abduction(bone) ? x[flexion(bone) + 1] : S(0);
      const Affine<S> relative = compose<S>(relatives[bone], rotation_xz<S>(flex, abduct));
      absolutes[bone] = bone == 0 ? relative : compose<S>(absolutes[parent(bone)], relative);
      const Affine<S> m = compose<S>(absolutes[bone], inverses[bone]);
      for (std::size_t v = 0; v < vertices; ++v)
        for (std::size_t i = 0; i < 3; ++i)
          positions[3 * v + i] += (m[4 * i] * rest[3 * v] + m[4 * i + 1] * rest[3 * v + 1] +
                                   m[4 * i + 2] * rest[3 * v + 2] + m[4 * i + 3]) *
                                  weights[bone * vertices + v];
    }
    const auto turn = axis_rotation(x);
    S total = 0;
    for (std::size_t point = 0; point < measured; ++point) {
      const S* const p = positions.data() + 3 * vertex(point);
      for (std::size_t i = 0; i < 3; ++i) {
        const S error = points[3 * point + i] -
                        (turn[3 * i] * p[0] + turn[3 * i + 1] * p[1] + turn[3 * i + 2] * p[2] + x[3 + i]);
        total += error * error;
      }
    }
    return 0.5 * total;
  }
};

/// Adds to the adjoints of a and b in c = a · b.
template <class T>
void compose_adjoint(const Affine<T>& a, const Affine<T>& b, const Affine<T>& c_g, Affine<T>& a_g,
                     Affine<T>& b_g) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t j = 0; j < 4; ++j) {
        a_g[4 * i + k] += c_g[4 * i + j] * b[4 * k + j];
        b_g[4 * k + j] += c_g[4 * i + j] * a[4 * i + k];
      }
    a_g[4 * i + 3] += c_g[4 * i + 3];
  }
}

/// Adds the adjoint of an axis to axis_g.
template <class T>
void axis_rotation_adjoint(const T* axis, const std::array<T, 9>& g, T* axis_g) {
  const T length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const T u[3] = {axis[0] / length, axis[1] / length, axis[2] / length};
  const T s = std::sin(length), c = std::cos(length);
  const T turned[3] = {g[7] - g[5], g[2] - g[6], g[3] - g[1]};
  T c_g = g[0] + g[4] + g[8], s_g = 0, u_g[3], along = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    T both = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      c_g -= u[i] * g[3 * i + j] * u[j];
      both += (g[3 * i + j] + g[3 * j + i]) * u[j];
    }
    s_g += turned[i] * u[i];
    u_g[i] = (1 - c) * both + s * turned[i];
    along += u_g[i] * u[i];
  }
  for (std::size_t i = 0; i < 3; ++i)
    axis_g[i] += (u_g[i] - along * u[i]) / length + u[i] * (c * s_g - s * c_g);
}

template <class T>
[[nodiscard]] Affine<T> cast(const Affine<double>& from) {
  Affine<T> to;
  for (std::size_t i = 0; i < 12; ++i) to[i] = static_cast<T>(from[i]);
  return to;
}

template <class T>
T hand_adjoint(const HandTracking& hand, const T* x, T* gradient) {
  constexpr std::size_t bones = HandTracking::bones, vertices = HandTracking::vertices;
  std::array<Affine<T>, bones> turns, relatives, absolutes, absolutes_g{};
  std::vector<T> rest(hand.rest.begin(), hand.rest.end()), weights(hand.weights.begin(), hand.weights.end());
  std::vector<T> positions(3 * vertices), positions_g(3 * vertices);
  for (std::size_t bone = 0; bone < bones; ++bone) {
    const std::size_t place = HandTracking::flexion(bone);
    turns[bone] =
        rotation_xz<T>(place == 0 ? T(0) : x[place], HandTracking::has_abduction(bone) ? x[place + 1] : T(0));
    relatives[bone] = compose<T>(cast<T>(hand.relatives[bone]), turns[bone]);
    absolutes[bone] =
        bone == 0 ? relatives[0] : compose<T>(absolutes[HandTracking::parent(bone)], relatives[bone]);
    const auto m = compose<T>(absolutes[bone], cast<T>(hand.inverses[bone]));
    for (std::size_t v = 0; v < vertices; ++v)
      for (std::size_t i = 0; i < 3; ++i)
        positions[3 * v + i] +=
            weights[bone * vertices + v] * (m[4 * i] * rest[3 * v] + m[4 * i + 1] * rest[3 * v + 1] +
                                            m[4 * i + 2] * rest[3 * v + 2] + m[4 * i + 3]);
  }
  const auto turn = axis_rotation(x);
  std::array<T, 9> turn_g{};
  std::fill_n(gradient, HandTracking::parameters, T(0));
  T total = 0;
  for (std::size_t point = 0; point < HandTracking::measured; ++point) {
    const T* const p = positions.data() + 3 * HandTracking::vertex(point);
    T* const p_g = positions_g.data() + 3 * HandTracking::vertex(point);
    for (std::size_t i = 0; i < 3; ++i) {
      const T error = turn[3 * i] * p[0] + turn[3 * i + 1] * p[1] + turn[3 * i + 2] * p[2] + x[3 + i] -
                      static_cast<T>(hand.points[3 * point + i]);
      total += error * error;
      gradient[3 + i] += error;
      for (std::size_t j = 0; j < 3; ++j) {
        turn_g[3 * i + j] += error * p[j];
        p_g[j] += error * turn[3 * i + j];
      }
    }
  }
  axis_rotation_adjoint(x, turn_g, gradient);
  for (std::size_t bone = bones; bone-- > 0;) {
    Affine<T> m_g{}, relative_g{}, turn_bone_g{}, unused{};
    for (std::size_t v = 0; v < vertices; ++v)
      for (std::size_t i = 0; i < 3; ++i) {
        const T g = weights[bone * vertices + v] * positions_g[3 * v + i];
        for (std::size_t j = 0; j < 3; ++j) m_g[4 * i + j] += g * rest[3 * v + j];
        m_g[4 * i + 3] += g;
      }
    compose_adjoint(absolutes[bone], cast<T>(hand.inverses[bone]), m_g, absolutes_g[bone], unused);
    if (bone == 0)
      relative_g = absolutes_g[0];
    else
      compose_adjoint(absolutes[HandTracking::parent(bone)], relatives[bone], absolutes_g[bone],
                      absolutes_g[HandTracking::parent(bone)], relative_g);
    const std::size_t place = HandTracking::flexion(bone);
    if (place == 0) continue;
    compose_adjoint(cast<T>(hand.relatives[bone]), turns[bone], relative_g, unused, turn_bone_g);
    const auto& g = turn_bone_g;
    const auto& r = turns[bone];  // columns 1 and 2 turn into each other about x, rows 0 and 1 about z
    for (std::size_t i = 0; i < 3; ++i)
      gradient[place] += g[4 * i + 1] * r[4 * i + 2] - g[4 * i + 2] * r[4 * i + 1];
    if (!HandTracking::has_abduction(bone)) continue;
    for (std::size_t j = 0; j < 3; ++j) gradient[place + 1] += g[4 + j] * r[j] - g[j] * r[4 + j];
  }
  return total / 2;
}
}  // namespace tapestry::benchmarks
