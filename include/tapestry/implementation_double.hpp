#pragma once
/// \file
/// What implementation.hpp brings, for double: a program that computes in double includes this, too, in the
/// same source file or in another one. tapestry::compiled has both.
#include <tapestry/detect/implementation_double.hpp>
#include <tapestry/image/implementation_double.hpp>
#include <tapestry/io/implementation_double.hpp>
#include <tapestry/loss/implementation_double.hpp>
#include <tapestry/nn/implementation_double.hpp>
#include <tapestry/raster/implementation_double.hpp>
