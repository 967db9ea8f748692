# clang with libc++, the standard library of macOS, of emscripten and of Android. Libraries of Debian's that are written in C++
# were compiled for libstdc++: tests of these are left out.
include(${CMAKE_CURRENT_LIST_DIR}/clang.cmake)
set(CMAKE_CXX_FLAGS_INIT "-stdlib=libc++ -isystem ${CMAKE_CURRENT_LIST_DIR}/old_libcxx -Wgnu")
set(CMAKE_CXX_EXTENSIONS OFF)
foreach(package IN ITEMS opencv_dnn tinyobjloader MPI)
  set(CMAKE_DISABLE_FIND_PACKAGE_${package} ON)
endforeach()
set(TAPESTRY_CATCH_MAIN ON)
