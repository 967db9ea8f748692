#pragma once
/// Operations on array variables: formulas that are computed and pulled back in one pass each, and records
/// with a hand-written pullback.
#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/autodiff/detail/arrays/extreme.hpp>
#include <tapestry/autodiff/detail/arrays/join.hpp>
#include <tapestry/autodiff/detail/arrays/product.hpp>
#include <tapestry/autodiff/detail/arrays/second_order.hpp>
#include <tapestry/autodiff/detail/arrays/twins.hpp>
#include <tapestry/autodiff/detail/arrays/view.hpp>
