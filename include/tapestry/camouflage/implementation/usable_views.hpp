#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/camouflage/usable_views.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <vector>
