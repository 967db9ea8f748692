#pragma once
/// \file
/// All of nn/ that programs name: networks: layers, their adjoints, and networks read from files.
#include <tapestry/nn/activation.hpp>
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/network_pass.hpp>
#include <tapestry/nn/network/program.hpp>
#include <tapestry/nn/network/program_builder.hpp>
#include <tapestry/nn/network/staged_network.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <tapestry/nn/network/window_plan.hpp>
#include <tapestry/nn/network_variable.hpp>
#include <tapestry/nn/pointwise.hpp>
#include <tapestry/nn/workspace.hpp>
