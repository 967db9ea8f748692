# Names of Catch2 differ between its versions 2 and 3, so that tests take them from tests/support/catch.hpp alone.
# Usage: cmake -DTESTS_DIR=... -P check_catch.cmake
file(GLOB_RECURSE files RELATIVE ${TESTS_DIR} ${TESTS_DIR}/*.cpp ${TESTS_DIR}/*.hpp)
list(REMOVE_ITEM files support/catch.hpp)
foreach(file IN LISTS files)
  file(STRINGS ${TESTS_DIR}/${file} lines REGEX "Catch::|<catch2/")
  foreach(line IN LISTS lines)
    message(SEND_ERROR "tests/${file}: ${line}; expected a name of tests/support/catch.hpp")
  endforeach()
endforeach()
