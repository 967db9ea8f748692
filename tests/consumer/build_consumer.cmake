# Configures the consumer in BINARY_DIR with OPTION, builds it, checks that Tapestry gave it no flag that changes
# code, and runs it.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE "${BINARY_DIR}")
run("${CMAKE_COMMAND}" -S "${SOURCE_DIR}" -B "${BINARY_DIR}" -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${COMPILER}" "${OPTION}")
run("${CMAKE_COMMAND}" --build "${BINARY_DIR}")

file(READ "${BINARY_DIR}/compile_commands.json" commands)
if(commands MATCHES " (-march|-mtune|-mavx|-mfma|-msse|-mf16c|-O|-g|-ffast-math|-fsanitize)[^ ]*")
  message(FATAL_ERROR "a flag of ours reached the consumer: ${CMAKE_MATCH_0}\n${commands}")
endif()
run("${CMAKE_COMMAND}" -E chdir "${BINARY_DIR}" ./consumer)
