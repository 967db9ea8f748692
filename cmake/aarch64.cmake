# Builds for 64-bit ARM on another Debian: its compiler is of g++-aarch64-linux-gnu, and qemu-user runs what it makes. Headers
# that are the same for every processor are this machine's; of libraries it needs zlib1g-dev:arm64 alone, installed or unpacked
# into a folder that CMAKE_PREFIX_PATH names (tests/reach/arm64_libraries.sh does that).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
if(NOT DEFINED CMAKE_CXX_COMPILER)
  set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
endif()
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)  # notes about how g++ 5 passed structures
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/aarch64-linux-gnu)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
file(GLOB xtensor_DIR /usr/lib/*/cmake/xtensor)
set(TAPESTRY_MPI OFF CACHE BOOL "MPI of this machine is for its own processor")
set(TAPESTRY_PYTHON OFF CACHE BOOL "Python of this machine is for its own processor")
