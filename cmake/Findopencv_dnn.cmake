# OpenCV's dnn module as the target opencv_dnn::opencv_dnn. Debian's small packages bring no config of their own.
find_path(OPENCV_INCLUDE_DIR opencv2/dnn.hpp PATH_SUFFIXES opencv4)
find_library(OPENCV_CORE_LIBRARY opencv_core)
find_library(OPENCV_DNN_LIBRARY opencv_dnn)
mark_as_advanced(OPENCV_INCLUDE_DIR OPENCV_CORE_LIBRARY OPENCV_DNN_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(opencv_dnn REQUIRED_VARS OPENCV_DNN_LIBRARY OPENCV_CORE_LIBRARY
                                                           OPENCV_INCLUDE_DIR)
if(opencv_dnn_FOUND AND NOT TARGET opencv_dnn::opencv_dnn)
  add_library(opencv_dnn::opencv_dnn INTERFACE IMPORTED)
  set_target_properties(opencv_dnn::opencv_dnn PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${OPENCV_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${OPENCV_DNN_LIBRARY};${OPENCV_CORE_LIBRARY}")
endif()
