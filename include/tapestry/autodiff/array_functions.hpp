#pragma once
/// Operations on array variables, each one record on the tape with a hand-written pullback.
#include <tapestry/autodiff/array_functions/elementwise.hpp>
#include <tapestry/autodiff/array_functions/product.hpp>
#include <tapestry/autodiff/array_functions/reduction.hpp>
