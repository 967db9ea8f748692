// Minimises Rosenbrock's valley in many dimensions by Newton's method. Conjugate gradients find each step
// from Hessian-vector products alone: no Hessian is ever stored.
#include <cstdio>
#include <tapestry/autodiff.hpp>

namespace {
using Vector = std::vector<double>;

const auto valley = []<class S>(std::span<S> x) {
  std::remove_const_t<S> total = 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i)
    total += 100 * square(x[i + 1] - x[i] * x[i]) + square(1 - x[i]);
  return total;
};

double dot(const Vector& a, const Vector& b) {
  double total = 0;
  for (std::size_t i = 0; i < a.size(); ++i) total += a[i] * b[i];
  return total;
}

void add(Vector& to, double factor, const Vector& from) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * from[i];
}

/// About H⁻¹·gradient, or a shorter step where the valley curves down.
Vector newton_step(const Vector& x, const Vector& gradient) {
  Vector step(x.size()), residual = gradient, direction = gradient;
  const double enough = 1e-4 * dot(gradient, gradient);
  for (std::size_t i = 0; i < 2 * x.size() && dot(residual, residual) > enough; ++i) {
    const Vector product = tapestry::hessian_product(valley, x, direction).product;
    const double curvature = dot(direction, product);
    if (curvature <= 0) return i == 0 ? gradient : step;
    const double before = dot(residual, residual), length = before / curvature;
    add(step, length, direction);
    add(residual, -length, product);
    Vector next = residual;
    add(next, dot(residual, residual) / before, direction);
    direction = next;
  }
  return step;
}
}  // namespace

int main() {
  Vector x(100, -0.5);
  auto here = tapestry::gradient(valley, x);
  int steps = 0;
  for (; steps < 400 && std::sqrt(dot(here.gradient, here.gradient)) > 1e-9; ++steps) {
    const Vector step = newton_step(x, here.gradient);
    auto there = here;
    for (double length = 1; length > 1e-10; length /= 2) {  // shorter until it leads down
      Vector tried = x;
      add(tried, -length, step);
      there = tapestry::gradient(valley, tried);
      if (there.value < here.value - 1e-4 * length * dot(step, here.gradient)) {
        x = tried;
        break;
      }
    }
    here = there;
  }
  double farthest = 0;
  for (const double entry : x) farthest = std::max(farthest, std::abs(entry - 1));
  std::printf("minimum %s, %s of one everywhere\n", here.value < 1e-18 ? "reached" : "not reached",
              farthest < 1e-9 ? "within 1e-9" : "not within 1e-9");
}
