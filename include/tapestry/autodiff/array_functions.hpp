#pragma once
/// Operations on array variables: formulas that are computed and pulled back in one pass each, and records
/// with a hand-written pullback.
#include <tapestry/autodiff/array_functions/convolution.hpp>
#include <tapestry/autodiff/array_functions/elementwise.hpp>
#include <tapestry/autodiff/array_functions/exponential.hpp>
#include <tapestry/autodiff/array_functions/extreme.hpp>
#include <tapestry/autodiff/array_functions/gather.hpp>
#include <tapestry/autodiff/array_functions/join.hpp>
#include <tapestry/autodiff/array_functions/product.hpp>
#include <tapestry/autodiff/array_functions/reduction.hpp>
#include <tapestry/autodiff/array_functions/unary.hpp>
#include <tapestry/autodiff/array_functions/view.hpp>
