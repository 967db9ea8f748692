#pragma once
/// Forward mode: Dual, and its functions, which are those of Variable.
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/tape/dual_number.hpp>
