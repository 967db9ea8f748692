#pragma once
/// \file
/// Experiments on top of the library: the camouflage of a car, and the measurements that judge it. This
/// header includes all of it but laboratory_implementation.hpp: one source file of a program includes that,
/// or the program links tapestry::laboratory.
///
///   segment                       picture to mask of the car
///   camouflage                    parameters, objective and training
///   evaluate                      meter, controls and rates that judge an attack
#include <tapestry/camouflage/drawn_views.hpp>
#include <tapestry/camouflage/ensemble.hpp>
#include <tapestry/camouflage/method/comparators.hpp>
#include <tapestry/camouflage/method/method.hpp>
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
#include <tapestry/evaluate/average_precision.hpp>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/dataset/readers.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/fate.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <tapestry/evaluate/paired_bootstrap.hpp>
#include <tapestry/evaluate/protocol_cells.hpp>
#include <tapestry/evaluate/protocol_outcomes.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>
#include <tapestry/evaluate/views.hpp>
#include <tapestry/segment/car_component.hpp>
#include <tapestry/segment/u2_net.hpp>
#include <tapestry/segment/u2_net_description.hpp>
#include <tapestry/tapestry.hpp>
