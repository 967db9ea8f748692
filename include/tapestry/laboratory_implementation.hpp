#pragma once
/// \file implementation.hpp, and the laboratory's parts that are compiled once, for float:
/// exactly one source file of a program includes this header, or the program links the CMake
/// target tapestry::laboratory.
#include <tapestry/implementation.hpp>  // first, for it must see stb before anyone else

#include <tapestry/camouflage/implementation.hpp>
#include <tapestry/evaluate/implementation.hpp>
#include <tapestry/segment/implementation.hpp>
