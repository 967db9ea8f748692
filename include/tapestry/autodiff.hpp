#pragma once
/// Scalar reverse-mode differentiation, without need of an array library: a tape, variables, and the
/// functions of <cmath>. Array operations on the same tape are in autodiff/array_functions.hpp, a user's own
/// operations in autodiff/record.hpp, and a check of any gradient in autodiff/gradient_check.hpp.
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/autodiff/variable.hpp>
