#pragma once
/// Forward mode: Dual, and its functions, which are those of Variable.
#include <tapestry/autodiff/detail/tape/dual_number.hpp>
#include <tapestry/autodiff/functions.hpp>
