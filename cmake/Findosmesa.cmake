# Mesa's off-screen interface, which draws with llvmpipe, as the target osmesa::osmesa.
find_path(OSMESA_INCLUDE_DIR GL/osmesa.h)
find_library(OSMESA_LIBRARY OSMesa)
mark_as_advanced(OSMESA_INCLUDE_DIR OSMESA_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(osmesa REQUIRED_VARS OSMESA_LIBRARY OSMESA_INCLUDE_DIR)
if(osmesa_FOUND AND NOT TARGET osmesa::osmesa)
  add_library(osmesa::osmesa INTERFACE IMPORTED)
  set_target_properties(osmesa::osmesa PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${OSMESA_INCLUDE_DIR}"
                                                  INTERFACE_LINK_LIBRARIES "${OSMESA_LIBRARY}")
endif()
