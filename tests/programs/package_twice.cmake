# cmake -DSOURCE_DIR=<sources> -DWORK_DIR=<folder> -P package_twice.cmake: two clones in folders of their own, the second compiled
# without ccache and later, give Debian packages of the same bytes.
cmake_minimum_required(VERSION 3.22)
file(REMOVE_RECURSE ${WORK_DIR})
execute_process(COMMAND nproc OUTPUT_VARIABLE jobs OUTPUT_STRIP_TRAILING_WHITESPACE)
foreach(clone IN ITEMS one another/clone)
  file(MAKE_DIRECTORY ${WORK_DIR}/${clone})
  set(run COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET WORKING_DIRECTORY ${WORK_DIR}/${clone})
  execute_process(COMMAND git -C ${SOURCE_DIR} ls-files -z --cached --others --exclude-standard
                  COMMAND sh -c "cd '${SOURCE_DIR}' && xargs -0 cp -p --parents -t '${WORK_DIR}/${clone}'" ${run})
  execute_process(COMMAND ${CMAKE_COMMAND} --preset release -DTAPESTRY_BUILD_TESTS=OFF -DTAPESTRY_BUILD_BENCHMARKS=OFF ${ccache} ${run})
  execute_process(COMMAND ${CMAKE_COMMAND} --build --preset release --parallel ${jobs} ${run})
  execute_process(COMMAND cpack --config build/release/CPackConfig.cmake -B ${WORK_DIR}/${clone}/packed ${run})
  set(ccache -DTAPESTRY_CCACHE=OFF)
endforeach()
file(GLOB packages RELATIVE ${WORK_DIR}/one/packed ${WORK_DIR}/one/packed/*.deb)
if(NOT packages)
  message(FATAL_ERROR "nothing was packed")
endif()
foreach(package IN LISTS packages)
  execute_process(COMMAND cmp ${WORK_DIR}/one/packed/${package} ${WORK_DIR}/another/clone/packed/${package}
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()
