#pragma once
/// \file
/// The parts of the library that are compiled once, for float: exactly one source file of a program includes
/// this header, or the program links the CMake target tapestry::compiled, which is made of it and of
/// implementation_double.hpp. The tape alone needs neither; laboratory_implementation.hpp includes this, too.
/// A file for each `<room>/implementation.hpp` instead takes a compiler less memory at a time.
#include <tapestry/io/implementation.hpp>  // first, for it must see stb before anyone else

#include <tapestry/core/implementation.hpp>
#include <tapestry/detect/implementation.hpp>
#include <tapestry/geometry/implementation.hpp>
#include <tapestry/image/implementation.hpp>
#include <tapestry/loss/implementation.hpp>
#include <tapestry/nn/implementation.hpp>
#include <tapestry/raster/implementation.hpp>
