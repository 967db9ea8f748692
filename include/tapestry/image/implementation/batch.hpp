#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/image/batch.hpp>
#include <vector>
