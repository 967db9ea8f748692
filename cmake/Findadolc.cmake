# ADOL-C as the target adolc::adolc. It ships no config.
find_path(ADOLC_INCLUDE_DIR adolc/adolc.h)
find_library(ADOLC_LIBRARY adolc)
mark_as_advanced(ADOLC_INCLUDE_DIR ADOLC_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(adolc REQUIRED_VARS ADOLC_LIBRARY ADOLC_INCLUDE_DIR)
if(adolc_FOUND AND NOT TARGET adolc::adolc)
  add_library(adolc::adolc INTERFACE IMPORTED)
  set_target_properties(adolc::adolc PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${ADOLC_INCLUDE_DIR}"
                                                INTERFACE_LINK_LIBRARIES "${ADOLC_LIBRARY}")
endif()
