# libtorch as the target libtorch::libtorch. Its own config, as Debian ships it, asks for the development packages of
# everything that it was built with.
find_path(LIBTORCH_INCLUDE_DIR torch/library.h)
find_path(LIBTORCH_API_INCLUDE_DIR torch/torch.h PATH_SUFFIXES torch/csrc/api/include)
find_library(LIBTORCH_LIBRARY torch)
find_library(LIBTORCH_CPU_LIBRARY torch_cpu)
find_library(LIBTORCH_C10_LIBRARY c10)
mark_as_advanced(LIBTORCH_INCLUDE_DIR LIBTORCH_API_INCLUDE_DIR LIBTORCH_LIBRARY LIBTORCH_CPU_LIBRARY LIBTORCH_C10_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(libtorch REQUIRED_VARS LIBTORCH_CPU_LIBRARY LIBTORCH_LIBRARY LIBTORCH_C10_LIBRARY
                                                         LIBTORCH_API_INCLUDE_DIR LIBTORCH_INCLUDE_DIR)
if(libtorch_FOUND AND NOT TARGET libtorch::libtorch)
  add_library(libtorch::libtorch INTERFACE IMPORTED)
  set_target_properties(libtorch::libtorch PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${LIBTORCH_INCLUDE_DIR};${LIBTORCH_API_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${LIBTORCH_LIBRARY};${LIBTORCH_CPU_LIBRARY};${LIBTORCH_C10_LIBRARY}")
endif()
