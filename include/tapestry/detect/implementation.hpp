#pragma once
/// \file
/// The compiled part of detect/ for float, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/detect/implementation/box_decode.hpp>
#include <tapestry/detect/implementation/constant_name.hpp>
#include <tapestry/detect/implementation/darknet_model.hpp>
#include <tapestry/detect/implementation/decode_family.hpp>
#include <tapestry/detect/implementation/detector.hpp>
#include <tapestry/detect/implementation/detector_description.hpp>
#include <tapestry/detect/implementation/detector_variable.hpp>
#include <tapestry/detect/implementation/exported_heads.hpp>
#include <tapestry/detect/implementation/exported_structure.hpp>
#include <tapestry/detect/implementation/heat_map.hpp>
#include <tapestry/detect/implementation/named_export.hpp>
#include <tapestry/detect/implementation/network_config.hpp>
#include <tapestry/detect/implementation/network_config/shape.hpp>
#include <tapestry/detect/implementation/network_description.hpp>
#include <tapestry/detect/implementation/suppression.hpp>
/// \cond
#define TAPESTRY_SCALAR float
#include <tapestry/detect/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
