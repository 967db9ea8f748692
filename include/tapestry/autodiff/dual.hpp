#pragma once
/// Forward mode: Dual, and its functions, which are those of Variable.
#include <tapestry/autodiff/dual_number.hpp>
#include <tapestry/autodiff/functions.hpp>
