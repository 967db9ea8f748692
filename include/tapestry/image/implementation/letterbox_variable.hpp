#pragma once
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/image/letterbox_variable.hpp>
