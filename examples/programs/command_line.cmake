# The command line of our programs and benchmarks, compiled once.
include_guard(GLOBAL)
find_package(CLI11 CONFIG REQUIRED)
add_library(programs_command_line OBJECT ${CMAKE_CURRENT_LIST_DIR}/shell/command_line.cpp)
target_link_libraries(programs_command_line PUBLIC tapestry_strict CLI11::CLI11)
