#pragma once
/// \file
/// The compiled part of image/ for float, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/image/implementation/letterbox.hpp>
#include <tapestry/image/implementation/over.hpp>
#include <tapestry/image/implementation/resize.hpp>
#include <tapestry/image/implementation/transform/camera_effects.hpp>
#include <tapestry/image/implementation/transform/chain.hpp>
#include <tapestry/image/implementation/transform/conditions.hpp>
#include <tapestry/image/implementation/transform/jpeg_compression.hpp>
#include <tapestry/image/implementation/transform/warp.hpp>
/// \cond
#define TAPESTRY_SCALAR float
#include <tapestry/image/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
