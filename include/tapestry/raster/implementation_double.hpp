#pragma once
/// \file
/// The compiled part of raster/ for double, beside implementation.hpp; see
/// tapestry/implementation_double.hpp.
#include <tapestry/raster/implementation/deferred.hpp>
#include <tapestry/raster/implementation/look_up.hpp>
#include <tapestry/raster/implementation/texture.hpp>
#include <tapestry/raster/implementation/texture_operator.hpp>
#include <tapestry/raster/implementation/vertex_gradient.hpp>
/// \cond
#define TAPESTRY_SCALAR double
#include <tapestry/raster/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
