# The clang that Debian 12 brings, or else whatever clang there is. Programs under sanitizers have hundreds of MiB, which
# LLVM's linker, where it is installed, takes a quarter of the time for.
find_program(TAPESTRY_CLANG NAMES clang++-14 clang++ REQUIRED)
set(CMAKE_CXX_COMPILER ${TAPESTRY_CLANG})
find_program(TAPESTRY_LLD NAMES ld.lld)
if(TAPESTRY_LLD)
  set(CMAKE_EXE_LINKER_FLAGS_INIT -fuse-ld=lld)
  set(CMAKE_SHARED_LINKER_FLAGS_INIT -fuse-ld=lld)
endif()
