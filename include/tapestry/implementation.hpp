#pragma once
/// \file
/// The parts of the library that are compiled once: exactly one source file of a program includes this
/// header, or the program links the CMake target tapestry::compiled, which is made of it. The tape alone
/// needs neither; laboratory_implementation.hpp includes this, too.
#include <tapestry/io/implementation.hpp>  // first, for it must see stb before anyone else

#include <tapestry/core/implementation.hpp>
#include <tapestry/detect/implementation.hpp>
#include <tapestry/geometry/implementation.hpp>
#include <tapestry/image/implementation.hpp>
#include <tapestry/loss/implementation.hpp>
#include <tapestry/nn/implementation.hpp>
#include <tapestry/raster/implementation.hpp>
