#pragma once
/// Operations on array variables: formulas that are computed and pulled back in one pass each, and records
/// with a hand-written pullback.
#include <tapestry/autodiff/arrays/elementwise.hpp>
#include <tapestry/autodiff/arrays/extreme.hpp>
#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/autodiff/arrays/join.hpp>
#include <tapestry/autodiff/arrays/product.hpp>
#include <tapestry/autodiff/arrays/reduction.hpp>
#include <tapestry/autodiff/arrays/unary.hpp>
#include <tapestry/autodiff/arrays/view.hpp>
