# The clang that Debian 12 brings, or else whatever clang there is.
find_program(TAPESTRY_CLANG NAMES clang++-14 clang++ REQUIRED)
set(CMAKE_CXX_COMPILER ${TAPESTRY_CLANG})
