#pragma once
#include <tapestry/core/array.hpp>

double smoothness_elsewhere(const tapestry::Array<double, 3>& render);
