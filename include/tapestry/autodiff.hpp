#pragma once
/// Scalar differentiation, without need of an array library: a tape, variables, the functions of <cmath>,
/// dual numbers, and derivatives of whole functions. Array operations on the same tape are in
/// autodiff/array_functions.hpp, a user's own operations in autodiff/record.hpp, a check of any gradient in
/// autodiff/gradient_check.hpp, what lets Eigen's matrices hold variables in autodiff/eigen.hpp, and linear
/// algebra of one record an operation in autodiff/matrix.hpp.
/// Jacobians, jacobian(f, x) among them, are in autodiff/jacobian.hpp, sparse ones in
/// autodiff/compressed_jacobian.hpp, and recordings that serve again for other inputs in autodiff/replay.hpp,
/// for many at once in autodiff/replay_lanes.hpp.
#include <tapestry/autodiff/derivatives.hpp>
#include <tapestry/autodiff/dual.hpp>
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/autodiff/variable.hpp>
