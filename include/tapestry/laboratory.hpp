#pragma once
/// \file
/// Experiments on top of the library: the camouflage of a car, and the measurements that judge it. This
/// header includes all of it but laboratory_implementation.hpp: one source file of a program includes that,
/// or the program links tapestry::laboratory.
///
///   segment                       picture to mask of the car
///   camouflage                    parameters, objective and training
///   evaluate                      meter, controls and rates that judge an attack
#include <tapestry/camouflage.hpp>
#include <tapestry/evaluate.hpp>
#include <tapestry/segment.hpp>
#include <tapestry/tapestry.hpp>
