# The command line of our programs and benchmarks, compiled once.
include_guard(GLOBAL)
find_package(CLI11 CONFIG REQUIRED)
include(${CMAKE_CURRENT_LIST_DIR}/record.cmake)
# Where a program finds what is bundled, seen from its own folder, installed and in this folder: an installed program then has
# the same bytes wherever it was built.
include(GNUInstallDirs)
file(RELATIVE_PATH installed_assets ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/tapestry/assets)
file(REAL_PATH ${PROJECT_BINARY_DIR}/examples built_programs)
file(REAL_PATH ${CMAKE_CURRENT_LIST_DIR}/../assets assets)
file(RELATIVE_PATH built_assets ${built_programs} ${assets})
add_library(programs_command_line OBJECT ${CMAKE_CURRENT_LIST_DIR}/shell/command_line.cpp
                                         ${CMAKE_CURRENT_LIST_DIR}/shell/bundled_folder.cpp)
set_source_files_properties(${CMAKE_CURRENT_LIST_DIR}/shell/bundled_folder.cpp PROPERTIES COMPILE_DEFINITIONS
  "TAPESTRY_ASSETS=\"${built_assets}\";TAPESTRY_INSTALLED_ASSETS=\"${installed_assets}\"")
add_library(one_process STATIC ${CMAKE_CURRENT_LIST_DIR}/shell/one_process.cpp)  # for programs that bring no MPI
target_link_libraries(one_process PRIVATE tapestry_strict)
target_link_libraries(programs_command_line PUBLIC tapestry_strict tapestry_laboratory programs_record one_process
                                                   CLI11::CLI11)
