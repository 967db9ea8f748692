# What our programs, benchmarks and tests write and read of a run: its folder, its manifest, and what built it.
include_guard(GLOBAL)
set(shell_dir ${CMAKE_CURRENT_LIST_DIR}/shell)
add_library(programs_record STATIC ${shell_dir}/build_facts.cpp ${shell_dir}/run_folder.cpp ${shell_dir}/run_manifest.cpp
                                    ${shell_dir}/run_origin.cpp)
target_link_libraries(programs_record PUBLIC tapestry_strict tapestry_float)

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
