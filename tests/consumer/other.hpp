#pragma once
#include <tapestry/core/array.hpp>

double smoothness_elsewhere(const tapestry::Array<float, 3>& render);
