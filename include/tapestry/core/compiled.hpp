#pragma once

namespace tapestry {
/// Defined by tapestry/implementation.hpp. If that is missing, or included twice, the linker's message about
/// this name states the remedy.
extern const char include_tapestry_implementation_hpp_in_one_source_file_or_link_tapestry_compiled;

namespace detail {
/// Refers to that name in every program that includes a header whose bodies are compiled once: eight bytes a
/// program, for the linker keeps one copy.
#ifdef __ELF__
[[gnu::retain]]
#endif
[[gnu::used]] inline const char* const compiled_part =
    &include_tapestry_implementation_hpp_in_one_source_file_or_link_tapestry_compiled;
}  // namespace detail
}  // namespace tapestry
