#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/image/crop.hpp>
#include <tapestry/image/crop_variable.hpp>
