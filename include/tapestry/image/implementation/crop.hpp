#pragma once
#include <algorithm>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/image/crop.hpp>
#include <tapestry/image/pixel_window.hpp>
