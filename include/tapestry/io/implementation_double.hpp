#pragma once
/// \file
/// The compiled part of io/ for double, beside implementation.hpp; see tapestry/implementation_double.hpp.
#include <tapestry/io/implementation/darknet/model_file.hpp>
#include <tapestry/io/implementation/image_file.hpp>
#include <tapestry/io/implementation/mesh_writers.hpp>
#include <tapestry/io/implementation/read_detector.hpp>
/// \cond
#define TAPESTRY_SCALAR double
#include <tapestry/io/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
