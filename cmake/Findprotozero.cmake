# protozero has no CMake package of its own. Defines protozero::headers and protozero_VERSION.
find_path(protozero_INCLUDE_DIR protozero/pbf_reader.hpp)
if(protozero_INCLUDE_DIR)
  file(STRINGS "${protozero_INCLUDE_DIR}/protozero/version.hpp" protozero_version_line
       REGEX "define +PROTOZERO_VERSION_STRING" LIMIT_COUNT 1)
  string(REGEX MATCH "[0-9]+\\.[0-9]+\\.[0-9]+" protozero_VERSION "${protozero_version_line}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(protozero REQUIRED_VARS protozero_INCLUDE_DIR VERSION_VAR protozero_VERSION)
if(protozero_FOUND AND NOT TARGET protozero::headers)
  add_library(protozero::headers INTERFACE IMPORTED)
  target_include_directories(protozero::headers INTERFACE "${protozero_INCLUDE_DIR}")
endif()
mark_as_advanced(protozero_INCLUDE_DIR)
