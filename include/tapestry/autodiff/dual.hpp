#pragma once
/// Forward mode: Dual, with the functions of Variable.
#include <tapestry/autodiff/detail/tape/dual_number.hpp>
#include <tapestry/autodiff/functions.hpp>
