# Embree 3 as the target embree3::embree3. Its own package file is not used: it asks for oneTBB's, which differs
# between distributions.
find_path(EMBREE3_INCLUDE_DIR embree3/rtcore.h)
find_library(EMBREE3_LIBRARY embree3)
mark_as_advanced(EMBREE3_INCLUDE_DIR EMBREE3_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(embree3 REQUIRED_VARS EMBREE3_LIBRARY EMBREE3_INCLUDE_DIR)
if(embree3_FOUND AND NOT TARGET embree3::embree3)
  add_library(embree3::embree3 INTERFACE IMPORTED)
  set_target_properties(embree3::embree3 PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${EMBREE3_INCLUDE_DIR}"
                                                    INTERFACE_LINK_LIBRARIES "${EMBREE3_LIBRARY}")
endif()
