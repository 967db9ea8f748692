# libjpeg-turbo's own interface. Defines turbojpeg::turbojpeg, and turbojpeg_VERSION where its pkg-config file lies beside it.
find_path(turbojpeg_INCLUDE_DIR turbojpeg.h)
find_library(turbojpeg_LIBRARY turbojpeg)
cmake_path(GET turbojpeg_LIBRARY PARENT_PATH turbojpeg_folder)
if(EXISTS "${turbojpeg_folder}/pkgconfig/libturbojpeg.pc")
  file(STRINGS "${turbojpeg_folder}/pkgconfig/libturbojpeg.pc" turbojpeg_VERSION REGEX "^Version:" LIMIT_COUNT 1)
  string(REGEX REPLACE "^Version: *" "" turbojpeg_VERSION "${turbojpeg_VERSION}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(turbojpeg REQUIRED_VARS turbojpeg_LIBRARY turbojpeg_INCLUDE_DIR
                                            VERSION_VAR turbojpeg_VERSION)
if(turbojpeg_FOUND AND NOT TARGET turbojpeg::turbojpeg)
  add_library(turbojpeg::turbojpeg UNKNOWN IMPORTED)
  set_target_properties(turbojpeg::turbojpeg PROPERTIES IMPORTED_LOCATION "${turbojpeg_LIBRARY}"
                                                        INTERFACE_INCLUDE_DIRECTORIES "${turbojpeg_INCLUDE_DIR}")
endif()
mark_as_advanced(turbojpeg_INCLUDE_DIR turbojpeg_LIBRARY)
