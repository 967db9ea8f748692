#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/image/colour_space_variable.hpp>
#include <utility>
