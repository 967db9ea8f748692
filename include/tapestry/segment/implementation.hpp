#pragma once
/// \file
/// The compiled part of segment/, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/segment/implementation/u2_net.hpp>
#include <tapestry/segment/implementation/u2_net_description.hpp>
