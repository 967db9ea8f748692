#pragma once
#include <tapestry/image/colour_space_variable.hpp>

namespace tapestry::image {

template ArrayVariable<float, 2> linearised<float, 2>(const ArrayVariable<float, 2>& colours);
template ArrayVariable<float, 3> linearised<float, 3>(const ArrayVariable<float, 3>& colours);
template ArrayVariable<double, 2> linearised<double, 2>(const ArrayVariable<double, 2>& colours);
template ArrayVariable<double, 3> linearised<double, 3>(const ArrayVariable<double, 3>& colours);
template ArrayVariable<float, 2> encoded<float, 2>(const ArrayVariable<float, 2>& light);
template ArrayVariable<float, 3> encoded<float, 3>(const ArrayVariable<float, 3>& light);
template ArrayVariable<double, 2> encoded<double, 2>(const ArrayVariable<double, 2>& light);
template ArrayVariable<double, 3> encoded<double, 3>(const ArrayVariable<double, 3>& light);

}  // namespace tapestry::image
