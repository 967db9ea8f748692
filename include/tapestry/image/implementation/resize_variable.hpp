#pragma once
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/resize.hpp>
#include <tapestry/image/resize_variable.hpp>
