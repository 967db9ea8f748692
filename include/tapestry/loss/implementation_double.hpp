#pragma once
/// \file
/// The compiled part of loss/ for double, beside implementation.hpp; see tapestry/implementation_double.hpp.
#include <tapestry/loss/implementation/adversarial.hpp>
#include <tapestry/loss/implementation/adversarial_terms.hpp>
#include <tapestry/loss/implementation/attention.hpp>
#include <tapestry/loss/implementation/cross_entropy.hpp>
#include <tapestry/loss/implementation/dynamic_match.hpp>
#include <tapestry/loss/implementation/mesh_regularity.hpp>
#include <tapestry/loss/implementation/printability.hpp>
#include <tapestry/loss/implementation/yolox_training.hpp>
/// \cond
#define TAPESTRY_SCALAR double
#include <tapestry/loss/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
