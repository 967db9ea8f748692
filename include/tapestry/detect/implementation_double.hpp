#pragma once
/// \file
/// The compiled part of detect/ for double, beside implementation.hpp; see
/// tapestry/implementation_double.hpp.
#include <tapestry/detect/implementation/box_decode.hpp>
#include <tapestry/detect/implementation/darknet_model.hpp>
#include <tapestry/detect/implementation/detector.hpp>
#include <tapestry/detect/implementation/detector_variable.hpp>
#include <tapestry/detect/implementation/heat_map.hpp>
#include <tapestry/detect/implementation/network_config.hpp>
#include <tapestry/detect/implementation/network_description.hpp>
/// \cond
#define TAPESTRY_SCALAR double
#include <tapestry/detect/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
