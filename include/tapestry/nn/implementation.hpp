#pragma once
/// \file
/// The compiled part of nn/ for float, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/nn/implementation/network/decompositions.hpp>
#include <tapestry/nn/implementation/network/description.hpp>
#include <tapestry/nn/implementation/network/network.hpp>
#include <tapestry/nn/implementation/network/network_pass.hpp>
#include <tapestry/nn/implementation/network/operators.hpp>
#include <tapestry/nn/implementation/network/program_builder.hpp>
#include <tapestry/nn/implementation/network/program_parts.hpp>
#include <tapestry/nn/implementation/network/staged_network.hpp>
#include <tapestry/nn/implementation/network/tangent_network.hpp>
#include <tapestry/nn/implementation/network_variable.hpp>
#include <tapestry/nn/implementation/vector_kernels.hpp>
/// \cond
#define TAPESTRY_SCALAR float
#include <tapestry/nn/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond
