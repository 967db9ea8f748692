#pragma once
/// \file
/// The compiled part of camouflage/, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/camouflage/implementation/car_shape.hpp>
#include <tapestry/camouflage/implementation/method/method.hpp>
#include <tapestry/camouflage/implementation/method/panels.hpp>
#include <tapestry/camouflage/implementation/objective.hpp>
#include <tapestry/camouflage/implementation/paint.hpp>
#include <tapestry/camouflage/implementation/paint_file.hpp>
#include <tapestry/camouflage/implementation/photo_light.hpp>
#include <tapestry/camouflage/implementation/photo_session.hpp>
#include <tapestry/camouflage/implementation/run_state.hpp>
#include <tapestry/camouflage/implementation/shape_parameter.hpp>
#include <tapestry/camouflage/implementation/training.hpp>
#include <tapestry/camouflage/implementation/view.hpp>
#include <tapestry/camouflage/implementation/worst_views.hpp>
/// \cond
#define TAPESTRY_SCALAR float
#include <tapestry/camouflage/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
