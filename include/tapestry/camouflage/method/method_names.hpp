#pragma once
#include <array>

namespace tapestry::camouflage {

/// All methods, as method_by_name() takes them.
inline constexpr std::array method_names{"fca",      "planar_patch", "camou",    "upc",    "das",
                                         "das_full", "rauca",        "mesh_adv", "random", "solid"};

}  // namespace tapestry::camouflage
