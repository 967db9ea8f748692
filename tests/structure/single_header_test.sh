#!/usr/bin/env bash
# single_header_test.sh COMPILER: a program of two source files uses the scalar tape as one header, which nothing else
# of ours stands beside, with an operation of its own. For another machine FLAGS, RUNNER and ENDING, of the program's name,
# are in the environment.
set -euo pipefail
sources=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bash "$sources/cmake/single_header.sh" >"$folder/tapestry_autodiff.hpp"
cd "$folder"
cat >main.cpp <<'END'
#include "tapestry_autodiff.hpp"

#include <cmath>
#include <cstdio>

tapestry::Variable<double> squared(const tapestry::Variable<double>& x);

int main() {
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto x = tape.input(3.0), y = tape.input(4.0);
  tape.reverse(sqrt(squared(x) + squared(y)));
  std::printf("%.3f %.3f, Tapestry %s\n", x.adjoint(), y.adjoint(), TAPESTRY_VERSION_TEXT);
  return std::abs(x.adjoint() - 0.6) + std::abs(y.adjoint() - 0.8) < 1e-15 ? 0 : 1;
}
END
cat >other.cpp <<'END'
#include "tapestry_autodiff.hpp"
#include "tapestry_autodiff.hpp"

tapestry::Variable<double> squared(const tapestry::Variable<double>& x) {
  const auto pullback = [x = x.value()](double value_adjoint, double* x_adjoint) { *x_adjoint += value_adjoint * 2 * x; };
  return record_scalar(x.value() * x.value(), pullback, x);
}
END
# shellcheck disable=SC2086  # flags and words
"$1" -std=c++20 -Wall -Wextra -Werror ${FLAGS-} main.cpp other.cpp -o "program${ENDING-}"
${RUNNER-} "./program${ENDING-}"
