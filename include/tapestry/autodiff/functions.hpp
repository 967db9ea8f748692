#pragma once
/// The functions of variables and duals, and with array_functions.hpp of arrays, element by element;
/// each comment states the derivative at kinks and poles. Each is one row of one of the headers below,
/// which those operators of networks read, too, that call <cmath>. A row is a line that names the
/// function, and a type with
///
///   value(x)                 f(x)
///   partial(x, f)            f′(x), given f(x); of two arguments partial_x(x, y, f) and partial_y(x, y, f)
///   curvature(x, f, slope)   f″(x), where partial() as a formula of duals would cancel
///   is_kink(x)               whether f′ there follows from a rule, or is infinite
///   is_cheap                 formulas of arrays compute it again where they read it
///   skips_zero               a zero slope passes no NaN on
///
/// Accuracy in double, with glibc, over the whole range: values are within 2 ulp (cbrt and tgamma 3), first
/// derivatives within 4, second ones within 5, and third ones, by duals of duals of duals, within 8. There
/// are five exceptions. Where a third derivative passes through 0 by terms that cancel (sigmoid, tanh, asinh,
/// atan, erf, erfc, tgamma, logsumexp, hypot and atan2), its error is within 4 ε of the terms. digamma, and
/// with it the slopes of lgamma and tgamma, is within 1e-18 beside its roots below −20. A derivative
/// below 2^-1070 may be off by 16 units of the smallest number, or 0 where a length overflows. The slope of
/// x / y by y is as accurate as x / y: few digits where x / y is denormal. Where a third derivative
/// overflows, it may be NaN for atan2, by both operands, or on a tape of duals of duals; those of exp2 are
/// infinite where exp2 is. tests/autodiff/function_rows.hpp lists every function for this.
///
/// A template of your own named like one of these that <cmath> lacks can be called with an explicit argument,
/// as sigmoid<T>(a * b + c): ours take no type of a scalar there, so that they do not fit.
#include <tapestry/autodiff/detail/functions/reduction.hpp>
#include <tapestry/autodiff/detail/functions/special.hpp>
#include <tapestry/autodiff/detail/functions/ternary.hpp>
#include <tapestry/autodiff/detail/functions/trigonometric.hpp>
