# Installs Tapestry into a temporary folder and builds, links and runs the consumer project against that;
# then the same with Tapestry as a subfolder of the consumer.
set(consumer_dir ${CMAKE_CURRENT_BINARY_DIR}/consumer)
set(consumer_command ${CMAKE_COMMAND} -DSOURCE_DIR=${CMAKE_CURRENT_SOURCE_DIR}/consumer
                     -DCOMPILER=${CMAKE_CXX_COMPILER} -DGENERATOR=${CMAKE_GENERATOR})
set(build_consumer -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/build_consumer.cmake)

if(TAPESTRY_INSTALL)
  add_test(NAME "consumer: install"
           COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --prefix ${consumer_dir}/prefix)
  set_tests_properties("consumer: install" PROPERTIES FIXTURES_SETUP installed_tapestry)
  add_test(NAME "consumer: find_package"
           COMMAND ${consumer_command} -DBINARY_DIR=${consumer_dir}/installed
                   -DOPTION=-DCMAKE_PREFIX_PATH=${consumer_dir}/prefix ${build_consumer})
  set_tests_properties("consumer: find_package" PROPERTIES FIXTURES_REQUIRED installed_tapestry TIMEOUT 300)
endif()
add_test(NAME "consumer: add_subdirectory"
         COMMAND ${consumer_command} -DBINARY_DIR=${consumer_dir}/subfolder
                 -DOPTION=-DTAPESTRY_SOURCES=${PROJECT_SOURCE_DIR} ${build_consumer})
set_tests_properties("consumer: add_subdirectory" PROPERTIES TIMEOUT 300)
