#pragma once
/// \file
/// The parts of implementation.hpp for double. A program that computes in double includes this header, too,
/// in the same source file or in another one. tapestry::compiled has both.
#include <tapestry/detect/implementation_double.hpp>
#include <tapestry/image/implementation_double.hpp>
#include <tapestry/io/implementation_double.hpp>
#include <tapestry/loss/implementation_double.hpp>
#include <tapestry/nn/implementation_double.hpp>
#include <tapestry/raster/implementation_double.hpp>
