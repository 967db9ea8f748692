# Darknet's library as the target darknet::darknet, from where Debian keeps it.
find_path(DARKNET_INCLUDE_DIR darknet.h PATHS /usr/lib/darknet/include)
find_library(DARKNET_LIBRARY darknet PATHS /usr/lib/darknet)
mark_as_advanced(DARKNET_INCLUDE_DIR DARKNET_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(darknet REQUIRED_VARS DARKNET_LIBRARY DARKNET_INCLUDE_DIR)
if(darknet_FOUND AND NOT TARGET darknet::darknet)
  add_library(darknet::darknet INTERFACE IMPORTED)
  set_target_properties(darknet::darknet PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${DARKNET_INCLUDE_DIR}"
                                                    INTERFACE_LINK_LIBRARIES "${DARKNET_LIBRARY}")
endif()
