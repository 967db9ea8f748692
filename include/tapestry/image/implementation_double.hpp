#pragma once
/// \file
/// The compiled part of image/ for double, beside implementation.hpp; see tapestry/implementation_double.hpp.
#include <tapestry/image/implementation/over.hpp>
#include <tapestry/image/implementation/resize.hpp>
#include <tapestry/image/implementation/transform/camera_effects.hpp>
#include <tapestry/image/implementation/transform/chain.hpp>
#include <tapestry/image/implementation/transform/jpeg_compression.hpp>
#include <tapestry/image/implementation/transform/warp.hpp>
/// \cond
#define TAPESTRY_SCALAR double
#include <tapestry/image/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
