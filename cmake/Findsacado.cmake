# Trilinos' Sacado as the target sacado::sacado. Its own config wants all packages that it was built with.
find_path(SACADO_INCLUDE_DIR Sacado_trad.hpp PATH_SUFFIXES trilinos)
find_path(KOKKOS_INCLUDE_DIR Kokkos_Macros.hpp PATH_SUFFIXES trilinos)
find_library(SACADO_LIBRARY NAMES trilinos_sacado sacado)
mark_as_advanced(SACADO_INCLUDE_DIR KOKKOS_INCLUDE_DIR SACADO_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(sacado REQUIRED_VARS SACADO_LIBRARY SACADO_INCLUDE_DIR KOKKOS_INCLUDE_DIR)
if(sacado_FOUND AND NOT TARGET sacado::sacado)
  add_library(sacado::sacado INTERFACE IMPORTED)
  set_target_properties(sacado::sacado PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${SACADO_INCLUDE_DIR}"
                                                  INTERFACE_LINK_LIBRARIES "${SACADO_LIBRARY}")
endif()
