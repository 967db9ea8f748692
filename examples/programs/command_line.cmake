# The command line of our programs and benchmarks, and what they say they are, compiled once.
include_guard(GLOBAL)
find_package(CLI11 CONFIG REQUIRED)
set(shell_dir ${CMAKE_CURRENT_LIST_DIR}/shell)
add_library(programs_command_line OBJECT ${shell_dir}/command_line.cpp ${shell_dir}/build_facts.cpp)
add_library(one_process STATIC ${shell_dir}/one_process.cpp)  # for programs that bring no MPI
target_link_libraries(one_process PRIVATE tapestry_strict)
target_link_libraries(programs_command_line PUBLIC tapestry_strict tapestry_laboratory one_process CLI11::CLI11)

# The commit of the sources, where they are a repository of their own. CMake runs again after the next one.
find_package(Git QUIET)
if(GIT_FOUND AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
  set(git ${GIT_EXECUTABLE} -C ${PROJECT_SOURCE_DIR})
  execute_process(COMMAND ${git} describe --always --abbrev=40 --exclude=* --dirty=-changed
                  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND ${git} rev-parse --git-path logs/HEAD
                  OUTPUT_VARIABLE log OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  cmake_path(ABSOLUTE_PATH log BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
  if(commit AND EXISTS ${log})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${log})
    set_source_files_properties(${shell_dir}/build_facts.cpp PROPERTIES COMPILE_DEFINITIONS "TAPESTRY_COMMIT=\"${commit}\"")
  endif()
endif()
