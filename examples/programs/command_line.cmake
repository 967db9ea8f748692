# The command line of our programs and benchmarks, compiled once.
include_guard(GLOBAL)
find_package(CLI11 CONFIG REQUIRED)
include(${CMAKE_CURRENT_LIST_DIR}/record.cmake)
add_library(programs_command_line OBJECT ${CMAKE_CURRENT_LIST_DIR}/shell/command_line.cpp)
add_library(one_process STATIC ${CMAKE_CURRENT_LIST_DIR}/shell/one_process.cpp)  # for programs that bring no MPI
target_link_libraries(one_process PRIVATE tapestry_strict)
target_link_libraries(programs_command_line PUBLIC tapestry_strict tapestry_laboratory programs_record one_process
                                                   CLI11::CLI11)
