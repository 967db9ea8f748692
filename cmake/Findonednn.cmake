# oneDNN as the target onednn::onednn. Its own config, as Debian ships it, asks for OpenCL's development files.
find_path(ONEDNN_INCLUDE_DIR oneapi/dnnl/dnnl.hpp)
find_library(ONEDNN_LIBRARY dnnl)
mark_as_advanced(ONEDNN_INCLUDE_DIR ONEDNN_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(onednn REQUIRED_VARS ONEDNN_LIBRARY ONEDNN_INCLUDE_DIR)
if(onednn_FOUND AND NOT TARGET onednn::onednn)
  add_library(onednn::onednn INTERFACE IMPORTED)
  set_target_properties(onednn::onednn PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${ONEDNN_INCLUDE_DIR}"
                                                  INTERFACE_LINK_LIBRARIES "${ONEDNN_LIBRARY}")
endif()
