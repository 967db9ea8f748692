#pragma once
/// Scalar differentiation, without an array library: a tape, variables, the functions of <cmath>, dual
/// numbers, operations of your own, and derivatives of whole functions. Related headers:
///
///   autodiff/array_functions.hpp      array operations on the same tape
///   autodiff/record.hpp               operations of your own on arrays
///   autodiff/gradient_check.hpp       a check of any gradient
///   autodiff/eigen.hpp                Eigen matrices of variables
///   autodiff/matrix.hpp               linear algebra, one record an operation
///   autodiff/jacobian.hpp             jacobian(f, x); sparse ones: autodiff/compressed_jacobian.hpp
#include <tapestry/version.hpp>
// Included before the headers that use them: a compiler's message about them then names few files.
#include <tapestry/autodiff/detail/tape/dual_number.hpp>

#include <tapestry/autodiff/tape.hpp>

#include <tapestry/autodiff/derivatives.hpp>
#include <tapestry/autodiff/detail/tape/record_scalar.hpp>
#include <tapestry/autodiff/dual.hpp>
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/variable.hpp>
