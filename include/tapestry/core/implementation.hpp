#pragma once
/// \file
/// The compiled part of core/, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/implementation/platform.hpp>

namespace tapestry {
extern const char include_tapestry_implementation_hpp_in_one_source_file_or_link_tapestry_compiled = 0;
}  // namespace tapestry
