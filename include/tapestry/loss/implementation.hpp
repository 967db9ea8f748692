#pragma once
/// \file
/// The compiled part of loss/ for float, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/loss/implementation/adversarial.hpp>
#include <tapestry/loss/implementation/adversarial_names.hpp>
#include <tapestry/loss/implementation/adversarial_terms.hpp>
#include <tapestry/loss/implementation/attention.hpp>
#include <tapestry/loss/implementation/cross_entropy.hpp>
#include <tapestry/loss/implementation/dynamic_match.hpp>
#include <tapestry/loss/implementation/mesh_regularity.hpp>
#include <tapestry/loss/implementation/overlap.hpp>
#include <tapestry/loss/implementation/printability.hpp>
#include <tapestry/loss/implementation/printable_colours.hpp>
#include <tapestry/loss/implementation/yolo_training.hpp>
#include <tapestry/loss/implementation/yolox_training.hpp>
/// \cond
#define TAPESTRY_SCALAR float
#include <tapestry/loss/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
