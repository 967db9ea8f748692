#pragma once
/// \file
/// All of camouflage/ that programs name: parameters, objective and training of a camouflage.
#include <tapestry/camouflage/ensemble.hpp>
#include <tapestry/camouflage/method/comparators.hpp>
#include <tapestry/camouflage/method/methods.hpp>
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/camouflage/objective_terms.hpp>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/photo_light.hpp>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/camouflage/profile.hpp>
#include <tapestry/camouflage/run_state.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/camouflage/training.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/camouflage/view_store.hpp>
