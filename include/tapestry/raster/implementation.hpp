#pragma once
/// \file
/// The compiled part of raster/ for float, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/raster/implementation/deferred.hpp>
#include <tapestry/raster/implementation/estimated_light.hpp>
#include <tapestry/raster/implementation/face_field.hpp>
#include <tapestry/raster/implementation/grazing_faces.hpp>
#include <tapestry/raster/implementation/look_up.hpp>
#include <tapestry/raster/implementation/mesh_edges.hpp>
#include <tapestry/raster/implementation/mip_pyramid.hpp>
#include <tapestry/raster/implementation/outline_crossings.hpp>
#include <tapestry/raster/implementation/raster_kernels.hpp>
#include <tapestry/raster/implementation/scene.hpp>
#include <tapestry/raster/implementation/texture.hpp>
#include <tapestry/raster/implementation/texture_charts.hpp>
#include <tapestry/raster/implementation/texture_operator.hpp>
#include <tapestry/raster/implementation/vertex_gradient.hpp>
#include <tapestry/raster/implementation/visibility.hpp>
/// \cond
#define TAPESTRY_SCALAR float
#include <tapestry/raster/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
