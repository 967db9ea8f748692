#pragma once
/// The functions of variables and duals, each with the derivative it takes at kinks and poles in its comment.
#include <tapestry/autodiff/functions/arithmetic.hpp>
#include <tapestry/autodiff/functions/exponential.hpp>
#include <tapestry/autodiff/functions/hyperbolic.hpp>
#include <tapestry/autodiff/functions/power.hpp>
#include <tapestry/autodiff/functions/reduction.hpp>
#include <tapestry/autodiff/functions/selection.hpp>
#include <tapestry/autodiff/functions/special.hpp>
#include <tapestry/autodiff/functions/ternary.hpp>
#include <tapestry/autodiff/functions/trigonometric.hpp>
