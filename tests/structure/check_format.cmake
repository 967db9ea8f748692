# Fails when clang-format would change a source file.
file(GLOB_RECURSE sources "${SOURCE_DIR}/include/*.hpp" "${SOURCE_DIR}/include/*.inl"
     "${SOURCE_DIR}/examples/*.[ch]pp" "${SOURCE_DIR}/tests/*.[ch]pp" "${SOURCE_DIR}/benchmarks/*.[ch]pp")
execute_process(COMMAND "${CLANG_FORMAT}" --dry-run -Werror --ferror-limit=1 ${sources} RESULT_VARIABLE result
                ERROR_VARIABLE complaint)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "unformatted; \"clang-format-14 -i\" on these files mends it\n${complaint}")
endif()
