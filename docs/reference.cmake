# Builds the reference with DOXYGEN from DOXYFILE, whose warnings go to WARNINGS, and fails at the first that counts.
# Every type and every function of a namespace needs a comment; a member of a type may be told by its name.
file(REMOVE "${WARNINGS}")
execute_process(COMMAND "${DOXYGEN}" "${DOXYFILE}" RESULT_VARIABLE result ERROR_VARIABLE complaint)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "doxygen failed\n${complaint}")
endif()
file(READ "${WARNINGS}" warnings)
string(REGEX REPLACE "[^\n]*: warning: Member [^\n]* of (struct|class) [^\n]* is not documented\\.\n" "" warnings
                     "${warnings}")
string(STRIP "${warnings}" warnings)
if(warnings)
  message(FATAL_ERROR "the reference has warnings\n${warnings}")
endif()
